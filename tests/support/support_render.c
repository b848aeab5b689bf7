/* Common code of tests of the renderers: small volumes, requests and pictures. */
#include "test.h"

#include "support_render.h"

#include "base/for_type.h"
#include "codec/rate/compress_terms.h"
cvol_volume support_volume(size_t nx, size_t ny, size_t nz, cvol_type type)
{
    cvol_volume volume = {.grid = cvol_grid_make(nx, ny, nz, type)};
    volume.data = calloc(nx * ny * nz, cvol_type_size(type));
    assert_non_null(volume.data);
    return volume;
}

double support_sample(const cvol_volume *volume, size_t i)
{
    double value = 0;
#define GET(t) value = (double)((const t *)volume->data)[i]
    CVOL_FOR_TYPE(volume->grid.type, GET);
#undef GET
    return value;
}

size_t support_index(const cvol_volume *volume, size_t x, size_t y, size_t z)
{
    return x + volume->grid.dims[0] * (y + volume->grid.dims[1] * z);
}

cvol_volume support_blobs(size_t nx, size_t ny, size_t nz)
{
    cvol_volume volume = support_volume(nx, ny, nz, CVOL_FLOAT32);
    const double centres[3][4] = {{.3, .4, .5, 60}, {.7, .6, .3, 90}, {.5, .75, .7, 40}};
    for (size_t z = 0; z < nz; z++)
        for (size_t y = 0; y < ny; y++)
            for (size_t x = 0; x < nx; x++) {
                double value = 0, p[3] = {(double)x / (double)nx, (double)y / (double)ny,
                                          (double)z / (double)nz};
                for (int k = 0; k < 3; k++) {
                    double r2 = 0;
                    for (int a = 0; a < 3; a++)
                        r2 += (p[a] - centres[k][a]) * (p[a] - centres[k][a]);
                    value += centres[k][3] * exp(-r2 / 0.02);
                }
                ((float *)volume.data)[support_index(&volume, x, y, z)] = (float)value;
            }
    return volume;
}

const cvol_transfer_point support_blob_points[SUPPORT_BLOB_POINTS] = {
    {5, 0.2, 0.1, 0.6, 0}, {30, 0.9, 0.3, 0.1, 0.05}, {60, 1, 0.9, 0.5, 0.2}, {90, 1, 1, 1, 0.4}};

cvol_render_options support_square(int size, cvol_mode mode, double azimuth, double elevation)
{
    cvol_render_options options = cvol_render_options_defaults();
    options.width = options.height = size;
    options.mode = mode;
    options.camera.azimuth_deg = azimuth;
    options.camera.elevation_deg = elevation;
    options.sheet.ray_order = CVOL_RAY_ORDER_IMAGE; /* where that is possible, in all tests */
    return options;
}

void support_set_transfer(cvol_context *context, cvol_renderer *renderer,
                          const cvol_transfer_point *points, size_t count)
{
    cvol_transfer *transfer;
    assert_int_equal(cvol_transfer_create(context, &transfer, points, count), CVOL_OK);
    assert_int_equal(cvol_renderer_set_transfer(context, renderer, transfer), CVOL_OK);
    cvol_transfer_free(transfer); /* the renderer has its own */
}

cvol_image *support_picture(cvol_context *context, cvol_renderer *renderer,
                            const cvol_render_options *options)
{
    cvol_image *image;
    assert_int_equal(cvol_image_create(context, &image, options->width, options->height), CVOL_OK);
    int code = cvol_renderer_render(context, renderer, image, options);
    if (code)
        fail_msg("%s", cvol_context_message(context));
    for (int i = 0; i < image->width * image->height; i++)
        assert_int_equal(image->rgba[4 * i + 3], 255);
    return image;
}

cvol_array *support_compress(cvol_context *context, const cvol_volume *volume, int block,
                             double psnr_db)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    options.block = block;
    options.target = CVOL_TARGET_PSNR;
    options.target_value = psnr_db;
    cvol_array *array;
    cvol_compress_report report; /* terms, whatever a lossless file would take */
    if (cvol_compress_terms(context, &array, &report, volume->data, &volume->grid, &options) ||
        !array)
        fail_msg("%s", cvol_context_message(context));
    return array;
}

static cvol_image *draw_and_free(cvol_context *context, cvol_renderer *renderer,
                                 const cvol_transfer_point *points, size_t count,
                                 const cvol_render_options *options)
{
    if (points)
        support_set_transfer(context, renderer, points, count);
    cvol_image *image = support_picture(context, renderer, options);
    cvol_renderer_free(renderer);
    return image;
}

cvol_image *support_sheet(cvol_context *context, const cvol_array *array,
                          const cvol_transfer_point *points, size_t count,
                          const cvol_render_options *options)
{
    cvol_renderer *renderer;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    return draw_and_free(context, renderer, points, count, options);
}

cvol_image *support_ray(cvol_context *context, const cvol_volume *volume,
                        const cvol_transfer_point *points, size_t count,
                        const cvol_render_options *options)
{
    cvol_renderer *renderer;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_RAY, CVOL_SOURCE(.volume = volume)),
        CVOL_OK);
    return draw_and_free(context, renderer, points, count, options);
}

cvol_image *support_ray_masked(cvol_context *context, const cvol_volume *volume,
                               const uint8_t *which, const cvol_transfer_point *points,
                               size_t count, cvol_render_options options)
{
    cvol_renderer *renderer;
    options.step_voxels = 0.25;
    options.oversample = 0;
    assert_int_equal(cvol_renderer_create(context, &renderer, CVOL_ENGINE_RAY,
                                          CVOL_SOURCE(.volume = volume, .mask = which)),
                     CVOL_OK);
    return draw_and_free(context, renderer, points, count, &options);
}

const uint8_t *support_pixel(const cvol_image *image, int i, int j)
{
    return image->rgba + 4 * (j * image->width + i);
}

int support_difference(const cvol_image *a, const cvol_image *b)
{
    int largest = 0;
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    for (int i = 0; i < 4 * a->width * a->height; i++)
        if (abs(a->rgba[i] - b->rgba[i]) > largest)
            largest = abs(a->rgba[i] - b->rgba[i]);
    return largest;
}

double support_psnr(const cvol_image *a, const cvol_image *b)
{
    double sum = 0;
    const int count = a->width * a->height;
    for (int i = 0; i < 4 * count; i++)
        sum += (a->rgba[i] - b->rgba[i]) * (a->rgba[i] - b->rgba[i]);
    return sum > 0 ? 10 * log10(255.0 * 255.0 * 3 * count / sum) : 99;
}

double support_sheet_db(cvol_context *context, const cvol_array *array, const cvol_volume *volume,
                        const cvol_transfer_point *points, size_t count,
                        cvol_render_options options)
{
    cvol_image *sheet = support_sheet(context, array, points, count, &options);
    options.step_voxels = 0.125;
    cvol_image *ray = support_ray(context, volume, points, count, &options);
    const double db = support_psnr(sheet, ray);
    cvol_image_free(sheet);
    cvol_image_free(ray);
    return db;
}
