/* Rays of the sheet engine that lie further apart than pixels, in means and extremes: outlines stay
 * as sharp as pixels are. Pixels that lie further apart than samples, in composites: pictures stay
 * close to the ray engine. CVOL_TEST_VERBOSE=1 prints the measurements. */
#include "test.h"

#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

static const cvol_transfer_point soft[] = {{30, 0.1, 0.2, 1, 0}, {130, 1, 0.6, 0.1, 0.3}};

/* Solid up to its faces; `rough`: the difference of neighbouring samples. */
static cvol_volume make_solid(double rough)
{
    const size_t n[3] = {44, 36, 40};
    random_state r = {7};
    cvol_volume volume = support_volume(n[0], n[1], n[2], CVOL_FLOAT32);
    for (size_t z = 0; z < n[2]; z++)
        for (size_t y = 0; y < n[1]; y++)
            for (size_t x = 0; x < n[0]; x++)
                ((float *)volume.data)[support_index(&volume, x, y, z)] =
                    (float)(80 + 30 * sin(0.2 * (double)x + 0.1 * (double)y) +
                            10 * cos(0.25 * (double)z) + rough * random_signed(&r));
    return volume;
}

/* Against the ray engine, in dB. */
static double compare(const cvol_array *array, const cvol_volume *volume,
                      cvol_render_options options, cvol_ray_order rays)
{
    options.sheet.ray_order = rays;
    return support_sheet_db(context, array, volume, soft, 2, options);
}

/* With rays only at pixels, outlines had 25 to 30 dB against the right ones. */
static void test_outlines(void **state)
{
    (void)state;
    static const cvol_mode modes[] = {CVOL_MODE_XRAY, CVOL_MODE_MIP, CVOL_MODE_MIN};
    cvol_volume volume = make_solid(0);
    cvol_array *array = support_compress(context, &volume, 16, 80);
    for (size_t c = 0; c < sizeof modes / sizeof *modes; c++)
        for (int azimuth = 20; azimuth < 360; azimuth += 110)
            for (int clipped = 0; clipped < 3; clipped++) {
                cvol_render_options options = support_square(90, modes[c], azimuth, 25);
                if (clipped == 1)
                    options.clip = (cvol_clip){.axes = 7, .from = {6, 4, 5}, .to = {38, 30, 37}};
                if (clipped == 2)
                    options.camera.zoom = 0.4;
                for (int rays = CVOL_RAY_ORDER_AUTO; rays <= CVOL_RAY_ORDER_IMAGE; rays++) {
                    const double db = compare(array, &volume, options, (cvol_ray_order)rays);
                    if (test_verbose() || db < 36)
                        print_message("mode %d, azimuth %d, %s %d: %.2f dB\n", (int)modes[c],
                                      azimuth, rays ? "pixels," : "auto,", clipped, db);
                    assert_true(db >= 36);
                }
            }
    cvol_array_free(array);
    free(volume.data);
}

/* Rays at the distance of pixels give another picture than those that the engine chooses. */
static void test_wider_ray_spacing(void **state)
{
    (void)state;
    static const cvol_mode modes[] = {CVOL_MODE_XRAY, CVOL_MODE_MIP, CVOL_MODE_COMPOSITE};
    cvol_volume volume = make_solid(0);
    cvol_array *array = support_compress(context, &volume, 16, 80);
    for (size_t c = 0; c < sizeof modes / sizeof *modes; c++) {
        cvol_render_options options = support_square(200, modes[c], 30, 25);
        cvol_image *images[2];
        for (int is_chosen = 0; is_chosen < 2; is_chosen++) {
            options.sheet.ray_order = is_chosen ? CVOL_RAY_ORDER_AUTO : CVOL_RAY_ORDER_OBJECT;
            images[is_chosen] = support_sheet(context, array, soft, 2, &options);
        }
        assert_true(support_difference(images[0], images[1]) > 0);
        assert_true(support_psnr(images[0], images[1]) >= 38);
        options.oversample = 0.99; /* given, so that nothing is chosen */
        for (int is_chosen = 0; is_chosen < 2; is_chosen++) {
            cvol_image_free(images[is_chosen]);
            options.sheet.ray_order = is_chosen ? CVOL_RAY_ORDER_AUTO : CVOL_RAY_ORDER_OBJECT;
            images[is_chosen] = support_sheet(context, array, soft, 2, &options);
        }
        assert_int_equal(support_difference(images[0], images[1]), 0);
        cvol_image_free(images[0]);
        cvol_image_free(images[1]);
    }
    cvol_array_free(array);
    free(volume.data);
}

/* Pictures whose pixels span more than a sample: nothing is sampled more coarsely for them. */
static void test_distant_pictures(void **state)
{
    (void)state;
    static const cvol_transfer_point functions[][2] = {
        {{30, 0.1, 0.2, 1, 0}, {130, 1, 0.6, 0.1, 0.1}},
        {{30, 0.1, 0.2, 1, 0}, {130, 1, 0.6, 0.1, 0.5}}};
    cvol_volume volume = make_solid(3);
    cvol_array *array = support_compress(context, &volume, 16, 80);
    for (int azimuth = 10; azimuth < 360; azimuth += 70)
        for (int f = 0; f < 2; f++) {
            cvol_render_options options = support_square(45, CVOL_MODE_COMPOSITE, azimuth, 25);
            const double db = support_sheet_db(context, array, &volume, functions[f], 2, options);
            if (test_verbose() || db < 45)
                print_message("azimuth %d, function %d: %.2f dB\n", azimuth, f, db);
            assert_true(db >= 45);
        }
    cvol_array_free(array);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_outlines), TEST(test_wider_ray_spacing),
                                       TEST(test_distant_pictures)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
