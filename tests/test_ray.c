/* The camera and the ray engine against what can be worked out by hand: boxes of constant density,
 * linear ramps, single voxels, corners of known colours, rolls and zooms. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "random.h"
#include "render/camera.h"

static cvol_context *context;

static int setup(void **state)
{
    (void)state;
    context = cvol_context_create();
    return context ? 0 : -1;
}

static int teardown(void **state)
{
    (void)state;
    cvol_context_destroy(context);
    return 0;
}

/* ---- helpers ----------------------------------------------------------------------------- */

static cvol_volume make_volume(size_t nx, size_t ny, size_t nz, cvol_type type)
{
    cvol_volume volume = {.grid = cvol_grid_make(nx, ny, nz, type)};
    volume.data = calloc(nx * ny * nz, cvol_type_size(type));
    assert_non_null(volume.data);
    return volume;
}

static size_t index_of(const cvol_volume *volume, size_t x, size_t y, size_t z)
{
    return x + volume->grid.dims[0] * (y + volume->grid.dims[1] * z);
}

static cvol_image *render(const cvol_volume *volume, const cvol_transfer_point *points,
                          size_t count, const cvol_render_options *options)
{
    cvol_renderer *renderer;
    cvol_image *image;
    assert_int_equal(cvol_renderer_create_ray(context, &renderer, volume), CVOL_OK);
    if (points) {
        cvol_transfer *transfer;
        assert_int_equal(cvol_transfer_create(context, &transfer, points, count), CVOL_OK);
        assert_int_equal(cvol_renderer_set_transfer(context, renderer, transfer), CVOL_OK);
        cvol_transfer_free(transfer); /* the renderer has its own */
    }
    assert_int_equal(cvol_image_create(context, &image, options->width, options->height), CVOL_OK);
    int code = cvol_renderer_render(context, renderer, image, options);
    if (code)
        fail_msg("%s", cvol_context_message(context));
    cvol_renderer_free(renderer);
    for (int i = 0; i < image->width * image->height; i++)
        assert_int_equal(image->rgba[4 * i + 3], 255);
    return image;
}

static cvol_render_options square(int size, cvol_mode mode, double azimuth, double elevation)
{
    cvol_render_options options = cvol_render_options_defaults();
    options.width = options.height = size;
    options.mode = mode;
    options.camera.azimuth_deg = azimuth;
    options.camera.elevation_deg = elevation;
    return options;
}

static const uint8_t *pixel_of(const cvol_image *image, int i, int j)
{
    return image->rgba + 4 * (j * image->width + i);
}

static int largest_difference(const cvol_image *a, const cvol_image *b)
{
    int largest = 0;
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    for (int i = 0; i < 4 * a->width * a->height; i++)
        if (abs(a->rgba[i] - b->rgba[i]) > largest)
            largest = abs(a->rgba[i] - b->rgba[i]);
    return largest;
}

/* A smooth volume without symmetry. */
static cvol_volume make_blobs(size_t nx, size_t ny, size_t nz)
{
    cvol_volume volume = make_volume(nx, ny, nz, CVOL_FLOAT32);
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
                ((float *)volume.data)[index_of(&volume, x, y, z)] = (float)value;
            }
    return volume;
}

static const cvol_transfer_point blob_points[] = {
    {5, 0.2, 0.1, 0.6, 0}, {30, 0.9, 0.3, 0.1, 0.05}, {60, 1, 0.9, 0.5, 0.2}, {90, 1, 1, 1, 0.4}};

/* The length within the box 0..extent of the line through p along d; its middle in `middle`. */
static double chord(double middle[3], const double p[3], const double d[3], const double extent[3])
{
    double near = -1e9, far = 1e9;
    for (int a = 0; a < 3; a++) {
        if (fabs(d[a]) < 1e-12) {
            if (p[a] < 0 || p[a] > extent[a])
                return 0;
            continue;
        }
        double s = (0 - p[a]) / d[a], t = (extent[a] - p[a]) / d[a];
        near = fmax(near, s < t ? s : t);
        far = fmin(far, s < t ? t : s);
    }
    for (int a = 0; a < 3; a++)
        middle[a] = p[a] + d[a] * (near + far) / 2;
    return far > near ? far - near : 0;
}

