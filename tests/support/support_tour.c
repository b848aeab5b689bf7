/* A tour of the library's functions, in small steps. */
#include "support_tour.h"

#include <math.h>
#include <stdlib.h>

int tour_begin(tour *t, cvol_context *context, const char *path)
{
    const size_t nx = 70, ny = 66, nz = 40;
    *t = (tour){.context = context, .path = path};
    t->volume.grid = cvol_grid_make(nx, ny, nz, CVOL_FLOAT32);
    float *samples = malloc(nx * ny * nz * sizeof *samples);
    t->volume.data = samples;
    for (size_t i = 0; samples && i < nx * ny * nz; i++) {
        const double x = (double)(i % nx) - 30, y = (double)(i / nx % ny) - 36;
        const double z = (double)(i / nx / ny) - 18;
        samples[i] = (float)(90 * exp(-(x * x + y * y + 2 * z * z) / 400) + cos(x * y * 0.3));
    }
    return samples != NULL;
}

/* ---- compressing ------------------------------------------------------------------------ */

static int compress(tour *t, cvol_array **out, const cvol_compress_options *options)
{
    return cvol_compress(t->context, out, NULL, t->volume.data, &t->volume.grid, options);
}

/* Compresses, writes, verifies. */
static int compress_with(tour *t, const cvol_compress_options *options)
{
    cvol_array *array;
    int code = compress(t, &array, options);
    if (code)
        return code;
    code = cvol_array_write(t->context, array, t->path, NULL);
    if (!code)
        code = cvol_file_verify(t->context, NULL, t->path);
    cvol_array_free(array);
    return code;
}

static int compress_to(tour *t, cvol_target target, double value, int block, int fast)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target = target;
    options.target_value = value;
    options.block = block;
    options.effort = fast ? CVOL_EFFORT_FAST : CVOL_EFFORT_DEFAULT;
    return compress_with(t, &options);
}

static int ratio(tour *t)
{
    return compress_to(t, CVOL_TARGET_RATIO, 20, 16, 0);
}

static int psnr(tour *t)
{
    return compress_to(t, CVOL_TARGET_PSNR, 45, 16, 0);
}

static int fast(tour *t)
{
    return compress_to(t, CVOL_TARGET_PSNR, 45, 16, 1);
}

static int blocks_of_8(tour *t)
{
    return compress_to(t, CVOL_TARGET_RATIO, 20, 8, 0);
}

static int blocks_of_32(tour *t)
{
    return compress_to(t, CVOL_TARGET_RATIO, 20, 32, 0);
}

static int largest_error(tour *t)
{
    return compress_to(t, CVOL_TARGET_MAX_ERROR, 0.5, 16, 0);
}

static int lossless(tour *t)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    options.lossless = 1;
    return compress_with(t, &options);
}

static int filled(tour *t)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    float *samples = t->volume.data;
    for (size_t i = 0; i < cvol_grid_samples(&t->volume.grid) / 3; i++)
        samples[i] = -5;
    options.has_fill = 1;
    options.fill = -5;
    return compress_with(t, &options);
}

static int smallest(tour *t)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    options.effort = CVOL_EFFORT_MAX;
    return compress_with(t, &options);
}

static int transcode(tour *t)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array, *coarser;
    int code = compress(t, &array, &options);
    if (code)
        return code;
    options.target_value = 60;
    code = cvol_array_transcode(t->context, &coarser, NULL, array, &options);
    if (!code)
        cvol_array_free(coarser);
    cvol_array_free(array);
    return code;
}

const tour_step tour_compressing[] = {{"to a ratio", ratio},
                                      {"to a PSNR", psnr},
                                      {"fast", fast},
                                      {"in blocks of 8", blocks_of_8},
                                      {"in blocks of 32", blocks_of_32},
                                      {"to a largest error", largest_error},
                                      {"without loss", lossless},
                                      {"with a fill", filled},
                                      {"to the smallest file", smallest},
                                      {"transcoding", transcode},
                                      {NULL, NULL}};

/* ---- reading ---------------------------------------------------------------------------- */

int tour_write(tour *t, int is_lossless)
{
    return is_lossless ? lossless(t) : ratio(t);
}

