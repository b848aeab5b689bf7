/* Padding of blocks beyond the volume's end has no effect on the sheet engine's pictures, for any
 * values. */
#include "test.h"

#include "array/core/array.h"
#include "support.h"
#include "support_context.h"
#include "support_lapped.h"
#include "support_render.h"

static const size_t inside[3] = {40, 45, 37};

/* A body that the volume's end cuts; beyond it, extreme values of both signs. */
static cvol_array *make_array(int lapped, int way)
{
    cvol_volume volume = support_volume(48, 48, 48, CVOL_FLOAT32);
    for (size_t z = 0; z < 48; z++)
        for (size_t y = 0; y < 48; y++)
            for (size_t x = 0; x < 48; x++) {
                const double at[3] = {(double)x - 30, (double)y - 30, (double)z - 25};
                const double r2 = at[0] * at[0] + at[1] * at[1] + at[2] * at[2];
                const int is_inside = x < inside[0] && y < inside[1] && z < inside[2];
                const int high = (int)(x + y / 2 + z / 3 + (size_t)way) & 1;
                ((float *)volume.data)[support_index(&volume, x, y, z)] = (float)(is_inside
                                                                                      ? 120 - 0.05 *
                                                                                                  r2
                                                                                  : high ? 120
                                                                                         : 0);
            }
    cvol_array *array = lapped
                            ? support_lapped(context, volume.data, volume.grid.dims, 0, 1e-3, 0, 1)
                            : support_compress(context, &volume, 16, 110);
    for (int a = 0; a < 3; a++)
        array->grid.dims[a] = inside[a];
    free(volume.data);
    return array;
}

static void test_padding_is_ignored(void **state)
{
    (void)state;
    static const cvol_transfer_point clear[] = {{20, 0.1, 0.2, 1, 0}, {110, 1, 0.6, 0.1, 0.2}},
                                     solid[] = {{60, 0.9, 0.5, 0.2, 0}, {70, 1, 0.9, 0.6, 0.9}};
    for (int lapped = 0; lapped < 2; lapped++) {
        cvol_array *arrays[2] = {make_array(lapped, 0), make_array(lapped, 1)};
        for (int k = 0; k < 40; k = support_next(k)) {
            cvol_render_options options = support_square(72, CVOL_MODE_COMPOSITE, 10 + 80 * k,
                                                         55 - 11 * (k % 11));
            options.camera.zoom = 1.2;
            options.shading.on = k % 4 > 1;
            options.sheet.ray_order = k % 3 ? CVOL_RAY_ORDER_IMAGE : CVOL_RAY_ORDER_OBJECT;
            options.sheet.footprint = k % 7 == 6 ? CVOL_SHEET_B_SPLINE : CVOL_SHEET_LINEAR;
            options.step_voxels = k % 8 == 5 ? 0.5 : 0;
            options.camera.fov_deg = k % 9 == 8 ? 30 : 0;
            if (k % 5 == 4) {
                options.mode = CVOL_MODE_ISO;
                options.surface.value = 80;
            }
            cvol_image *images[2];
            for (int i = 0; i < 2; i++)
                images[i] = support_sheet(context, arrays[i], k % 2 ? solid : clear, 2, &options);
            const int off = support_difference(images[0], images[1]);
            if (test_verbose() || off > 2)
                print_message("%s %d: %d\n", lapped ? "lapped" : "plain", k, off);
            assert_true(off <= 2);
            for (int i = 0; i < 2; i++)
                cvol_image_free(images[i]);
        }
        cvol_array_free(arrays[0]);
        cvol_array_free(arrays[1]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_padding_is_ignored, context_setup, context_teardown)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
