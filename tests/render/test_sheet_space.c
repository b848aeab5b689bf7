/* Rays of the sheet engine that lie further apart than pixels: outlines stay as sharp as pixels
 * are, the inside stays close to the ray engine, and light uses one ray per pixel where samples are
 * rough. CVOL_TEST_VERBOSE=1 prints the measurements. */
#include "test.h"

#include "base/cpu.h"
#include "random.h"
#include "render/sheet/frame/plan.h"
#include "render/sheet/frame/policy.h"
#include "render/sheet/opacity_curvature.h"
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

static double curvature_of(const cvol_array *array)
{
    cvol_transfer *transfer;
    cvol_visibility visibility;
    assert_int_equal(cvol_transfer_create(context, &transfer, soft, 2), CVOL_OK);
    cvol_visibility_make(&visibility, array, transfer);
    const double curvature = cvol_opacity_curvature(array, transfer, &visibility);
    cvol_transfer_free(transfer);
    return curvature;
}

/* Tests if the engine's own choice of rays for a lit picture is image order. */
static int takes_pixels(const cvol_array *array)
{
    cvol_render_options options = support_square(90, CVOL_MODE_COMPOSITE, 30, 25);
    cvol_image *images[2];
    options.shading.on = 1;
    for (int rays = CVOL_RAY_ORDER_AUTO; rays <= CVOL_RAY_ORDER_IMAGE; rays++) {
        options.sheet.ray_order = (cvol_ray_order)rays;
        images[rays] = support_sheet(context, array, soft, 2, &options);
    }
    const int same = support_difference(images[0], images[1]) == 0;
    cvol_image_free(images[0]);
    cvol_image_free(images[1]);
    return same;
}

/* Rays at the distance of pixels give another picture than those that the engine chooses. */
static void test_wider_ray_spacing(void **state)
{
    (void)state;
    static const cvol_mode modes[] = {CVOL_MODE_COMPOSITE, CVOL_MODE_XRAY, CVOL_MODE_MIP};
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

/* Opacity is 0.003 per unit of values, about 0.15 in the middle; noise of +-r gives a curvature of
 * 0.003 sqrt(r^2 / 3 + r^2 / 6), except at the function's ends. */
static void test_light_on_rough_samples(void **state)
{
    (void)state;
    static const double rough[] = {0, 10, 40};
    for (size_t k = 0; k < sizeof rough / sizeof *rough; k++) {
        cvol_volume volume = make_solid(rough[k]);
        cvol_array *array = support_compress(context, &volume, 16, 80);
        const double curvature = curvature_of(array), noise = 0.003 * rough[k] * sqrt(0.5) / 0.15;
        if (test_verbose())
            print_message("rough %g: bends by %.3f\n", rough[k], curvature);
        assert_true(curvature <= 0.03 + 1.25 * noise && curvature >= 0.65 * noise);
        if (cvol_cpu_best() == CVOL_CPU_AVX512) /* others have no image-order rays for light */
            assert_int_equal(takes_pixels(array), rough[k] > 20);
        cvol_array_free(array);
        free(volume.data);
    }
}

/* The plan of a picture of a function that is linear up to this opacity. */
static cvol_sheet_plan plan_of(const cvol_array *array, double most, cvol_render_options options)
{
    const cvol_transfer_point points[] = {{30, 1, 1, 1, 0}, {130, 1, 1, 1, most}};
    cvol_transfer *transfer;
    cvol_view view;
    cvol_sheet_plan plan;
    assert_int_equal(cvol_transfer_create(context, &transfer, points, 2), CVOL_OK);
    assert_int_equal(cvol_view_make(context, &view, &array->grid, &options), CVOL_OK);
    const cvol_policy_case in = {.mode = options.mode,
                                 .asked = options.sheet.ray_order,
                                 .pixel = view.pixel / view.mean_spacing,
                                 .rays = 1,
                                 .lit = options.shading.on,
                                 .traits = cvol_transfer_traits_of(array, transfer),
                                 .has_range = 1};
    const cvol_policy policy = cvol_policy_choose(&in);
    view.apart = policy.rays_apart;
    view.coarsest = policy.coarsest;
    assert_int_equal(cvol_sheet_plan_make(context, &plan, array, 0, &view), CVOL_OK);
    cvol_sheet_plan_space(&plan, policy.slices_apart);
    cvol_transfer_free(transfer);
    return plan;
}

/* For soft, unlit functions, slices lie at most one and a half pixel widths apart along a ray; for
 * others as samples. */
static void test_wider_slice_spacing(void **state)
{
    (void)state;
    cvol_volume volume = make_solid(0);
    cvol_array *array = support_compress(context, &volume, 16, 80);
    for (int azimuth = 0; azimuth < 360; azimuth += 25) {
        const int size = 20 + azimuth / 5 % 7 * 9; /* the diagonal is 68 samples */
        cvol_render_options options = support_square(size, CVOL_MODE_COMPOSITE, azimuth, 25);
        const double pixel = sqrt(43.0 * 43 + 35 * 35 + 39 * 39) / size;
        const cvol_sheet_plan whole = plan_of(array, 1, options),
                              soft_one = plan_of(array, 0.5, options);
        assert_int_equal(whole.points_sheet, 16);
        assert_true(soft_one.distance <= fmax(whole.distance, fmax(pixel, 1.5) * 1.55));
        assert_true(fabs(soft_one.distance - whole.distance * soft_one.pitch_sheet) < 1e-9);
        assert_true(soft_one.points_sheet >= 8);
        if (pixel > 1.6)
            assert_true(soft_one.points_sheet < 16);
        if (pixel < 1)
            assert_int_equal(soft_one.points_sheet, 16);
        options.shading.on = 1;
        assert_int_equal(plan_of(array, 0.5, options).points_sheet, 16);
    }
    cvol_array_free(array);
    free(volume.data);
}

/* Soft functions that are not translucent: a picture with fewer slices is close to the ray engine,
 * and differs from one with a slice per sample. */
static void test_close_to_rays_with_fewer_slices(void **state)
{
    (void)state;
    static const cvol_transfer_point half[] = {{30, 0.1, 0.2, 1, 0}, {130, 1, 0.6, 0.1, 0.5}};
    cvol_volume volume = make_solid(3);
    cvol_array *array = support_compress(context, &volume, 16, 80);
    for (int azimuth = 10; azimuth < 360; azimuth += 70) {
        cvol_render_options options = support_square(45, CVOL_MODE_COMPOSITE, azimuth, 25);
        cvol_image *fewer = support_sheet(context, array, half, 2, &options);
        options.step_voxels = 0.125;
        cvol_image *ray = support_ray(context, &volume, half, 2, &options);
        options.step_voxels = 1.99; /* given, so that nothing is chosen */
        cvol_image *all = support_sheet(context, array, half, 2, &options);
        const double db = support_psnr(fewer, ray), all_db = support_psnr(all, ray);
        if (test_verbose() || db < 41)
            print_message("azimuth %d: %.2f dB by fewer sheets, %.2f by all\n", azimuth, db,
                          all_db);
        assert_true(db >= 41);
        assert_true(support_difference(fewer, all) > 0);
        cvol_image_free(fewer);
        cvol_image_free(ray);
        cvol_image_free(all);
    }
    cvol_array_free(array);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_outlines), TEST(test_wider_ray_spacing), TEST(test_light_on_rough_samples),
        TEST(test_wider_slice_spacing), TEST(test_close_to_rays_with_fewer_slices)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
