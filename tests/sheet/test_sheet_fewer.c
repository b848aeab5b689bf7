/* Faster options of the sheet engine, for all kinds of arrays: a slice for every two (a step of two
 * samples or more) and fewer rays than pixels (oversample below 1), against the ray engine; cached
 * blocks (keep_mb), which change no picture. Floors are the measured PSNR minus about 1.5 dB.
 * CVOL_TEST_VERBOSE=1 prints the measurements. */
#include "test.h"

#include "array/core/array.h"
#include "render/sheet/band/block_cache.h"
#include "support.h"
#include "support_context.h"
#include "support_lapped.h"
#include "support_render.h"

/* ---- arrays ---------------------------------------------------------------------------------- */

enum { BY_16, BY_8, BY_32, LAPPED, SPLIT, BACKGROUND, VOID, KINDS };
static const char *const kind_names[KINDS] = {"by 16", "by 8",       "by 32", "lapped",
                                              "split", "background", "void"};

/* Tests if a ball holds this sample, which belongs to no field. */
static int is_beyond(const cvol_volume *volume, size_t i)
{
    const size_t *n = volume->grid.dims;
    const double at[3] = {(double)(i % n[0]) - 12, (double)(i / n[0] % n[1]) - 9,
                          (double)(i / n[0] / n[1]) - 20};
    return at[0] * at[0] + at[1] * at[1] + at[2] * at[2] < 144;
}

/* An array of that kind, close to the samples; writes samples that differ, and their marks in
 * which[]. */
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

/* By the sheet engine: the default, fewer slices, fewer rays. */
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

/* Views along all axes, in both directions, with alternating modes, light, perspective and
 * clips. */
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

/* db: with all slices and one ray per pixel, with fewer slices, with fewer rays. */
static void expect(const char *what, int kind, int k, const double db[3])
{
    const double least[2] = {kind == VOID ? 41 : 46.4, 45.4}; /* for fewer slices, for fewer rays */
    const int good = db[1] >= least[0] && db[2] >= least[1];
    if (test_verbose() || !good)
        print_message("%s %s, request %d: %.2f dB, sheets %.2f, rays %.2f\n", what,
                      kind_names[kind], k, db[0], db[1], db[2]);
    assert_true(good);
}

static void test_close_to_rays(void **state)
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

/* With threads, and with both options together. */
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

/* ---- cached blocks --------------------------------------------------------------------------- */

#define PICTURES 6

/* Alternately the default, fewer slices, fewer rays, and a level. */
static cvol_render_options request_kept(int k, double keep_mb)
{
    cvol_render_options options = request(k);
    options.step_voxels = k % 4 == 1 ? 4 : 0;
    options.oversample = k % 4 == 2 ? 0.6 : 0;
    options.level = k % 4 == 3;
    options.sheet.ray_order = k % 2 ? CVOL_RAY_ORDER_IMAGE : CVOL_RAY_ORDER_OBJECT;
    options.keep_mb = keep_mb;
    return options;
}

/* One renderer draws all, repeatedly: first with room for everything, then with little. */
static void expect_same(int kind, const cvol_array *array, cvol_image *const *expected)
{
    cvol_renderer *renderer;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    support_set_transfer(context, renderer, support_blob_points, SUPPORT_BLOB_POINTS);
    assert_int_equal(cvol_renderer_kept_bytes(renderer), 0);
    for (int round = 0; round < 4; round++)
        for (int k = 0; k < PICTURES; k++) {
            const cvol_render_options options = request_kept(k + kind, round < 2 ? 100 : 0.06);
            cvol_context_set_threads(context, 1 + round % 2);
            cvol_image *image = support_picture(context, renderer, &options);
            if (support_difference(image, expected[k]))
                fail_msg("%s, request %d, round %d: another picture", kind_names[kind], k + kind,
                         round);
            cvol_image_free(image);
            if (round < 2)
                assert_true(cvol_renderer_kept_bytes(renderer) > 60000);
            else
                assert_true(cvol_renderer_kept_bytes(renderer) <= 60000);
        }
    cvol_renderer_free(renderer);
}

