/* Light between two slices, in pictures finer than their samples: close to the ray engine, in
 * either order. CVOL_TEST_VERBOSE=1 prints the measurements. */
#include "test.h"

#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

static const cvol_transfer_point clear[] = {{30, 0.1, 0.2, 1, 0}, {130, 1, 0.6, 0.1, 0.3}};

/* A body with a rough inside, with gradients in all directions. */
static cvol_volume make_body(void)
{
    const size_t n[3] = {44, 36, 40};
    random_state r = {7};
    cvol_volume volume = support_volume(n[0], n[1], n[2], CVOL_FLOAT32);
    for (size_t z = 0; z < n[2]; z++)
        for (size_t y = 0; y < n[1]; y++)
            for (size_t x = 0; x < n[0]; x++) {
                const double at[3] = {(double)x - 22, (double)y - 18, (double)z - 20};
                const double off = hypot(hypot(at[0], at[1]), at[2]);
                ((float *)volume.data)[support_index(&volume, x, y, z)] =
                    (float)(100 / (1 + exp(off - 15)) + 8 * random_signed(&r));
            }
    return volume;
}

/* Against the ray engine, in dB. */
static double compare(const cvol_array *array, const cvol_volume *volume,
                      cvol_render_options options)
{
    return support_sheet_db(context, array, volume, clear, 2, options);
}

static void test_close_to_rays(void **state)
{
    (void)state;
    /* Azimuth, elevation, and dB; with light at slices only, object order has 0.8 to 5.5 dB
     * less. */
    static const double views[][3] = {
        {45, 20, 37}, {30, 45, 37.6}, {225, -35, 35.2}, {135, 0, 37.2}, {0, 90, 45}};
    cvol_volume volume = make_body();
    cvol_array *array = support_compress(context, &volume, 16, 80);
    for (size_t k = 0; k < sizeof views / sizeof *views; k++)
        for (int rays = CVOL_RAY_ORDER_AUTO; rays <= CVOL_RAY_ORDER_OBJECT; rays++) {
            cvol_render_options options = support_square(100, CVOL_MODE_COMPOSITE, views[k][0],
                                                         views[k][1]);
            options.camera.zoom = 3;
            options.shading.on = 1;
            options.sheet.ray_order = (cvol_ray_order)rays;
            const double db = compare(array, &volume, options);
            if (test_verbose() || db < views[k][2])
                print_message("azimuth %g, elevation %g, rays %d: %.2f dB\n", views[k][0],
                              views[k][1], rays, db);
            assert_true(db >= views[k][2]);
        }
    cvol_array_free(array);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_close_to_rays)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
