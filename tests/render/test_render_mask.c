/* Samples without a value are transparent: the sheet engine against the ray engine, and both
 * against options without effect. */
#include "test.h"

#include "array/core/array.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_lapped.h"
#include "support_render.h"

enum { NX = 45, NY = 40, NZ = 50, COUNT = NX * NY * NZ };

static const size_t dims[3] = {NX, NY, NZ}, zero[3] = {0, 0, 0};
static const cvol_mode modes[] = {CVOL_MODE_COMPOSITE, CVOL_MODE_XRAY, CVOL_MODE_MIP};

/* ---- volumes --------------------------------------------------------------------------------- */

/* Balls without a value; one of them holds whole blocks. */
static void random_balls(uint8_t *which, uint64_t seed)
{
    random_state r = {seed};
    double balls[4][4] = {{8, 12, 20, 19}};
    for (int b = 1; b < 4; b++)
        for (int a = 0; a < 4; a++)
            balls[b][a] = a < 3 ? (double)dims[a] * (0.5 + 0.5 * random_signed(&r))
                                : 3 + 6 * fabs(random_signed(&r));
    for (size_t i = 0; i < COUNT; i++) {
        const double at[3] = {(double)(i % NX), (double)(i / NX % NY), (double)(i / NX / NY)};
        which[i] = 0;
        for (int b = 0; b < 4; b++) {
            double square = 0;
            for (int a = 0; a < 3; a++)
                square += (at[a] - balls[b][a]) * (at[a] - balls[b][a]);
            which[i] |= square < balls[b][3] * balls[b][3];
        }
    }
}

static cvol_array *compress(const cvol_volume *volume, const uint8_t *which, double fill)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_volume filled = *volume;
    cvol_array *array;
    options.target = CVOL_TARGET_PSNR;
    options.target_value = 90;
    options.has_fill = 1;
    options.fill = fill;
    filled.data = malloc(COUNT * sizeof(float));
    assert_non_null(filled.data);
    for (size_t i = 0; i < COUNT; i++)
        ((float *)filled.data)[i] = which[i] ? (float)fill : ((float *)volume->data)[i];
    if (cvol_compress(context, &array, NULL, filled.data, &volume->grid, &options))
        fail_msg("%s", cvol_context_message(context));
    free(filled.data);
    return array;
}

/* A lapped array of these samples, cells split at random; only its mask uses `which`. */
static cvol_array *make_lapped(const cvol_volume *volume, const uint8_t *which)
{
    cvol_array *array = support_lapped(context, volume->data, dims, 3, 0.02, 1, 5);
    cvol_fills fills = {0};
    uint64_t bits;
    assert_true(cvol_fills_of_value(&bits, CVOL_FLOAT32, 1e35) && cvol_fills_add(&fills, bits));
    assert_int_equal(cvol_mask_create(context, &array->mask, dims, &fills), CVOL_OK);
    assert_true(cvol_mask_set(array->mask, which, zero, dims));
    return array;
}

static cvol_volume decode(const cvol_array *array)
{
    cvol_volume volume = support_volume(NX, NY, NZ, CVOL_FLOAT32);
    assert_int_equal(cvol_array_evaluate_box(context, volume.data, array, zero, dims), CVOL_OK);
    return volume;
}

/* Under sanitizers every fourth request: of each mode one. */
enum { REQUESTS_STEP = SUPPORT_STRIDE > 1 ? 4 : 1 };

static cvol_render_options request(int k)
{
    static const double zooms[] = {1, 2.5, 0.5};
    cvol_render_options options = support_square(k % 3 == 2 ? 40 : 120, modes[k / 3 % 3],
                                                 50 * k + 10, 37 * (k % 5) - 70);
    options.camera.zoom = zooms[k % 3];
    options.background[2] = 0.5;
    options.camera.fov_deg = k >= 18 ? 70 : 0;
    options.clip.planes = k >= 15;
    options.clip.plane[0][1] = 1;
    return options;
}

/* ---- the tests ------------------------------------------------------------------------------- */

static void test_mask_round_trip(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(NX, NY, NZ);
    uint8_t *which = malloc(COUNT), *found = malloc(COUNT);
    random_balls(which, 3);
    cvol_array *array = compress(&volume, which, 1e35);
    uint64_t masked = 0;
    for (size_t i = 0; i < COUNT; i++)
        masked += which[i];
    assert_int_equal(cvol_array_evaluate_mask(found, array, zero, dims), masked);
    assert_memory_equal(found, which, COUNT);
    cvol_array_free(array);
    array = support_compress(context, &volume, 16, 40);
    assert_int_equal(cvol_array_evaluate_mask(found, array, zero, dims), 0);
    assert_int_equal(found[COUNT / 2], 0);
    cvol_array_free(array);
    free(volume.data);
    free(which);
    free(found);
}

static void compare_engines(const cvol_array *array, const uint8_t *which, const char *what)
{
    /* At the edge of samples with a value a ray either hits or misses: in grey pictures the edges
     * of the two engines differ by at most a pixel. */
    static const double floors_db[3] = {52, 29, 29};
    cvol_volume decoded = decode(array);
    for (int k = 0; k < 21; k += REQUESTS_STEP) {
        const cvol_render_options options = request(k);
        cvol_image *sheet = support_sheet(context, array, support_blob_points, SUPPORT_BLOB_POINTS,
                                          &options);
        cvol_image *ray = support_ray_masked(context, &decoded, which, support_blob_points,
                                             SUPPORT_BLOB_POINTS, options);
        const double db = support_psnr(sheet, ray), floor_db = floors_db[k / 3 % 3];
        if (test_verbose() || db < floor_db)
            print_message("%s request %d mode %d: %.2f dB\n", what, k, (int)options.mode, db);
        assert_true(db >= floor_db);
        cvol_image_free(sheet);
        cvol_image_free(ray);
    }
    free(decoded.data);
}