static void test_kept_same_bits(void **state)
{
    (void)state;
    for (int kind = 0; kind < KINDS; kind++) {
        cvol_volume volume = support_blobs(45, 40, 50);
        uint8_t *which = malloc(cvol_grid_samples(&volume.grid));
        assert_non_null(which);
        cvol_array *array = make(kind, &volume, which);
        cvol_image *expected[PICTURES];
        for (int k = 0; k < PICTURES; k++) {
            const cvol_render_options options = request_kept(k + kind, 0);
            expected[k] = support_sheet(context, array, support_blob_points, SUPPORT_BLOB_POINTS,
                                        &options);
        }
        expect_same(kind, array, expected);
        for (int k = 0; k < PICTURES; k++)
            cvol_image_free(expected[k]);
        cvol_array_free(array);
        free(volume.data);
        free(which);
    }
}

enum { LANES = 14, ROWS = 12, SHEETS = 8, ROW_STRIDE = 20, SHEET_STRIDE = 300 };
#define BLOCK_MB (LANES * ROWS * SHEETS * sizeof(int16_t) / 1e6)

static void put(cvol_block_set *kept, size_t index)
{
    int16_t samples[SHEETS * SHEET_STRIDE];
    for (int i = 0; i < SHEETS * SHEET_STRIDE; i++)
        samples[i] = (int16_t)(i + 7 * (int)index);
    cvol_block_store_put(kept, index, samples, ROW_STRIDE, SHEET_STRIDE);
}

/* Tests if a block is stored: then it is unchanged, and nothing is written next to it. */
static int has(const cvol_block_set *kept, size_t index)
{
    int16_t samples[SHEETS * SHEET_STRIDE];
    memset(samples, -1, sizeof samples);
    const int is_kept = cvol_block_store_take(kept, index, samples, ROW_STRIDE, SHEET_STRIDE);
    for (int i = 0; i < SHEETS * SHEET_STRIDE; i++) {
        const int inside = i % SHEET_STRIDE < ROWS * ROW_STRIDE &&
                           i % SHEET_STRIDE % ROW_STRIDE < LANES;
        assert_int_equal(samples[i], is_kept && inside ? i + 7 * (int)index : -1);
    }
    assert_int_equal(cvol_block_store_prefetch(kept, index), is_kept);
    return is_kept;
}

/* Blocks are stored while there is room; those of the last drawn view stay. */
static void test_kept_room(void **state)
{
    (void)state;
    cvol_block_store keep = {0};
    cvol_sheet_plan plan = {.axis_sheet = 2,
                            .points_lane = LANES,
                            .points_row = ROWS,
                            .points_sheet = SHEETS,
                            .int16 = {3, 4}};
    assert_null(cvol_block_store_open(&keep, &plan, 9, 0));
    assert_false(has(NULL, 0));
    cvol_block_set *first = cvol_block_store_open(&keep, &plan, 9, 3.5 * BLOCK_MB);
    assert_false(has(first, 5));
    put(first, 5);
    put(first, 8);
    assert_true(has(first, 5) && has(first, 8) && !has(first, 0));
    assert_ptr_equal(cvol_block_store_open(&keep, &plan, 9, 3.5 * BLOCK_MB), first);
    plan.axis_sheet = 0;
    cvol_block_set *second = cvol_block_store_open(&keep, &plan, 9, 3.5 * BLOCK_MB);
    assert_ptr_not_equal(second, first);
    put(second, 1);
    put(second, 2);
    assert_true(has(second, 1) && !has(second, 2) && has(first, 5));
    assert_ptr_equal(cvol_block_store_open(&keep, &plan, 9, 3.5 * BLOCK_MB), second);
    assert_null(first->blocks); /* it made room */
    put(second, 2);
    put(second, 3);
    assert_true(has(second, 1) && has(second, 2) && has(second, 3));
    assert_ptr_equal(cvol_block_store_open(&keep, &plan, 9, 2.5 * BLOCK_MB), keep.kinds);
    assert_false(has(keep.kinds, 1)); /* less room than they take */
    cvol_block_store_free(&keep);
    assert_int_equal(atomic_load(&keep.taken), 0);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_close_to_rays), TEST(test_same_bits),
                                       TEST(test_kept_same_bits), TEST(test_kept_room)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
