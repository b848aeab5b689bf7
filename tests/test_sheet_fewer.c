/* The sheet engine with a sheet for every two slices (a step of two samples or more) and with fewer
 * rays than pixels (oversample below 1), of all kinds of arrays, against the ray engine.
 *
 * Floors are what was measured, less about 1.5 dB. CVOL_TEST_VERBOSE=1 prints what is measured.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "array/array.h"
#include "support_context.h"
#include "support_lapped.h"
#include "support_render.h"

/* ---- arrays ---------------------------------------------------------------------------------- */

enum { BY_16, BY_8, BY_32, LAPPED, SPLIT, BACKGROUND, VOID, KINDS };
static const char *const kind_names[KINDS] = {"by 16", "by 8",       "by 32", "lapped",
                                              "split", "background", "void"};

/* Whether a ball holds this sample that belongs to no field. */
static int is_beyond(const cvol_volume *volume, size_t i)
{
    const size_t *n = volume->grid.dims;
    const double at[3] = {(double)(i % n[0]) - 12, (double)(i / n[0] % n[1]) - 9,
                          (double)(i / n[0] / n[1]) - 20};
    return at[0] * at[0] + at[1] * at[1] + at[2] * at[2] < 144;
}

/* An array of that kind, near to the samples; what lies apart is set in them, and in which[]. */
static cvol_array *make(int kind, const cvol_volume *volume, uint8_t *which)
{
    const size_t count = cvol_grid_samples(&volume->grid);
    float *samples = volume->data;
    memset(which, 0, count);
    if (kind <= BY_32)
        return support_compress(context, volume, (int[]){16, 8, 32}[kind], 75);
    if (kind <= SPLIT)
        return support_lapped(context, samples, volume->grid.dims, 3, 0.02, kind == SPLIT, 5);
    for (size_t i = 0; i < count; i++) {
        which[i] = (uint8_t)is_beyond(volume, i);
        if (which[i])
            samples[i] = kind == VOID ? 1e30f : 0;
    }
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target = CVOL_TARGET_PSNR;
    options.target_value = 75;
    options.background = kind == VOID ? CVOL_BACKGROUND_NONE : CVOL_BACKGROUND_VALUE;
    options.has_fill = kind == VOID;
    options.fill = 1e30;
    if (kind == BACKGROUND)
        memset(which, 0, count);
    cvol_array *array;
    if (cvol_compress(context, &array, NULL, samples, &volume->grid, &options))
        fail_msg("%s", cvol_context_message(context));
    assert_non_null(array->mask);
    return array;
}

/* ---- pictures -------------------------------------------------------------------------------- */

/* By the sheet engine: as it is, with fewer sheets, with fewer rays. */
static void measure(double db[3], cvol_array *array, const cvol_volume *volume,
                    const uint8_t *which, cvol_render_options options)
{
    cvol_image *ray = support_ray_masked(context, volume, which, support_blob_points,
                                         SUPPORT_BLOB_POINTS, options);
    for (int i = 0; i < 3; i++) {
        options.step_voxels = i == 1 ? 4 : 0;
        options.oversample = i == 2 ? 0.6 : 0;
        cvol_image *sheet = support_sheet(context, array, support_blob_points, SUPPORT_BLOB_POINTS,
                                          &options);
        db[i] = support_psnr(sheet, ray);
        cvol_image_free(sheet);
    }
    cvol_image_free(ray);
}

/* Views along all axes, both ways; modes, light, perspective and clips in turn. */
static cvol_render_options request(int k)
{
    static const cvol_mode modes[] = {CVOL_MODE_COMPOSITE, CVOL_MODE_XRAY, CVOL_MODE_COMPOSITE,
                                      CVOL_MODE_MIP};
    cvol_render_options options = support_square(k % 3 == 2 ? 40 : 110, modes[k % 4], 97 * k + 10,
                                                 53 * (k % 4) - 80);
    options.camera.zoom = k % 5 == 4 ? 2.5 : 1;
    options.shading.on = k % 4 == 2;
    options.camera.fov_deg = k % 6 == 5 ? 60 : 0;
    options.clip.planes = k % 5 == 3;
    options.clip.plane[0][0] = 1;
    options.clip.plane[0][2] = 0.3;
    return options;
}

/* db: with a sheet a slice and a ray a pixel, with fewer sheets, with fewer rays. */
static void expect(const char *what, int kind, int k, const double db[3])
{
    const double least[2] = {kind == VOID ? 41 : 46.4, 45.4}; /* of fewer sheets, of fewer rays */
    const int good = db[1] >= least[0] && db[2] >= least[1];
    if (getenv("CVOL_TEST_VERBOSE") || !good)
        print_message("%s %s, request %d: %.2f dB, sheets %.2f, rays %.2f\n", what,
                      kind_names[kind], k, db[0], db[1], db[2]);
    assert_true(good || getenv("CVOL_TEST_VERBOSE"));
}

static void test_near_to_rays(void **state)
{
    (void)state;
    static const size_t dims[][3] = {{45, 40, 50}, {34, 48, 33}};
    for (int kind = 0; kind < KINDS; kind++)
        for (int d = 0; d < 2; d++) {
            cvol_volume volume = support_blobs(dims[d][0], dims[d][1], dims[d][2]);
            uint8_t *which = malloc(cvol_grid_samples(&volume.grid));
            assert_non_null(which);
            cvol_array *array = make(kind, &volume, which);
            for (int k = d; k < 12; k += 4) {
                double db[3];
                measure(db, array, &volume, which, request(k + kind));
                expect(d ? "narrow" : "wide", kind, k + kind, db);
            }
            cvol_array_free(array);
            free(volume.data);
            free(which);
        }
}

/* With threads, and with the two at once. */
static void test_same_bits(void **state)
{
    (void)state;
    for (int kind = LAPPED; kind < KINDS; kind++) {
        cvol_volume volume = support_blobs(45, 40, 50);
        uint8_t *which = malloc(cvol_grid_samples(&volume.grid));
        assert_non_null(which);
        cvol_array *array = make(kind, &volume, which);
        cvol_render_options options = request(2 * kind);
        options.step_voxels = 4;
        options.oversample = 0.7;
        cvol_context_set_threads(context, 1);
        cvol_image *one = support_sheet(context, array, support_blob_points, SUPPORT_BLOB_POINTS,
                                        &options);
        cvol_context_set_threads(context, 3);
        cvol_image *three = support_sheet(context, array, support_blob_points, SUPPORT_BLOB_POINTS,
                                          &options);
        assert_int_equal(support_difference(one, three), 0);
        cvol_image_free(one);
        cvol_image_free(three);
        cvol_array_free(array);
        free(volume.data);
        free(which);
    }
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_near_to_rays), TEST(test_same_bits)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