static void test_engines_agree(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(NX, NY, NZ);
    uint8_t *which = malloc(COUNT);
    random_balls(which, 1);
    cvol_array *array = compress(&volume, which, 1e35);
    compare_engines(array, which, "compressed");
    cvol_array_free(array);
    array = make_lapped(&volume, which);
    compare_engines(array, which, "lapped");
    cvol_array_free(array);
    free(volume.data);
    free(which);
}

/* The values of masked samples and the number of threads have no effect. */
static void test_same_for_any_fill_and_threads(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(NX, NY, NZ);
    uint8_t *which = malloc(COUNT);
    random_balls(which, 2);
    cvol_array *far = compress(&volume, which, 1e35), *near = compress(&volume, which, -7);
    cvol_volume samples[2] = {decode(far), decode(near)};
    for (int k = 0; k < 9; k += REQUESTS_STEP) {
        const cvol_render_options options = request(k);
        cvol_image *images[4];
        for (int i = 0; i < 2; i++) {
            cvol_context_set_threads(context, 1 + 2 * i);
            images[i] = support_sheet(context, i ? near : far, support_blob_points,
                                      SUPPORT_BLOB_POINTS, &options);
            images[2 + i] = support_ray_masked(context, &samples[i], which, support_blob_points,
                                               SUPPORT_BLOB_POINTS, options);
        }
        assert_int_equal(support_difference(images[0], images[1]), 0);
        assert_int_equal(support_difference(images[2], images[3]), 0);
        for (int i = 0; i < 4; i++)
            cvol_image_free(images[i]);
    }
    cvol_array_free(far);
    cvol_array_free(near);
    free(samples[0].data);
    free(samples[1].data);
    free(volume.data);
    free(which);
}

/* Samples of 100 next to samples without a value, the fill 0: a band at 50 would appear at their
 * edges if the two were mixed, and must be invisible. If values rise from 2 to 100, the band is
 * visible from some direction. */
static void test_edges_have_no_halo(void **state)
{
    (void)state;
    static const cvol_transfer_point band[] = {{40, 1, 0, 0, 0},
                                               {45, 1, 0, 0, .9},
                                               {55, 1, 0, 0, .9},
                                               {60, 0, 1, 0, .1},
                                               {100, 0, 1, 0, .1}};
    cvol_volume volume = support_volume(NX, NY, NZ, CVOL_FLOAT32);
    uint8_t *which = malloc(COUNT);
    for (int shining = 0; shining < 2; shining++) {
        random_balls(which, 4);
        for (size_t i = 0; i < COUNT; i++) {
            which[i] |= i % NX > 29;
            ((float *)volume.data)[i] = shining && i % NX < 4 ? 2 : 100;
        }
        cvol_array *arrays[2] = {compress(&volume, which, 0), make_lapped(&volume, which)};
        int seen[2] = {0};
        for (int k = 0; k < 24; k += 2 * SUPPORT_STRIDE - 1) {
            cvol_render_options options = request(k % 12);
            options.mode = CVOL_MODE_COMPOSITE;
            options.background[2] = 0;
            cvol_volume samples = decode(arrays[k % 2]);
            cvol_image *images[2] = {
                support_sheet(context, arrays[k % 2], band, 5, &options),
                support_ray_masked(context, &samples, which, band, 5, options)};
            for (int e = 0; e < 2; e++) {
                int reddest = 0;
                for (int i = 0; i < options.width * options.height; i++)
                    reddest = images[e]->rgba[4 * i] > reddest ? images[e]->rgba[4 * i] : reddest;
                if (!shining && reddest > 0)
                    fail_msg("engine %d, view %d: red up to %d", e, k, reddest);
                seen[e] = reddest > seen[e] ? reddest : seen[e];
                cvol_image_free(images[e]);
            }
            free(samples.data);
        }
        assert_true(!shining || (seen[0] > 100 && seen[1] > 100));
        cvol_array_free(arrays[0]);
        cvol_array_free(arrays[1]);
    }
    free(volume.data);
    free(which);
}

/* A volume in which no sample has a value is background. */
static void test_nothing_is_background(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(NX, NY, NZ);
    uint8_t *which = malloc(COUNT);
    memset(which, 1, COUNT);
    cvol_array *array = make_lapped(&volume, which);
    for (int k = 0; k < 9; k += REQUESTS_STEP) {
        const cvol_render_options options = request(k);
        cvol_image *images[2] = {
            support_sheet(context, array, support_blob_points, SUPPORT_BLOB_POINTS, &options),
            support_ray_masked(context, &volume, which, support_blob_points, SUPPORT_BLOB_POINTS,
                               options)};
        for (int e = 0; e < 2; e++) {
            for (int i = 0; i < options.width * options.height; i++) {
                assert_int_equal(images[e]->rgba[4 * i], 0);
                assert_in_range(images[e]->rgba[4 * i + 2], 127, 128);
            }
            cvol_image_free(images[e]);
        }
    }
    cvol_array_free(array);
    free(volume.data);
    free(which);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_mask_round_trip),
        TEST(test_engines_agree),
        TEST(test_same_for_any_fill_and_threads),
        TEST(test_edges_have_no_halo),
        TEST(test_nothing_is_background),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