static int read_array(tour *t)
{
    cvol_array *array;
    const int code = cvol_array_read(t->context, &array, t->path, NULL);
    if (!code)
        cvol_array_free(array);
    return code;
}

static int read_level(tour *t)
{
    const cvol_file_part part = {.size = sizeof(cvol_file_part), .level = 1};
    cvol_array *array;
    const int code = cvol_array_read_part(t->context, &array, NULL, t->path, &part);
    if (!code)
        cvol_array_free(array);
    return code;
}

static int read_box(tour *t)
{
    const size_t begin[3] = {5, 6, 7}, end[3] = {50, 40, 30};
    cvol_array *array;
    const int code = cvol_array_read_box(t->context, &array, t->path, begin, end, NULL);
    if (!code)
        cvol_array_free(array);
    return code;
}

static int verify(tour *t)
{
    return cvol_file_verify(t->context, NULL, t->path);
}

static int lay_out(tour *t)
{
    cvol_file_layout layout;
    return cvol_file_read_layout(t->context, &layout, t->path);
}

static int decode(tour *t)
{
    const size_t zero[3] = {0, 0, 0}, *dims = t->volume.grid.dims;
    cvol_array *array;
    float *samples = malloc(cvol_grid_bytes(&t->volume.grid));
    if (!samples)
        return CVOL_ERROR_MEMORY;
    int code = cvol_array_read(t->context, &array, t->path, NULL);
    if (!code) {
        code = cvol_array_evaluate_box(t->context, samples, array, zero, dims);
        if (!code)
            code = cvol_array_evaluate_real(t->context, samples, array, zero, dims);
        cvol_array_free(array);
    }
    free(samples);
    return code;
}

const tour_step tour_reading[] = {{"reading", read_array},
                                  {"reading a level", read_level},
                                  {"reading a box", read_box},
                                  {"verifying", verify},
                                  {"listing its sections", lay_out},
                                  {"decoding", decode},
                                  {NULL, NULL}};

/* ---- operations ------------------------------------------------------------------------- */

/* Results are dropped. */
static int drop(int code, cvol_array *result)
{
    if (!code)
        cvol_array_free(result);
    return code;
}

static int operate_on(tour *t, const cvol_array *a, const cvol_keep *keep)
{
    cvol_context *context = t->context;
    cvol_array *result = NULL;
    cvol_array_statistics statistics;
    cvol_kernel kernel;
    int code = drop(cvol_array_add(context, &result, 1, a, 2, a, keep), result);
    if (!code)
        code = drop(cvol_array_multiply(context, &result, a, a, keep, CVOL_PLAN_AUTO, NULL),
                    result);
    if (!code)
        code = cvol_kernel_gaussian(context, &kernel, 3, 1.5);
    if (!code)
        code = drop(cvol_array_convolve_kernel(context, &result, a, &kernel, keep), result);
    if (!code)
        code = drop(cvol_array_gradient(context, &result, a, keep), result);
    if (!code)
        code = drop(cvol_array_resample(context, &result, a, 2, keep), result);
    return code ? code : cvol_array_compute_statistics(context, &statistics, a);
}

static int operate(tour *t, cvol_transform transform, int block)
{
    const cvol_keep keep = cvol_keep_ratio(20);
    const size_t zero[3] = {0, 0, 0};
    cvol_array *a;
    float *samples = malloc(cvol_grid_bytes(&t->volume.grid));
    if (!samples)
        return CVOL_ERROR_MEMORY;
    int code = cvol_array_compress(t->context, &a, t->volume.data, &t->volume.grid, 3, transform,
                                   block, &keep);
    if (!code) {
        code = operate_on(t, a, &keep);
        if (!code)
            code = cvol_array_evaluate_real(t->context, samples, a, zero, t->volume.grid.dims);
        if (!code)
            code = cvol_array_write(t->context, a, t->path, NULL);
        if (!code)
            code = cvol_file_verify(t->context, NULL, t->path);
        cvol_array_free(a);
    }
    free(samples);
    return code;
}

static int whole_dct(tour *t)
{
    return operate(t, CVOL_DCT, 0);
}

static int whole_dft(tour *t)
{
    return operate(t, CVOL_DFT, 0);
}