/* ---- camera ------------------------------------------------------------------------------ */

static void test_view_directions(void **state)
{
    (void)state;
    random_state r = {1};
    cvol_grid grid = cvol_grid_make(10, 20, 30, CVOL_UINT8);
    for (int trial = 0; trial < 200; trial++) {
        cvol_render_options options = cvol_render_options_defaults();
        double a = 400 * random_signed(&r), e = 400 * random_signed(&r);
        options.camera = (cvol_camera){a, e, 400 * random_signed(&r), 1};
        cvol_view v;
        assert_int_equal(cvol_view_make(context, &v, &grid, &options), CVOL_OK);
        a *= acos(-1) / 180;
        e *= acos(-1) / 180;
        const double eye[3] = {cos(e) * sin(a), -cos(e) * cos(a), sin(e)};
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            assert_true(fabs(v.eye[i] - eye[i]) < 1e-12);
            /* right x up = eye */
            assert_true(fabs(v.right[j] * v.up[k] - v.right[k] * v.up[j] - eye[i]) < 1e-12);
        }
        double dot = 0, length = 0;
        for (int i = 0; i < 3; i++) {
            dot += v.right[i] * v.up[i];
            length += v.right[i] * v.right[i];
        }
        assert_true(fabs(dot) < 1e-12 && fabs(length - 1) < 1e-12);
    }
}

static void test_view_scale(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(4, 5, 13, CVOL_UINT8); /* 3, 4, 12: diagonal 13 */
    cvol_render_options options = cvol_render_options_defaults();
    options.width = 50;
    options.height = 26;
    cvol_view v;
    assert_int_equal(cvol_view_make(context, &v, &grid, &options), CVOL_OK);
    assert_true(fabs(v.pixel - 0.5) < 1e-12);
    assert_true(v.centre[2] == 6 && v.extent[1] == 4 && fabs(v.mean_spacing - 1) < 1e-12);
    options.camera.zoom = 4;
    assert_int_equal(cvol_view_make(context, &v, &grid, &options), CVOL_OK);
    assert_true(fabs(v.pixel - 0.125) < 1e-12);
    grid = cvol_grid_make(1, 1, 1, CVOL_UINT8);
    grid.spacing[0] = 4;
    assert_int_equal(cvol_view_make(context, &v, &grid, &options), CVOL_OK);
    assert_true(fabs(v.pixel - 2.0 / 26 / 4) < 1e-12);
}

static void expect_refused(const cvol_render_options *options, const char *word)
{
    cvol_grid grid = cvol_grid_make(4, 5, 6, CVOL_UINT8);
    cvol_view v;
    assert_int_equal(cvol_view_make(context, &v, &grid, options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), word));
}

static void test_bad_options_are_named(void **state)
{
    (void)state;
    const cvol_render_options good = cvol_render_options_defaults();
    cvol_render_options bad = good;
#define REFUSE(field, value, word) \
    bad = good;                    \
    bad.field = value;             \
    expect_refused(&bad, word)
    REFUSE(width, 0, "width 0");
    REFUSE(width, CVOL_IMAGE_SIZE_MAX + 1, "width");
    REFUSE(height, -3, "height -3");
    REFUSE(camera.zoom, 0, "zoom 0");
    REFUSE(camera.zoom, -1, "zoom -1");
    REFUSE(camera.zoom, NAN, "zoom");
    REFUSE(camera.zoom, INFINITY, "zoom");
    REFUSE(camera.zoom, 1e-320, "zoom");
    REFUSE(camera.azimuth_deg, NAN, "azimuth");
    REFUSE(camera.elevation_deg, INFINITY, "elevation");
    REFUSE(camera.roll_deg, NAN, "roll");
    REFUSE(step_voxels, -1, "step -1");
    REFUSE(step_voxels, 0.01, "step 0.01");
    REFUSE(step_voxels, INFINITY, "step");
    REFUSE(background[1], 1.5, "green is 1.5");
    REFUSE(background[2], NAN, "blue");
}

/* ---- analytic pictures ------------------------------------------------------------------- */

