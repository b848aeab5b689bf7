/* The sheet engine with samples between slices (step_voxels) and with more rays than pixels
 * (oversample), against the ray engine: closer to it than without. Each floor is the measured PSNR
 * minus about 1.5 dB. CVOL_TEST_VERBOSE=1 prints the measurements. */
#include "test.h"

#include "base/cpu.h"
#include "render/counters.h"
#include "support.h"
#include "support_context.h"
#include "support_lapped.h"
#include "support_render.h"

/* Surfaces that cross slices. */
static cvol_volume waves(void)
{
    cvol_volume volume = support_volume(37, 33, 35, CVOL_FLOAT32);
    for (size_t z = 0; z < 35; z++)
        for (size_t y = 0; y < 33; y++)
            for (size_t x = 0; x < 37; x++)
                ((float *)volume.data)[support_index(&volume, x, y, z)] =
                    (float)(50 + 30 * sin(0.5 * (double)x + 0.1 * (double)y) +
                            20 * cos(0.4 * (double)z - 0.2 * (double)y));
    return volume;
}

static const cvol_transfer_point soft[] = {{40, 0.1, 0.2, 1, 0}, {90, 1, 0.6, 0.1, 0.3}};
static const cvol_transfer_point solid[] = {{60, 0.1, 0.2, 1, 0}, {62, 1, 0.6, 0.1, 1}};

static double compare(cvol_array *array, const cvol_volume *volume,
                      const cvol_transfer_point *points, cvol_render_options options)
{
    return support_sheet_db(context, array, volume, points, 2, options);
}

/* The requests: without, with samples between, with more rays, with both. */
static void expect(cvol_array *array, const cvol_volume *volume, const cvol_transfer_point *points,
                   cvol_render_options options, const double gains_db[3], const char *what)
{
    double db[4];
    options.sheet.ray_order = CVOL_RAY_ORDER_OBJECT; /* more rays reduce the error there */
    for (int kind = 0; kind < 4; kind++) {
        options.step_voxels = kind & 1 ? 0.4 : 0;
        options.oversample = kind & 2 ? 2 : 1;
        db[kind] = compare(array, volume, points, options);
    }
    const int good = db[1] - db[0] >= gains_db[0] && db[2] - db[0] >= gains_db[1] &&
                     db[3] - db[0] >= gains_db[2];
    if (test_verbose() || !good)
        print_message("%s, azimuth %g: %.2f dB, between %.2f, rays %.2f, both %.2f\n", what,
                      options.camera.azimuth_deg, db[0], db[1], db[2], db[3]);
    assert_true(good);
}

static void test_error_against_rays(void **state)
{
    (void)state;
    static const double gains_db[3] = {-0.5, -0.7, 0.5};
    static const double views[][2] = {{30, 20}, {250, -40}};
    for (int lapped = 0; lapped < 2; lapped++) {
        cvol_volume volume = waves();
        cvol_array *array = lapped ? support_lapped(context, volume.data, volume.grid.dims, 0, 0.01,
                                                    1, 7)
                                   : support_compress(context, &volume, 16, 80);
        for (size_t v = 0; v < 2; v++) {
            cvol_render_options options = support_square(64, CVOL_MODE_COMPOSITE, views[v][0],
                                                         views[v][1]);
            options.camera.zoom = 1.5;
            expect(array, &volume, soft, options, gains_db, "soft");
            expect(array, &volume, solid, options, gains_db, "solid");
            options.shading.on = 1;
            expect(array, &volume, solid, options, gains_db, "lit");
            options.mode = CVOL_MODE_ISO;
            options.surface.value = 60;
            expect(array, &volume, soft, options, gains_db, "surface");
            options.camera.fov_deg = 50;
            expect(array, &volume, soft, options, gains_db, "perspective");
            options.mode = CVOL_MODE_COMPOSITE;
            options.clip = (cvol_clip){.planes = 1, .plane = {{1, -2, 0.7, -4.4}}};
            expect(array, &volume, solid, options, gains_db, "clipped");
        }
        cvol_array_free(array);
        free(volume.data);
    }
}