static int whole_dht(tour *t)
{
    return operate(t, CVOL_DHT, 0);
}

static int blocks_dct(tour *t)
{
    return operate(t, CVOL_DCT, 16);
}

static int blocks_dft(tour *t)
{
    return operate(t, CVOL_DFT, 8);
}

static int points(tour *t)
{
    const cvol_keep keep = cvol_keep_ratio(20);
    const double start[3] = {1.3, 2.1, 3.7}, step[3] = {0.7, 0.8, 0.9};
    const size_t count[3] = {20, 21, 22};
    double at[30];
    float values[10], *many = malloc(20 * 21 * 22 * sizeof *many);
    cvol_array *a;
    if (!many)
        return CVOL_ERROR_MEMORY;
    for (int i = 0; i < 30; i++)
        at[i] = i;
    int code = cvol_array_compress(t->context, &a, t->volume.data, &t->volume.grid, 3, CVOL_DFT, 0,
                                   &keep);
    if (!code) {
        code = cvol_array_evaluate_points(t->context, values, a, at, 10);
        if (!code)
            code = cvol_array_evaluate_chirp(t->context, many, a, start, step, count);
        cvol_array_free(a);
    }
    free(many);
    return code;
}

const tour_step tour_operations[] = {{"whole arrays, DCT", whole_dct},
                                     {"whole arrays, DFT", whole_dft},
                                     {"whole arrays, DHT", whole_dht},
                                     {"blocks, DCT", blocks_dct},
                                     {"blocks, DFT", blocks_dft},
                                     {"values at points", points},
                                     {NULL, NULL}};

/* ---- pictures --------------------------------------------------------------------------- */

static int draw(tour *t, cvol_renderer *renderer, const cvol_render_options *options)
{
    cvol_image *image;
    int code = cvol_image_create(t->context, &image, options->width, options->height);
    if (code)
        return code;
    code = cvol_renderer_render(t->context, renderer, image, options);
    cvol_image_free(image);
    return code;
}

/* Sources and options of pictures: modes of an engine, with levels, in perspective. */
typedef struct way {
    cvol_engine engine;
    double rho; /* of engine fourier */
    cvol_mode modes[5];
    int count, lit, perspective, levels;
    cvol_sheet_footprint footprint;
} way;

static int draw_modes(tour *t, cvol_renderer *renderer, const way *w)
{
    int code = CVOL_OK;
    for (int k = 0; k < 4 * w->count && !code; k++) {
        cvol_render_options options = cvol_render_options_defaults();
        if (((k & 1) && !w->lit) || ((k & 2) && !w->perspective))
            continue;
        options.width = options.height = 100;
        options.mode = w->modes[k / 4];
        options.shading.on = k & 1;
        options.camera.azimuth_deg = 30 + 20 * k;
        options.camera.elevation_deg = 25;
        options.camera.fov_deg = k & 2 ? 40 : 0;
        options.surface.value = 40;
        options.sheet.footprint = w->footprint;
        code = draw(t, renderer, &options);
        options.level = 1;
        if (!code && w->levels)
            code = draw(t, renderer, &options);
    }
    return code;
}

static int draw_array(tour *t, const way *w)
{
    cvol_array *array;
    cvol_renderer *renderer = NULL;
    cvol_transfer *transfer = NULL;
    cvol_histogram histogram;
    int code = cvol_array_read(t->context, &array, t->path, NULL);
    if (code)
        return code;
    code = cvol_array_compute_histogram(t->context, &histogram, array);
    if (!code)
        code = cvol_transfer_create_named(t->context, &transfer, "auto", &histogram);
    if (!code)
        code = cvol_renderer_create(t->context, &renderer, w->engine,
                                    CVOL_SOURCE(.array = array, .rho = w->rho));
    if (!code)
        code = cvol_renderer_set_transfer(t->context, renderer, transfer);
    if (!code)
        code = draw_modes(t, renderer, w);
    cvol_renderer_free(renderer);
    cvol_transfer_free(transfer);
    cvol_array_free(array);
    return code;
}

static int sheet_composite(tour *t)
{
    return draw_array(t, &(way){.engine = CVOL_ENGINE_SHEET,
                                .modes = {CVOL_MODE_COMPOSITE},
                                .count = 1,
                                .lit = 1,
                                .perspective = 1,
                                .levels = 1});
}

