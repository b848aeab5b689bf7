/* Masks: samples without a value are found, coded, and come back to the bit; what replaces them for
 * the transform is smooth, and the same for any number of threads and slabs. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "array/mask.h"
#include "codec/mask_code.h"
#include "codec/mask_fill.h"
#include "random.h"

enum { MOST = 64 * 64 * 64 };

/* Balls of masked samples, or none, or all; `fills` kinds. */
static void random_mask(uint8_t *which, random_state *r, const size_t size[3], int fills)
{
    const size_t count = size[0] * size[1] * size[2];
    memset(which, random_below(r, 4) == 0 ? 1 : 0, count);
    for (int ball = (int)random_below(r, 5); ball > 0; ball--) {
        double at[3];
        for (int a = 0; a < 3; a++)
            at[a] = (double)size[a] * (0.5 + 0.5 * random_signed(r));
        const double radius = 1 + 20 * fabs(random_signed(r));
        const uint8_t kind = (uint8_t)random_below(r, (uint32_t)fills + 1);
        for (size_t i = 0; i < count; i++) {
            const double x = (double)(i % size[0]) - at[0],
                         y = (double)(i / size[0] % size[1]) - at[1],
                         z = (double)(i / size[0] / size[1]) - at[2];
            if (x * x + y * y + z * z < radius * radius)
                which[i] = kind;
        }
    }
    for (int i = (int)random_below(r, 20); i > 0; i--)
        which[random_below(r, (uint32_t)count)] = (uint8_t)random_below(r, (uint32_t)fills + 1);
}

static void test_fills_of_types(void **state)
{
    (void)state;
    uint64_t bits;
    assert_true(cvol_fills_of_value(&bits, CVOL_INT16, -2000));
    assert_int_equal(bits, 0x10000 - 2000);
    assert_false(cvol_fills_of_value(&bits, CVOL_UINT8, 254.6));
    assert_false(cvol_fills_of_value(&bits, CVOL_UINT8, 256));
    assert_false(cvol_fills_of_value(&bits, CVOL_UINT16, -1));
    assert_false(cvol_fills_of_value(&bits, CVOL_INT32, (double)NAN));
    assert_true(cvol_fills_of_value(&bits, CVOL_FLOAT32, 1e35));
    const float fill = 1e35f;
    assert_memory_equal(&bits, &fill, 4); /* little-endian: of the tests' machines */
    cvol_fills fills = {0};
    const float samples[8] = {1, NAN, 2, INFINITY, -INFINITY, NAN, 1e35f, 0};
    uint8_t which[8];
    assert_true(cvol_fills_add(&fills, bits));
    assert_true(cvol_fills_add_strange(&fills, CVOL_FLOAT32, samples, 8));
    assert_int_equal(fills.count, 4);
    assert_int_equal(cvol_fills_match(which, &fills, CVOL_FLOAT32, samples, 8), 5);
    const uint8_t expected[8] = {0, 2, 0, 3, 4, 2, 1, 0};
    assert_memory_equal(which, expected, 8);
    float back[8] = {1, 0, 2, 0, 0, 0, 0, 0};
    cvol_fills_apply(back, &fills, CVOL_FLOAT32, which, 8);
    assert_memory_equal(back, samples, sizeof back);
    for (uint64_t i = 10; i < 13; i++)
        assert_true(cvol_fills_add(&fills, i));
    assert_true(cvol_fills_add(&fills, 10));
    assert_false(cvol_fills_add(&fills, 99));
}

static void test_masks_keep_what_they_are_given(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    uint8_t *which = malloc(MOST), *got = malloc(MOST);
    assert_true(which && got);
    for (uint64_t seed = 1; seed <= 60; seed++) {
        random_state r = {seed};
        cvol_fills fills = {.count = 1 + (int)random_below(&r, CVOL_FILLS_MAX)};
        size_t size[3], zero[3] = {0, 0, 0};
        for (int a = 0; a < 3; a++)
            size[a] = 1 + random_below(&r, 64);
        cvol_mask *mask;
        random_mask(which, &r, size, fills.count);
        assert_int_equal(cvol_mask_create(context, &mask, size, &fills), CVOL_OK);
        assert_int_equal(cvol_mask_samples(mask), 0);
        assert_true(cvol_mask_set(mask, which, zero, size));
        size_t masked = 0;
        for (size_t i = 0; i < size[0] * size[1] * size[2]; i++)
            masked += which[i] != 0;
        assert_int_equal(cvol_mask_samples(mask), masked);
        for (int i = 0; i < 5; i++) {
            size_t begin[3], end[3], n = 0;
            for (int a = 0; a < 3; a++) {
                begin[a] = i ? random_below(&r, (uint32_t)size[a]) : 0;
                end[a] = i ? begin[a] + 1 + random_below(&r, (uint32_t)(size[a] - begin[a]))
                           : size[a];
            }
            cvol_mask_get(got, mask, begin, end);
            for (size_t z = begin[2]; z < end[2]; z++)
                for (size_t y = begin[1]; y < end[1]; y++)
                    for (size_t x = begin[0]; x < end[0]; x++, n++)
                        if (got[n] != which[x + size[0] * (y + size[1] * z)])
                            fail_msg("seed %llu: other at %zu %zu %zu", (unsigned long long)seed, x,
                                     y, z);
        }
        const size_t first[3] = {0, 0, 0};
        const cvol_mask_state cell = cvol_mask_cell(mask, first);
        size_t inside = 0, all = 0;
        for (size_t z = 0; z < 16 && z < size[2]; z++)
            for (size_t y = 0; y < 16 && y < size[1]; y++)
                for (size_t x = 0; x < 16 && x < size[0]; x++, all++)
                    inside += which[x + size[0] * (y + size[1] * z)] != 0;
        assert_true((cell == CVOL_MASK_NONE) == (inside == 0));
        assert_true(cell != CVOL_MASK_ALL || inside == all);
        cvol_mask_free(mask);
    }
    free(which);
    free(got);
    cvol_context_destroy(context);
}