/* Opacity along a ray of length L through constant matter: 1 - (1 - a)^(L / mean spacing). */
static void test_constant_box(void **state)
{
    (void)state;
    cvol_volume volume = make_volume(20, 24, 28, CVOL_UINT8);
    memset(volume.data, 7, 20 * 24 * 28);
    const double spacing[3] = {1, 1.5, 0.7}, mean = 3.2 / 3, opacity = 0.06;
    const double extent[3] = {19, 34.5, 18.9};
    memcpy(volume.grid.spacing, spacing, sizeof spacing);
    const cvol_transfer_point points[] = {{0, 1, 1, 1, opacity}};
    for (int a = 0; a < 360; a += 20)
        for (int e = -90; e <= 90; e += 30) {
            cvol_render_options options = square(23, CVOL_MODE_COMPOSITE, a, e);
            options.step_voxels = a % 40 ? 0 : 1.7;
            cvol_view v;
            assert_int_equal(cvol_view_make(context, &v, &volume.grid, &options), CVOL_OK);
            cvol_image *image = render(&volume, points, 1, &options);
            for (int j = 0; j < 23; j++)
                for (int i = 0; i < 23; i++) {
                    double p[3], middle[3];
                    for (int k = 0; k < 3; k++)
                        p[k] = extent[k] / 2 + (i - 11) * v.pixel * v.right[k] +
                               (11 - j) * v.pixel * v.up[k];
                    double length = chord(middle, p, v.eye, extent);
                    double expected = 255 * (1 - pow(1 - opacity, length / mean));
                    assert_true(fabs(pixel_of(image, i, j)[1] - expected) <= 1);
                }
            cvol_image_free(image);
        }
    free(volume.data);
}

/* The mean of a linear function along a chord is its value in the middle. */
static void test_xray_of_a_ramp(void **state)
{
    (void)state;
    cvol_volume volume = make_volume(15, 12, 9, CVOL_INT16);
    for (size_t z = 0; z < 9; z++)
        for (size_t y = 0; y < 12; y++)
            for (size_t x = 0; x < 15; x++)
                ((int16_t *)volume.data)[index_of(&volume, x, y, z)] = (int16_t)(100 * (int)x -
                                                                                 70 * (int)y +
                                                                                 50 * (int)z);
    volume.grid.spacing[1] = 1.25;
    const double extent[3] = {14, 13.75, 8}, lo = -770, hi = 1800;
    for (int a = 0; a < 360; a += 30)
        for (int e = -60; e <= 90; e += 30) {
            cvol_render_options options = square(21, CVOL_MODE_XRAY, a + 3, e);
            options.background[0] = 1;
            cvol_view v;
            assert_int_equal(cvol_view_make(context, &v, &volume.grid, &options), CVOL_OK);
            cvol_image *image = render(&volume, NULL, 0, &options);
            for (int j = 0; j < 21; j++)
                for (int i = 0; i < 21; i++) {
                    double p[3], m[3];
                    for (int k = 0; k < 3; k++)
                        p[k] = extent[k] / 2 + (i - 10) * v.pixel * v.right[k] +
                               (10 - j) * v.pixel * v.up[k];
                    double length = chord(m, p, v.eye, extent);
                    const uint8_t *pixel = pixel_of(image, i, j);
                    if (length > 1e-6) {
                        double mean = 100 * m[0] - 70 * m[1] / 1.25 + 50 * m[2];
                        assert_true(fabs(pixel[0] - 255 * (mean - lo) / (hi - lo)) <= 0.6);
                        assert_true(pixel[0] == pixel[1] && pixel[1] == pixel[2]);
                    } else if (length == 0)
                        assert_true(pixel[0] == 255 && pixel[1] == 0 && pixel[2] == 0);
                }
            cvol_image_free(image);
        }
    free(volume.data);
}

/* Samples lie at odd multiples of half a step from the entry: the nearest to a voxel in the
 * middle is half a step away, and interpolation gives 1 - step / 2 of it. */
