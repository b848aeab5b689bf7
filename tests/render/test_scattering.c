/* Light that is scattered once: its directions, and the cells of engine sheet against the rays of
 * engine ray. */
#include "test.h"

#include <math.h>

#include "cvol/look.h"
#include "render/light/directions.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

enum { SIDE = 40, SIZE = 64 };

/* ---- directions -------------------------------------------------------------------------- */

/* Unit vectors; the mean cosine of the sky is 1/3, that of the disc (1 + cos 12) / 2; no part of
 * the turn is preferred. */
static void test_directions(void **state)
{
    (void)state;
    static const double lights[][3] = {{0, 0, 2}, {1, 0, 0}, {0.3, -0.8, 0.1}};
    for (int k = 0; k < 3; k++) {
        cvol_view view = {.eye = {0, 0, 1}};
        cvol_render_options options = cvol_render_options_defaults();
        options.illumination.samples = 4000;
        memcpy(options.shading.light, lights[k], sizeof lights[k]);
        const cvol_directions all = cvol_directions_make(&view, &options);
        assert_int_equal(all.disc + all.sky, 4000);
        for (int is_sky = 0; is_sky < 2; is_sky++) {
            const int count = is_sky ? all.sky : all.disc;
            double mean[3] = {0, 0, 0}, shift[2] = {0.3, 0.9};
            for (int i = 0; i < count; i++) {
                double way[3], parts[3] = {0, 0, 0};
                (is_sky ? cvol_direction_to_sky : cvol_direction_to_disc)(way, &all, i, shift);
                for (int a = 0; a < 3; a++) {
                    parts[0] += way[a] * all.towards[a];
                    parts[1] += way[a] * all.across[0][a];
                    parts[2] += way[a] * all.across[1][a];
                }
                assert_true(fabs(hypot(hypot(way[0], way[1]), way[2]) - 1) < 1e-9);
                assert_true(is_sky || parts[0] >= 0.9781);
                for (int a = 0; a < 3; a++)
                    mean[a] += parts[a] / count;
            }
            assert_true(fabs(mean[0] - (is_sky ? 1.0 / 3 : 0.98907)) < 2e-3);
            assert_true(fabs(mean[1]) < 5e-3 && fabs(mean[2]) < 5e-3);
        }
    }
}

/* ---- pictures ---------------------------------------------------------------------------- */

static const cvol_transfer_point points[] = {{18, 0.2, 0.3, 0.7, 0},
                                             {30, 0.9, 0.6, 0.4, 0.25},
                                             {60, 0.9, 0.85, 0.7, 0.6},
                                             {90, 0.95, 0.95, 0.9, 0.8}};
#define POINTS (sizeof points / sizeof *points)

static cvol_render_options cinematic(double azimuth, double elevation, int samples)
{
    cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, azimuth, elevation);
    cvol_render_options_set_cinematic(&options, samples);
    options.camera.zoom = 1.6;
    return options;
}

/* The PSNR of engine sheet with `samples` directions against engine ray with 64. */
static double find_db(const cvol_array *array, const cvol_volume *volume,
                      cvol_render_options options, int samples)
{
    options.step_voxels = 0.5;
    cvol_image *ray = support_ray(context, volume, points, POINTS, &options);
    options.step_voxels = 0;
    options.illumination.samples = samples;
    cvol_image *sheet = support_sheet(context, array, points, POINTS, &options);
    const double db = support_psnr(ray, sheet);
    cvol_image_free(ray);
    cvol_image_free(sheet);
    return db;
}

/* More directions come closer to rays through the samples; so do clipped volumes. */
static void test_engines(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(SIDE, SIDE - 6, SIDE - 11);
    cvol_array *array = support_compress(context, &volume, 16, 75);
    for (int k = 0; k < 3; k++) {
        cvol_render_options options = cinematic(120 * k + 20, 40 * k - 30, 64);
        if (k == 2)
            options.clip = (cvol_clip){.axes = 2, .from = {0, 14, 0}, .to = {0, SIDE, 0}};
        const double few = find_db(array, &volume, options, 2),
                     many = find_db(array, &volume, options, 64);
        if (test_verbose())
            print_message("view %d: 2 directions %.1f dB, 64 %.1f dB\n", k, few, many);
        assert_true(many > 30);
        assert_true(many > few + 3);
    }
    cvol_array_free(array);
    free(volume.data);
}

/* Without occlusion and shadows all light arrives; a shadow darkens. */
static void test_strengths(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(SIDE, SIDE, SIDE);
    cvol_render_options options = cinematic(30, 20, 16);
    options.step_voxels = 1;
    options.illumination.keeps_brightness = 0;
    cvol_image *scattered = support_ray(context, &volume, points, POINTS, &options);
    options.illumination.occlusion = options.illumination.shadows = 0;
    cvol_image *open = support_ray(context, &volume, points, POINTS, &options);
    options.illumination.samples = 0;
    cvol_image *plain = support_ray(context, &volume, points, POINTS, &options);
    assert_int_equal(support_difference(open, plain), 0);
    double sums[2] = {0, 0};
    for (int i = 0; i < SIZE * SIZE; i++) {
        sums[0] += support_pixel(scattered, i % SIZE, i / SIZE)[0];
        sums[1] += support_pixel(open, i % SIZE, i / SIZE)[0];
    }
    assert_true(sums[0] < 0.9 * sums[1]);
    cvol_image_free(scattered);
    cvol_image_free(open);
    cvol_image_free(plain);
    free(volume.data);
}

/* Both engines draw surfaces with it; samples of 1 are refused. */
static void test_surface(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(SIDE, SIDE, SIDE);
    cvol_array *array = support_compress(context, &volume, 16, 75);
    cvol_render_options options = cinematic(30, 20, 16);
    options.mode = CVOL_MODE_ISO;
    options.surface.value = 30;
    options.oversample = 1;
    assert_true(support_sheet_db(context, array, &volume, NULL, 0, options) > 25);
    options.illumination.samples = 1;
    cvol_renderer *renderer;
    cvol_image *image;
    assert_int_equal(cvol_image_create(context, &image, SIZE, SIZE), CVOL_OK);
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "samples is 1"));
    cvol_renderer_free(renderer);
    cvol_image_free(image);
    cvol_array_free(array);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_directions), TEST(test_engines),
                                       TEST(test_strengths), TEST(test_surface)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