static void test_masks_pass_through_their_bytes(void **state)
{
    (void)state;
    cvol_token_tables *tables = cvol_token_tables_create();
    cvol_token_writer writer = {0};
    cvol_bytes bytes = {0};
    uint8_t *which = malloc(MOST), *got = malloc(MOST);
    assert_true(tables && which && got);
    for (uint64_t seed = 1; seed <= 100; seed++) {
        random_state r = {seed};
        const int fills = seed % 2 ? 1 : 1 + (int)random_below(&r, CVOL_FILLS_MAX);
        size_t size[3];
        for (int a = 0; a < 3; a++)
            size[a] = seed % 4 ? 1 + random_below(&r, 64) : 64;
        random_mask(which, &r, size, fills);
        assert_true(cvol_mask_encode(&writer, &bytes, tables, which, size, fills, NULL));
        cvol_span span = {bytes.data, bytes.size};
        memset(got, 99, MOST);
        assert_true(cvol_mask_decode(got, size, fills, tables, span));
        if (memcmp(got, which, size[0] * size[1] * size[2]))
            fail_msg("seed %llu: another mask", (unsigned long long)seed);
        if (!bytes.size)
            continue;
        uint8_t *copy = malloc(bytes.size);
        assert_non_null(copy);
        memcpy(copy, bytes.data, bytes.size);
        copy[random_below(&r, (uint32_t)bytes.size)] ^= (uint8_t)(1 << random_below(&r, 8));
        span.data = copy;
        span.size -= random_below(&r, 2) ? random_below(&r, (uint32_t)bytes.size) : 0;
        memset(got, 0, MOST);
        if (cvol_mask_decode(got, size, fills, tables, span))
            for (size_t i = 0; i < size[0] * size[1] * size[2]; i++)
                assert_true(got[i] <= fills);
        free(copy);
    }
    cvol_token_writer_free(&writer);
    cvol_bytes_free(&bytes);
    free(tables);
    free(which);
    free(got);
}

static void test_fillings_are_smooth(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    const cvol_grid grid = cvol_grid_make(90, 70, 80, CVOL_FLOAT32);
    const size_t *dims = grid.dims, count = dims[0] * dims[1] * dims[2], zero[3] = {0, 0, 0};
    float *samples = malloc(count * sizeof *samples), *filled = malloc(count * sizeof *filled);
    float *again = malloc(count * sizeof *again);
    uint8_t *which = malloc(count);
    cvol_fills fills = {0};
    uint64_t bits;
    cvol_mask *mask;
    assert_true(samples && filled && again && which);
    cvol_fills_of_value(&bits, CVOL_FLOAT32, 1e35);
    cvol_fills_add(&fills, bits);
    for (size_t i = 0; i < count; i++) {
        const double x = (double)(i % dims[0]), y = (double)(i / dims[0] % dims[1]),
                     z = (double)(i / dims[0] / dims[1]);
        const int is_masked = (x - 30) * (x - 30) + (y - 30) * (y - 30) + (z - 40) * (z - 40) < 150;
        samples[i] = is_masked ? 1e35f : (float)(5 + 0.1 * x + 0.05 * y - 0.02 * z);
    }
    assert_int_equal(cvol_fills_match(which, &fills, CVOL_FLOAT32, samples, count) > 1000, 1);
    assert_int_equal(cvol_mask_create(context, &mask, dims, &fills), CVOL_OK);
    assert_true(cvol_mask_set(mask, which, zero, dims));
    cvol_context_set_threads(context, 1);
    assert_int_equal(cvol_mask_fill(context, filled, samples, &grid, mask, 0, dims[2], 3), CVOL_OK);
    for (size_t i = 0; i < count; i++) {
        if (!which[i])
            assert_true(filled[i] == samples[i]);
        assert_true(filled[i] > 3 && filled[i] < 19);
        if (i % dims[0] && which[i])
            assert_true(fabsf(filled[i] - filled[i - 1]) < 0.7f);
    }
    cvol_context_set_threads(context, 3);
    assert_int_equal(cvol_mask_fill(context, again, samples, &grid, mask, 0, 64, 3), CVOL_OK);
    const size_t at = 64 * dims[0] * dims[1];
    assert_int_equal(cvol_mask_fill(context, again + at, samples + at, &grid, mask, 64, dims[2], 3),
                     CVOL_OK);
    assert_memory_equal(filled, again, count * sizeof *filled);
    cvol_mask_free(mask);
    free(samples);
    free(filled);
    free(again);
    free(which);
    cvol_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_fills_of_types),
        cmocka_unit_test(test_masks_keep_what_they_are_given),
        cmocka_unit_test(test_masks_pass_through_their_bytes),
        cmocka_unit_test(test_fillings_are_smooth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