static void test_mip_of_one_voxel(void **state)
{
    (void)state;
    cvol_volume volume = make_volume(9, 9, 9, CVOL_UINT8);
    ((uint8_t *)volume.data)[index_of(&volume, 4, 4, 4)] = 255;
    const double steps[] = {0.5, 1, 1.0 / 64};
    for (int axis = 0; axis < 6; axis++)
        for (int s = 0; s < 3; s++) {
            cvol_render_options options = square(33, CVOL_MODE_MIP, axis < 4 ? 90 * axis : 0,
                                                 axis < 4 ? 0 : 180 * axis - 810);
            options.step_voxels = steps[s];
            cvol_image *image = render(&volume, NULL, 0, &options);
            assert_true(fabs(pixel_of(image, 16, 16)[0] - 255 * (1 - steps[s] / 2)) <= 0.51);
            assert_int_equal(pixel_of(image, 22, 16)[0], 0);
            cvol_image_free(image);
        }
    free(volume.data);
}

/* A bright voxel anywhere appears where the definition of the camera puts it. */
static void test_voxels_appear_in_their_places(void **state)
{
    (void)state;
    random_state r = {7};
    const int size = 160;
    for (int trial = 0; trial < 20; trial++) {
        cvol_volume volume = make_volume(12, 17, 14, CVOL_UINT8);
        volume.grid.spacing[2] = 1.5;
        size_t at[3] = {1 + random_below(&r, 10), 1 + random_below(&r, 15),
                        1 + random_below(&r, 12)};
        ((uint8_t *)volume.data)[index_of(&volume, at[0], at[1], at[2])] = 200;
        cvol_render_options options = square(size, CVOL_MODE_MIP, 180 * random_signed(&r),
                                             90 * random_signed(&r));
        options.step_voxels = 1.0 / 16;
        options.camera.roll_deg = 180 * random_signed(&r);
        cvol_view v;
        assert_int_equal(cvol_view_make(context, &v, &volume.grid, &options), CVOL_OK);
        double across = 0, above = 0, sum = 0, sum_i = 0, sum_j = 0;
        for (int k = 0; k < 3; k++) {
            double offset = (double)at[k] * volume.grid.spacing[k] - v.extent[k] / 2;
            across += offset * v.right[k] / v.pixel;
            above += offset * v.up[k] / v.pixel;
        }
        cvol_image *image = render(&volume, NULL, 0, &options);
        for (int j = 0; j < size; j++)
            for (int i = 0; i < size; i++) {
                double grey = pixel_of(image, i, j)[0];
                sum += grey;
                sum_i += grey * (i + 0.5 - size / 2.0);
                sum_j += grey * (size / 2.0 - j - 0.5);
            }
        assert_true(sum > 0);
        assert_true(hypot(sum_i / sum - across, sum_j / sum - above) < 0.5);
        cvol_image_free(image);
        free(volume.data);
    }
}

/* Eight corners of eight colours: each view along an axis shows the four near ones, each in its
 * place. Corner bits: 1 for high x, 2 for high y, 4 for high z. */
static void test_corners_of_axis_views(void **state)
{
    (void)state;
    const size_t n = 17;
    cvol_volume volume = make_volume(n, n, n, CVOL_UINT8);
    cvol_transfer_point points[9] = {{0, 0, 0, 0, 0}};
    for (int corner = 0; corner < 8; corner++) {
        double value = 20 * (corner + 1);
        points[corner + 1] = (cvol_transfer_point){value, corner & 1 ? 1 : 0.2,
                                                   corner & 2 ? 1 : 0.2, corner & 4 ? 1 : 0.2, 1};
        for (size_t k = 0; k < 64; k++) {
            size_t place[3] = {k % 4, k / 4 % 4, k / 16};
            for (int a = 0; a < 3; a++)
                place[a] = corner >> a & 1 ? n - 1 - place[a] : place[a];
            ((uint8_t *)volume.data)[index_of(&volume, place[0], place[1], place[2])] = (uint8_t)
                value;
        }
    }
    /* Per view: azimuth, elevation, and the near corners top left, top right, bottom left,
     * bottom right. */
    static const int views[6][6] = {{0, 0, 4, 5, 0, 1},   {90, 0, 5, 7, 1, 3},
                                    {180, 0, 7, 6, 3, 2}, {270, 0, 6, 4, 2, 0},
                                    {0, 90, 6, 7, 4, 5},  {0, -90, 0, 1, 2, 3}};
    const int size = 101;
    /* Corner blocks' middles lie 6.5 from the centre; half the height is 8 sqrt(3). */
    const int offset = (int)(6.5 / (8 * sqrt(3)) * size / 2 + 0.5);
    for (int view = 0; view < 6; view++) {
        cvol_render_options options = square(size, CVOL_MODE_COMPOSITE, views[view][0],
                                             views[view][1]);
        cvol_image *image = render(&volume, points, 9, &options);
        for (int k = 0; k < 4; k++) {
            int corner = views[view][2 + k];
            const uint8_t *pixel = pixel_of(image, size / 2 + (k & 1 ? offset : -offset),
                                            size / 2 + (k & 2 ? offset : -offset));
            for (int c = 0; c < 3; c++)
                assert_int_equal(pixel[c], corner >> c & 1 ? 255 : 51);
        }
        cvol_image_free(image);
    }
    free(volume.data);
}