/* A step of at least one sample per slice changes nothing; threads never do. */
static void test_same_bits(void **state)
{
    (void)state;
    cvol_volume volume = waves();
    cvol_array *array = support_compress(context, &volume, 16, 60);
    for (int lit = 0; lit < 2; lit++) {
        cvol_render_options options = support_square(64, CVOL_MODE_COMPOSITE, 30, 20);
        options.shading.on = lit;
        cvol_image *plain = support_sheet(context, array, soft, 2, &options);
        options.step_voxels = 2;
        options.oversample = 1;
        cvol_image *same = support_sheet(context, array, soft, 2, &options);
        assert_int_equal(support_difference(plain, same), 0);
        options.step_voxels = 0.3;
        options.oversample = 3;
        cvol_context_set_threads(context, 1);
        cvol_image *one = support_sheet(context, array, soft, 2, &options);
        cvol_context_set_threads(context, 3);
        cvol_image *three = support_sheet(context, array, soft, 2, &options);
        assert_int_equal(support_difference(one, three), 0);
        assert_true(support_psnr(plain, one) > 25);
        cvol_image_free(plain);
        cvol_image_free(same);
        cvol_image_free(one);
        cvol_image_free(three);
    }
    cvol_render_options options = support_square(64, CVOL_MODE_COMPOSITE, 30, 20);
    cvol_renderer *renderer;
    cvol_image *image;
    options.oversample = 5;
    assert_int_equal(cvol_image_create(context, &image, 64, 64), CVOL_OK);
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    support_set_transfer(context, renderer, soft, 2);
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "oversample 5"));
    cvol_renderer_free(renderer);
    cvol_image_free(image);
    cvol_array_free(array);
    free(volume.data);
}

/* Counting changes no picture; hidden, transparent or omitted samples are not counted. */
static void test_multiply_adds(void **state)
{
    (void)state;
    static const cvol_transfer_point nothing[] = {{1000, 1, 1, 1, 0}, {1001, 1, 1, 1, 1}};
    static const cvol_transfer_point wall[] = {{0, 1, 1, 1, 1}, {1, 1, 1, 1, 1}};
    const cvol_transfer_point *const looks[] = {soft, wall, nothing};
    cvol_volume volume = waves();
    cvol_array *array = support_compress(context, &volume, 16, 60);
    cvol_render_options options = support_square(64, CVOL_MODE_COMPOSITE, 30, 20);
    cvol_renderer *renderer;
    cvol_image *image;
    uint64_t count[4], image_order;
    assert_int_equal(cvol_image_create(context, &image, 64, 64), CVOL_OK);
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    for (int k = 0; k < 4; k++) {
        support_set_transfer(context, renderer, looks[k % 3], 2);
        options.step_voxels = k == 3 ? 4 : 0;
        options.sheet.ray_order = CVOL_RAY_ORDER_OBJECT;
        assert_int_equal(
            cvol_renderer_sheet_multiply_adds(context, renderer, image, &options, &count[k]),
            CVOL_OK);
        cvol_image *plain = support_sheet(context, array, looks[k % 3], 2, &options);
        /* The counted picture is drawn from floats, the other from int16, if there are such
         * kernels; else they are the same. */
        const int words = cvol_cpu_best() == CVOL_CPU_AVX512;
        assert_true(support_difference(plain, image) <= (words ? 2 : 0));
        assert_true(support_psnr(plain, image) >= 68);
        cvol_image_free(plain);
        options.sheet.ray_order = CVOL_RAY_ORDER_IMAGE;
        assert_int_equal(
            cvol_renderer_sheet_multiply_adds(context, renderer, image, &options, &image_order),
            CVOL_OK);
        plain = support_sheet(context, array, looks[k % 3], 2, &options);
        assert_true(support_psnr(plain, image) > 60);
        assert_true((image_order == 0) == (count[k] == 0));
        cvol_image_free(plain);
    }
    assert_true(count[0] > (uint64_t)12 * 37 * 33 * 35);
    assert_true(count[1] < 0.95 * (double)count[0] && count[2] == 0 &&
                count[3] < 0.8 * (double)count[0]);
    options.shading.on = 1;
    assert_int_equal(
        cvol_renderer_sheet_multiply_adds(context, renderer, image, &options, &count[0]),
        CVOL_ERROR_ARGUMENT);
    cvol_renderer_free(renderer);
    cvol_image_free(image);
    cvol_array_free(array);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_error_against_rays), TEST(test_same_bits),
                                       TEST(test_multiply_adds)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
