/* The ray engine against results computed by hand (boxes of constant density, linear ramps, single
 * voxels), and against itself for options without effect. */
#include "test.h"

#include "random.h"
#include "render/view/camera.h"
#include "support_context.h"
#include "support_render.h"

/* ---- helpers ----------------------------------------------------------------------------- */

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

/* ---- analytic pictures ------------------------------------------------------------------- */

/* Opacity along a ray of length L through a constant volume: 1 - (1 - a)^(L / mean spacing). */
static void test_constant_box(void **state)
{
    (void)state;
    cvol_volume volume = support_volume(20, 24, 28, CVOL_UINT8);
    memset(volume.data, 7, 20 * 24 * 28);
    const double spacing[3] = {1, 1.5, 0.7}, mean = 3.2 / 3, opacity = 0.06;
    const double extent[3] = {19, 34.5, 18.9};
    memcpy(volume.grid.spacing, spacing, sizeof spacing);
    const cvol_transfer_point points[] = {{0, 1, 1, 1, opacity}};
    for (int a = 0; a < 360; a += 20)
        for (int e = -90; e <= 90; e += 30) {
            cvol_render_options options = support_square(23, CVOL_MODE_COMPOSITE, a, e);
            options.step_voxels = a % 40 ? 0 : 1.7;
            cvol_view v;
            assert_int_equal(cvol_view_make(context, &v, &volume.grid, &options), CVOL_OK);
            cvol_image *image = support_ray(context, &volume, points, 1, &options);
            for (int j = 0; j < 23; j++)
                for (int i = 0; i < 23; i++) {
                    double p[3], middle[3];
                    for (int k = 0; k < 3; k++)
                        p[k] = extent[k] / 2 + (i - 11) * v.pixel * v.right[k] +
                               (11 - j) * v.pixel * v.up[k];
                    double length = chord(middle, p, v.eye, extent);
                    double expected = 255 * (1 - pow(1 - opacity, length / mean));
                    assert_true(fabs(support_pixel(image, i, j)[1] - expected) <= 1);
                }
            cvol_image_free(image);
        }
    free(volume.data);
}