/* ---- invariances ------------------------------------------------------------------------- */

/* The camera turned counter-clockwise by 90 degrees sees the picture turned clockwise. */
static void test_roll(void **state)
{
    (void)state;
    cvol_volume volume = make_blobs(20, 24, 28);
    const int size = 64;
    cvol_render_options options = square(size, CVOL_MODE_COMPOSITE, 33, 21);
    cvol_image *plain = render(&volume, blob_points, 4, &options);
    options.camera.roll_deg = 90;
    cvol_image *rolled = render(&volume, blob_points, 4, &options);
    for (int j = 0; j < size; j++)
        for (int i = 0; i < size; i++)
            for (int c = 0; c < 3; c++)
                assert_true(abs(pixel_of(rolled, i, j)[c] - pixel_of(plain, j, size - 1 - i)[c]) <=
                            1);
    cvol_image_free(plain);
    cvol_image_free(rolled);
    free(volume.data);
}

/* Zoom 2 at size n is the middle of zoom 1 at size 2 n; a wide picture's middle is the square. */
static void test_zoom_and_width(void **state)
{
    (void)state;
    cvol_volume volume = make_blobs(20, 24, 28);
    cvol_render_options options = square(80, CVOL_MODE_COMPOSITE, 200, -35);
    cvol_image *large = render(&volume, blob_points, 4, &options);
    options.width = options.height = 40;
    options.camera.zoom = 2;
    cvol_image *zoomed = render(&volume, blob_points, 4, &options);
    options.width = 60;
    cvol_image *wide = render(&volume, blob_points, 4, &options);
    for (int j = 0; j < 40; j++)
        for (int i = 0; i < 40; i++)
            for (int c = 0; c < 3; c++) {
                int level = pixel_of(zoomed, i, j)[c];
                assert_true(abs(level - pixel_of(large, i + 20, j + 20)[c]) <= 1);
                assert_true(abs(level - pixel_of(wide, i + 10, j)[c]) <= 1);
            }
    cvol_image_free(large);
    cvol_image_free(zoomed);
    cvol_image_free(wide);
    free(volume.data);
}

static void test_step_hardly_matters(void **state)
{
    (void)state;
    cvol_volume volume = make_blobs(40, 44, 48);
    cvol_render_options options = square(64, CVOL_MODE_COMPOSITE, 30, 20);
    cvol_image *coarse = render(&volume, blob_points, 4, &options);
    options.step_voxels = 1.0 / 16;
    cvol_image *fine = render(&volume, blob_points, 4, &options);
    assert_true(largest_difference(coarse, fine) <= 2);
    options.step_voxels = 1000; /* one sample per ray */
    cvol_image *one = render(&volume, blob_points, 4, &options);
    cvol_image_free(one);
    cvol_image_free(coarse);
    cvol_image_free(fine);
    free(volume.data);
}

static void test_threads_do_not_matter(void **state)
{
    (void)state;
    cvol_volume volume = make_blobs(30, 34, 38);
    for (int mode = CVOL_MODE_COMPOSITE; mode <= CVOL_MODE_MIP; mode++) {
        cvol_render_options options = square(97, (cvol_mode)mode, 77, 12);
        cvol_context_set_threads(context, 1);
        cvol_image *one = render(&volume, blob_points, 4, &options);
        for (int threads = 2; threads <= 3; threads++) {
            cvol_context_set_threads(context, threads);
            cvol_image *many = render(&volume, blob_points, 4, &options);
            assert_int_equal(largest_difference(one, many), 0);
            cvol_image_free(many);
        }
        cvol_image_free(one);
    }
    free(volume.data);
}