static int sheet_surface(tour *t)
{
    return draw_array(t, &(way){.engine = CVOL_ENGINE_SHEET,
                                .modes = {CVOL_MODE_ISO},
                                .count = 1,
                                .lit = 1,
                                .perspective = 1});
}

static int sheet_smooth(tour *t)
{
    return draw_array(t, &(way){.engine = CVOL_ENGINE_SHEET,
                                .modes = {CVOL_MODE_COMPOSITE},
                                .count = 1,
                                .lit = 1,
                                .footprint = CVOL_SHEET_B_SPLINE});
}

static int sheet_extremes(tour *t)
{
    return draw_array(t, &(way){.engine = CVOL_ENGINE_SHEET,
                                .modes = {CVOL_MODE_MIP, CVOL_MODE_MIN, CVOL_MODE_XRAY},
                                .count = 3,
                                .perspective = 1,
                                .levels = 1});
}

static int splat(tour *t)
{
    return draw_array(
        t,
        &(way){.engine = CVOL_ENGINE_SPLAT, .modes = {CVOL_MODE_COMPOSITE}, .count = 1, .lit = 1});
}

static int transform(tour *t)
{
    return draw_array(t, &(way){.engine = CVOL_ENGINE_TRANSFORM,
                                .modes = {CVOL_MODE_COMPOSITE},
                                .count = 1,
                                .lit = 1});
}

static int fourier(tour *t)
{
    return draw_array(
        t,
        &(way){.engine = CVOL_ENGINE_FOURIER, .rho = 1e-3, .modes = {CVOL_MODE_XRAY}, .count = 1});
}

/* The samples themselves. */
static int rays(tour *t)
{
    const way w = {
        .modes = {CVOL_MODE_COMPOSITE, CVOL_MODE_MIP}, .count = 2, .lit = 1, .perspective = 1};
    cvol_renderer *renderer = NULL;
    cvol_transfer *transfer = NULL;
    cvol_histogram histogram;
    int code = cvol_volume_compute_histogram(t->context, &histogram, &t->volume);
    if (!code)
        code = cvol_transfer_create_named(t->context, &transfer, "auto", &histogram);
    if (!code)
        code = cvol_renderer_create(t->context, &renderer, CVOL_ENGINE_RAY,
                                    CVOL_SOURCE(.volume = &t->volume));
    if (!code)
        code = cvol_renderer_set_transfer(t->context, renderer, transfer);
    if (!code)
        code = draw_modes(t, renderer, &w);
    cvol_renderer_free(renderer);
    cvol_transfer_free(transfer);
    return code;
}

static int pictures(tour *t)
{
    const cvol_picture_options options = cvol_picture_options_defaults();
    cvol_image *image, *decoded = NULL;
    cvol_picture *picture = NULL;
    int code = cvol_image_create(t->context, &image, 90, 70);
    if (code)
        return code;
    for (int i = 0; i < 4 * 90 * 70; i++)
        image->rgba[i] = (uint8_t)(i % 4 == 3 ? 255 : i / 40);
    code = cvol_image_write_png(t->context, image, t->path);
    cvol_image_free(image);
    image = NULL;
    if (!code)
        code = cvol_image_read_png(t->context, &image, t->path);
    if (!code)
        code = cvol_picture_compress(t->context, &picture, image, &options);
    if (!code)
        code = cvol_picture_evaluate(t->context, &decoded, picture);
    cvol_picture_free(picture);
    cvol_image_free(decoded);
    cvol_image_free(image);
    return code;
}

const tour_step tour_pictures[] = {{"sheet, composite", sheet_composite},
                                   {"sheet, surface", sheet_surface},
                                   {"sheet, B-spline", sheet_smooth},
                                   {"sheet, mip, min, xray", sheet_extremes},
                                   {"splat", splat},
                                   {"transform", transform},
                                   {"fourier", fourier},
                                   {"rays", rays},
                                   {"pictures", pictures},
                                   {NULL, NULL}};

const tour_step *const tour_all[4] = {tour_compressing, tour_reading, tour_operations,
                                      tour_pictures};