/* The mean of a linear function along a chord is its value in the middle. */
static void test_xray_of_a_ramp(void **state)
{
    (void)state;
    cvol_volume volume = support_volume(15, 12, 9, CVOL_INT16);
    for (size_t z = 0; z < 9; z++)
        for (size_t y = 0; y < 12; y++)
            for (size_t x = 0; x < 15; x++)
                ((int16_t *)volume.data)[support_index(&volume, x, y, z)] = (int16_t)(100 * (int)x -
                                                                                      70 * (int)y +
                                                                                      50 * (int)z);
    volume.grid.spacing[1] = 1.25;
    const double extent[3] = {14, 13.75, 8}, lo = -770, hi = 1800;
    for (int a = 0; a < 360; a += 30)
        for (int e = -60; e <= 90; e += 30) {
            cvol_render_options options = support_square(21, CVOL_MODE_XRAY, a + 3, e);
            options.background[0] = 1;
            cvol_view v;
            assert_int_equal(cvol_view_make(context, &v, &volume.grid, &options), CVOL_OK);
            cvol_image *image = support_ray(context, &volume, NULL, 0, &options);
            for (int j = 0; j < 21; j++)
                for (int i = 0; i < 21; i++) {
                    double p[3], m[3];
                    for (int k = 0; k < 3; k++)
                        p[k] = extent[k] / 2 + (i - 10) * v.pixel * v.right[k] +
                               (10 - j) * v.pixel * v.up[k];
                    double length = chord(m, p, v.eye, extent);
                    const uint8_t *pixel = support_pixel(image, i, j);
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
    cvol_volume volume = support_volume(9, 9, 9, CVOL_UINT8);
    ((uint8_t *)volume.data)[support_index(&volume, 4, 4, 4)] = 255;
    const double steps[] = {0.5, 1, 1.0 / 64};
    for (int axis = 0; axis < 6; axis++)
        for (int s = 0; s < 3; s++) {
            cvol_render_options options = support_square(
                33, CVOL_MODE_MIP, axis < 4 ? 90 * axis : 0, axis < 4 ? 0 : 180 * axis - 810);
            options.step_voxels = steps[s];
            cvol_image *image = support_ray(context, &volume, NULL, 0, &options);
            assert_true(fabs(support_pixel(image, 16, 16)[0] - 255 * (1 - steps[s] / 2)) <= 0.51);
            assert_int_equal(support_pixel(image, 22, 16)[0], 0);
            cvol_image_free(image);
        }
    free(volume.data);
}

/* ---- invariances ------------------------------------------------------------------------- */

static void test_step_has_little_effect(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(40, 44, 48);
    cvol_render_options options = support_square(64, CVOL_MODE_COMPOSITE, 30, 20);
    cvol_image *coarse = support_ray(context, &volume, support_blob_points, SUPPORT_BLOB_POINTS,
                                     &options);
    options.step_voxels = 1.0 / 16;
    cvol_image *fine = support_ray(context, &volume, support_blob_points, SUPPORT_BLOB_POINTS,
                                   &options);
    assert_true(support_difference(coarse, fine) <= 2);
    options.step_voxels = 1000; /* one sample per ray */
    cvol_image *one = support_ray(context, &volume, support_blob_points, SUPPORT_BLOB_POINTS,
                                  &options);
    cvol_image_free(one);
    cvol_image_free(coarse);
    cvol_image_free(fine);
    free(volume.data);
}

static void test_same_for_any_threads(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(30, 34, 38);
    for (int mode = CVOL_MODE_COMPOSITE; mode <= CVOL_MODE_MIP; mode++) {
        cvol_render_options options = support_square(97, (cvol_mode)mode, 77, 12);
        cvol_context_set_threads(context, 1);
        cvol_image *one = support_ray(context, &volume, support_blob_points, SUPPORT_BLOB_POINTS,
                                      &options);
        for (int threads = 2; threads <= 3; threads++) {
            cvol_context_set_threads(context, threads);
            cvol_image *many = support_ray(context, &volume, support_blob_points,
                                           SUPPORT_BLOB_POINTS, &options);
            assert_int_equal(support_difference(one, many), 0);
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

static void test_same_for_all_types(void **state)
{
    (void)state;
    cvol_render_options options = support_square(48, CVOL_MODE_COMPOSITE, 25, 35);
    cvol_image *first = NULL;
    for (int type = CVOL_UINT8; type <= CVOL_FLOAT64; type++) {
        cvol_volume volume = support_volume(9, 10, 11, (cvol_type)type);
        random_state r = {5};
        for (size_t i = 0; i < 9 * 10 * 11; i++)
            store(&volume, i, (int)random_below(&r, 100));
        cvol_image *image = support_ray(context, &volume, support_blob_points, SUPPORT_BLOB_POINTS,
                                        &options);
        if (first)
            assert_int_equal(support_difference(first, image), 0);
        else
            first = image;
        if (first != image)
            cvol_image_free(image);
        free(volume.data);
    }
    cvol_image_free(first);
}

static void test_nan_is_the_lowest_value(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(12, 12, 12), same = support_blobs(12, 12, 12);
    cvol_volume_statistics stats;
    assert_int_equal(cvol_volume_compute_statistics(context, &stats, &volume), CVOL_OK);
    for (size_t i = 1; i < 12 * 12 * 12; i += 7) {
        ((float *)volume.data)[i] = i % 3 ? NAN : -INFINITY;
        ((float *)same.data)[i] = (float)stats.min;
    }
    ((float *)volume.data)[0] = ((float *)same.data)[0] = (float)stats.min;
    for (int mode = CVOL_MODE_COMPOSITE; mode <= CVOL_MODE_MIP; mode++) {
        cvol_render_options options = support_square(48, (cvol_mode)mode, 25, 35);
        cvol_image *a = support_ray(context, &volume, support_blob_points, SUPPORT_BLOB_POINTS,
                                    &options);
        cvol_image *b = support_ray(context, &same, support_blob_points, SUPPORT_BLOB_POINTS,
                                    &options);
        assert_int_equal(support_difference(a, b), 0);
        cvol_image_free(a);
        cvol_image_free(b);
    }
    for (size_t i = 0; i < 12 * 12 * 12; i++)
        ((float *)volume.data)[i] = NAN;
    cvol_render_options options = support_square(8, CVOL_MODE_XRAY, 25, 35);
    cvol_image_free(support_ray(context, &volume, NULL, 0, &options));
    free(volume.data);
    free(same.data);
}

/* Transfer functions with a single step, at, within and beyond the ends of the samples. */
static void test_jumps_are_sharp(void **state)
{
    (void)state;
    cvol_volume volume = support_volume(2, 2, 2, CVOL_UINT8);
    uint8_t *samples = volume.data;
    for (int i = 0; i < 8; i++)
        samples[i] = i % 2 ? 100 : 0; /* a ramp along x */
    cvol_render_options options = support_square(100, CVOL_MODE_COMPOSITE, 0, 0);
    options.background[2] = 1;
    for (int edge = -50; edge <= 150; edge += 10) {
        const cvol_transfer_point points[] = {{edge, 1, 0, 0, 0}, {edge, 1, 0, 0, 1}};
        cvol_image *image = support_ray(context, &volume, points, 2, &options);
        double half = sqrt(3) / 2;
        for (int i = 0; i < 100; i++) {
            double x = ((i + 0.5) / 50 - 1) * half + 0.5;
            if (x < 0 || x > 1 || fabs(100 * x - edge) < 0.1)
                continue;
            assert_int_equal(support_pixel(image, i, 50)[0], 100 * x > edge ? 255 : 0);
            assert_int_equal(support_pixel(image, i, 50)[2], 100 * x > edge ? 0 : 255);
        }
        cvol_image_free(image);
    }
    free(volume.data);
}

/* ---- odd volumes and requests ------------------------------------------------------------ */

static void test_thin_volumes_are_visible(void **state)
{
    (void)state;
    const size_t shapes[][3] = {{1, 1, 1}, {1, 9, 9}, {9, 1, 9}, {9, 9, 1}, {1, 1, 9}, {2, 1, 1}};
    const cvol_transfer_point points[] = {{0, 1, 1, 1, 0.5}};
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++)
        for (int view = 0; view < 8; view++) {
            cvol_volume volume = support_volume(shapes[s][0], shapes[s][1], shapes[s][2],
                                                CVOL_FLOAT32);
            ((float *)volume.data)[0] = 3;
            cvol_render_options options = support_square(41, CVOL_MODE_COMPOSITE, 45 * (view % 4),
                                                         view < 4 ? 0 : 90 - 20 * (view % 2));
            cvol_image *image = support_ray(context, &volume, points, 1, &options);
            /* The box is as thick as one spacing: its middle hides half at least. */
            assert_true(support_pixel(image, 20, 20)[0] >= 127);
            cvol_image_free(image);
            options.mode = CVOL_MODE_MIP;
            cvol_image_free(support_ray(context, &volume, NULL, 0, &options));
            options.mode = CVOL_MODE_XRAY;
            cvol_image_free(support_ray(context, &volume, NULL, 0, &options));
            free(volume.data);
        }
}

static void test_invalid_requests(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(8, 8, 8);
    cvol_renderer *renderer;
    cvol_image *image;
    cvol_render_options options = support_square(16, CVOL_MODE_COMPOSITE, 0, 0);
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_RAY, CVOL_SOURCE(.volume = &volume)),
        CVOL_OK);
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
    cvol_volume volume = support_blobs(8, 8, 8);
    cvol_render_options options = support_square(100, CVOL_MODE_MIP, 10, 10);
    cvol_renderer *renderer;
    cvol_image *image;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_RAY, CVOL_SOURCE(.volume = &volume)),
        CVOL_OK);
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
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_constant_box),
        TEST(test_xray_of_a_ramp),
        TEST(test_mip_of_one_voxel),
        TEST(test_step_has_little_effect),
        TEST(test_same_for_any_threads),
        TEST(test_same_for_all_types),
        TEST(test_nan_is_the_lowest_value),
        TEST(test_jumps_are_sharp),
        TEST(test_thin_volumes_are_visible),
        TEST(test_invalid_requests),
        TEST(test_progress_and_cancel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