static void store(cvol_volume *volume, size_t i, int value)
{
    switch (volume->grid.type) {
#define STORE(name, type)                        \
    case name:                                   \
        ((type *)volume->data)[i] = (type)value; \
        break
        STORE(CVOL_UINT8, uint8_t);
        STORE(CVOL_INT8, int8_t);
        STORE(CVOL_UINT16, uint16_t);
        STORE(CVOL_INT16, int16_t);
        STORE(CVOL_UINT32, uint32_t);
        STORE(CVOL_INT32, int32_t);
        STORE(CVOL_FLOAT32, float);
        STORE(CVOL_FLOAT64, double);
    }
}

static void test_types_do_not_matter(void **state)
{
    (void)state;
    cvol_render_options options = square(48, CVOL_MODE_COMPOSITE, 25, 35);
    cvol_image *first = NULL;
    for (int type = CVOL_UINT8; type <= CVOL_FLOAT64; type++) {
        cvol_volume volume = make_volume(9, 10, 11, (cvol_type)type);
        random_state r = {5};
        for (size_t i = 0; i < 9 * 10 * 11; i++)
            store(&volume, i, (int)random_below(&r, 100));
        cvol_image *image = render(&volume, blob_points, 4, &options);
        if (first)
            assert_int_equal(largest_difference(first, image), 0);
        else
            first = image;
        if (first != image)
            cvol_image_free(image);
        free(volume.data);
    }
    cvol_image_free(first);
}

static void test_not_a_number_is_the_smallest(void **state)
{
    (void)state;
    cvol_volume volume = make_blobs(12, 12, 12), same = make_blobs(12, 12, 12);
    cvol_sample_stats stats;
    assert_int_equal(cvol_volume_stats(context, &stats, &volume), CVOL_OK);
    for (size_t i = 1; i < 12 * 12 * 12; i += 7) {
        ((float *)volume.data)[i] = i % 3 ? NAN : -INFINITY;
        ((float *)same.data)[i] = (float)stats.min;
    }
    ((float *)volume.data)[0] = ((float *)same.data)[0] = (float)stats.min;
    for (int mode = CVOL_MODE_COMPOSITE; mode <= CVOL_MODE_MIP; mode++) {
        cvol_render_options options = square(48, (cvol_mode)mode, 25, 35);
        cvol_image *a = render(&volume, blob_points, 4, &options);
        cvol_image *b = render(&same, blob_points, 4, &options);
        assert_int_equal(largest_difference(a, b), 0);
        cvol_image_free(a);
        cvol_image_free(b);
    }
    for (size_t i = 0; i < 12 * 12 * 12; i++)
        ((float *)volume.data)[i] = NAN;
    cvol_render_options options = square(8, CVOL_MODE_XRAY, 25, 35);
    cvol_image_free(render(&volume, NULL, 0, &options));
    free(volume.data);
    free(same.data);
}

/* Transfer functions that are a single step, at, within and beyond the ends of the samples. */
static void test_jumps_are_sharp(void **state)
{
    (void)state;
    cvol_volume volume = make_volume(2, 2, 2, CVOL_UINT8);
    uint8_t *samples = volume.data;
    for (int i = 0; i < 8; i++)
        samples[i] = i % 2 ? 100 : 0; /* a ramp along x */
    cvol_render_options options = square(100, CVOL_MODE_COMPOSITE, 0, 0);
    options.background[2] = 1;
    for (int edge = -50; edge <= 150; edge += 10) {
        const cvol_transfer_point points[] = {{edge, 1, 0, 0, 0}, {edge, 1, 0, 0, 1}};
        cvol_image *image = render(&volume, points, 2, &options);
        double half = sqrt(3) / 2;
        for (int i = 0; i < 100; i++) {
            double x = ((i + 0.5) / 50 - 1) * half + 0.5;
            if (x < 0 || x > 1 || fabs(100 * x - edge) < 0.1)
                continue;
            assert_int_equal(pixel_of(image, i, 50)[0], 100 * x > edge ? 255 : 0);
            assert_int_equal(pixel_of(image, i, 50)[2], 100 * x > edge ? 0 : 255);
        }
        cvol_image_free(image);
    }
    free(volume.data);
}

/* ---- odd volumes and requests ------------------------------------------------------------ */

static void test_thin_volumes_are_seen(void **state)
{
    (void)state;
    const size_t shapes[][3] = {{1, 1, 1}, {1, 9, 9}, {9, 1, 9}, {9, 9, 1}, {1, 1, 9}, {2, 1, 1}};
    const cvol_transfer_point points[] = {{0, 1, 1, 1, 0.5}};
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++)
        for (int view = 0; view < 8; view++) {
            cvol_volume volume = make_volume(shapes[s][0], shapes[s][1], shapes[s][2],
                                             CVOL_FLOAT32);
            ((float *)volume.data)[0] = 3;
            cvol_render_options options = square(41, CVOL_MODE_COMPOSITE, 45 * (view % 4),
                                                 view < 4 ? 0 : 90 - 20 * (view % 2));
            cvol_image *image = render(&volume, points, 1, &options);
            /* The box is as thick as one spacing: its middle hides half at least. */
            assert_true(pixel_of(image, 20, 20)[0] >= 127);
            cvol_image_free(image);
            options.mode = CVOL_MODE_MIP;
            cvol_image_free(render(&volume, NULL, 0, &options));
            options.mode = CVOL_MODE_XRAY;
            cvol_image_free(render(&volume, NULL, 0, &options));
            free(volume.data);
        }
}

static void test_requests_that_have_no_meaning(void **state)
{
    (void)state;
    cvol_volume volume = make_blobs(8, 8, 8);
    cvol_renderer *renderer;
    cvol_image *image;
    cvol_render_options options = square(16, CVOL_MODE_COMPOSITE, 0, 0);
    assert_int_equal(cvol_renderer_create_ray(context, &renderer, &volume), CVOL_OK);
    assert_int_equal(cvol_image_create(context, &image, 16, 16), CVOL_OK);
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "transfer function"));
    options.mode = CVOL_MODE_XRAY;
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_OK);
    options.width = 17;
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "16 x 16"));
    options.width = 16;
    options.mode = (cvol_mode)9;
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_ERROR_ARGUMENT);
    cvol_image_free(image);
    cvol_renderer_free(renderer);
    cvol_renderer_free(NULL);
    free(volume.data);
}

typedef struct watch {
    int calls, stop_at;
    double last;
} watch;

static int on_progress(void *user, const char *what, double fraction)
{
    watch *w = user;
    assert_true(strlen(what) > 0 && fraction >= w->last && fraction <= 1);
    w->last = fraction;
    return ++w->calls == w->stop_at;
}

static void test_progress_and_cancel(void **state)
{
    (void)state;
    cvol_volume volume = make_blobs(8, 8, 8);
    cvol_render_options options = square(100, CVOL_MODE_MIP, 10, 10);
    cvol_renderer *renderer;
    cvol_image *image;
    assert_int_equal(cvol_renderer_create_ray(context, &renderer, &volume), CVOL_OK);
    assert_int_equal(cvol_image_create(context, &image, 100, 100), CVOL_OK);
    watch w = {0};
    cvol_context_set_progress(context, on_progress, &w);
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_OK);
    assert_true(w.calls > 1 && w.last == 1);
    w = (watch){.stop_at = 2};
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options),
                     CVOL_ERROR_CANCELLED);
    assert_int_equal(w.calls, 2);
    cvol_image_free(image);
    cvol_renderer_free(renderer);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_view_directions),
        TEST(test_view_scale),
        TEST(test_bad_options_are_named),
        TEST(test_constant_box),
        TEST(test_xray_of_a_ramp),
        TEST(test_mip_of_one_voxel),
        TEST(test_voxels_appear_in_their_places),
        TEST(test_corners_of_axis_views),
        TEST(test_roll),
        TEST(test_zoom_and_width),
        TEST(test_step_hardly_matters),
        TEST(test_threads_do_not_matter),
        TEST(test_types_do_not_matter),
        TEST(test_not_a_number_is_the_smallest),
        TEST(test_jumps_are_sharp),
        TEST(test_thin_volumes_are_seen),
        TEST(test_requests_that_have_no_meaning),
        TEST(test_progress_and_cancel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
