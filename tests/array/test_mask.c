/* Masks: samples without a value are found, coded, and restored to the bit; their replacements for
 * the transform are smooth, and the same for any number of threads and slabs. */
#include "test.h"

#include "array/core/mask.h"
#include "codec/mask/mask_code.h"
#include "codec/mask/mask_fill.h"
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
    assert_true(cvol_fills_add_nonfinite(&fills, CVOL_FLOAT32, samples, 8));
    assert_int_equal(fills.count, 4);
    assert_int_equal(cvol_fills_match(which, &fills, CVOL_FLOAT32, samples, 8), 5);
    const uint8_t expected[8] = {0, 2, 0, 3, 4, 2, 1, 0};
    assert_memory_equal(which, expected, 8);
    for (uint64_t i = 10; i < 13; i++)
        assert_true(cvol_fills_add(&fills, i));
    assert_true(cvol_fills_add(&fills, 10));
    assert_false(cvol_fills_add(&fills, 99));
}

static void test_masks_keep_set_samples(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    uint8_t *which = malloc(MOST), *got = malloc(MOST);
    uint16_t *written = malloc(MOST * sizeof *written);
    assert_true(which && got && written);
    for (uint64_t seed = 1; seed <= 60; seed++) {
        random_state r = {seed};
        cvol_fills fills = {.count = 1 + (int)random_below(&r, CVOL_FILLS_MAX)};
        for (int f = 0; f < CVOL_FILLS_MAX; f++)
            fills.bits[f] = 100 + (uint64_t)f;
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
            memset(written, 9, sizeof *written * MOST);
            cvol_mask_write(written, sizeof *written, fills.bits, mask, begin, end);
            for (size_t z = begin[2]; z < end[2]; z++)
                for (size_t y = begin[1]; y < end[1]; y++)
                    for (size_t x = begin[0]; x < end[0]; x++, n++) {
                        const uint8_t own = which[x + size[0] * (y + size[1] * z)];
                        if (got[n] != own || written[n] != (own ? 99 + own : 0x0909))
                            fail_msg("seed %llu: other at %zu %zu %zu", (unsigned long long)seed, x,
                                     y, z);
                    }
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
    free(written);
    cvol_context_free(context);
}

/* A brick's mask by cells, from a mask of the brick's size. */
static void cut_into_cells(cvol_mask_brick *brick, cvol_context *context, const uint8_t *which,
                           const size_t size[3], int fills)
{
    const cvol_fills some = {.count = fills};
    const size_t zero[3] = {0, 0, 0};
    size_t planes = 0;
    cvol_mask *mask;
    assert_int_equal(cvol_mask_create(context, &mask, size, &some), CVOL_OK);
    assert_true(cvol_mask_set(mask, which, zero, size));
    memset(brick, 0, sizeof *brick);
    memcpy(brick->size, size, sizeof brick->size);
    brick->fills = fills;
    while (fills >> planes)
        planes++;
    for (size_t l = 0; l * 16 < size[2]; l++)
        for (size_t j = 0; j * 16 < size[1]; j++)
            for (size_t i = 0; i * 16 < size[0]; i++) {
                const cvol_mask_rows *rows;
                brick->states[l][j][i] = cvol_mask_cell_get(mask, (size_t[3]){i, j, l}, &rows);
                if (brick->states[l][j][i] == CVOL_MASK_MIXED)
                    memcpy(brick->rows[l][j][i], rows, planes * sizeof *rows);
            }
    cvol_mask_free(mask);
}

/* Describes the difference of two bricks' masks, or NULL. */
static const char *difference(const cvol_mask_brick *a, const cvol_mask_brick *b)
{
    size_t planes = 0;
    while (a->fills >> planes)
        planes++;
    for (size_t l = 0; l * 16 < a->size[2]; l++)
        for (size_t j = 0; j * 16 < a->size[1]; j++)
            for (size_t i = 0; i * 16 < a->size[0]; i++) {
                if (a->states[l][j][i] != b->states[l][j][i])
                    return "state";
                if (a->states[l][j][i] != CVOL_MASK_MIXED)
                    continue;
                if (memcmp(a->rows[l][j][i], b->rows[l][j][i], planes * sizeof(cvol_mask_rows)))
                    return "row";
            }
    return NULL;
}

static void test_masks_round_trip(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_range_encoder coder = {0};
    cvol_bytes bytes = {0};
    uint8_t *which = malloc(MOST);
    cvol_mask_brick *brick = malloc(sizeof *brick), *got = malloc(sizeof *got);
    cvol_mask_brick *copy = malloc(sizeof *copy);
    assert_true(which && brick && got && copy);
    for (uint64_t seed = 1; seed <= 100; seed++) {
        random_state r = {seed};
        const int fills = seed % 2 ? 1 : 1 + (int)random_below(&r, CVOL_FILLS_MAX);
        size_t size[3];
        for (int a = 0; a < 3; a++)
            size[a] = seed % 4 ? 1 + random_below(&r, 64) : 64;
        random_mask(which, &r, size, fills);
        cut_into_cells(brick, context, which, size, fills);
        *copy = *brick;
        assert_true(cvol_mask_encode(&coder, &bytes, brick));
        if (memcmp(copy, brick, sizeof *brick))
            fail_msg("seed %llu: encoding changes the mask", (unsigned long long)seed);
        cvol_span span = {bytes.data, bytes.size};
        memset(got, 99, sizeof *got);
        memcpy(got->size, size, sizeof size);
        got->fills = fills;
        assert_true(cvol_mask_decode(got, span));
        if (difference(brick, got))
            fail_msg("seed %llu: another %s", (unsigned long long)seed, difference(brick, got));
        if (!bytes.size)
            continue;
        uint8_t *damaged = malloc(bytes.size);
        assert_non_null(damaged);
        memcpy(damaged, bytes.data, bytes.size);
        damaged[random_below(&r, (uint32_t)bytes.size)] ^= (uint8_t)(1 << random_below(&r, 8));
        span.data = damaged;
        span.size -= random_below(&r, 2) ? random_below(&r, (uint32_t)bytes.size) : 0;
        if (cvol_mask_decode(got, span))
            for (size_t l = 0; l * 16 < size[2]; l++)
                for (size_t j = 0; j * 16 < size[1]; j++)
                    for (size_t i = 0; i * 16 < size[0]; i++)
                        assert_true(got->states[l][j][i] <= fills ||
                                    got->states[l][j][i] == CVOL_MASK_MIXED);
        free(damaged);
    }
    cvol_range_encoder_free(&coder);
    cvol_bytes_free(&bytes);
    free(which);
    free(brick);
    free(got);
    free(copy);
    cvol_context_free(context);
}

/* Numbers of fills are bits, so damaged bytes may name fills that the brick does not have: in
 * masked cells, and in rows of mixed ones. */
static void test_unknown_fills_are_refused(void **state)
{
    (void)state;
    enum { FILLS = 5, SIDE = 20 };
    cvol_context *context = cvol_context_create();
    cvol_range_encoder coder = {0};
    cvol_bytes bytes = {0};
    const size_t size[3] = {SIDE, SIDE, SIDE};
    uint8_t *which = malloc(SIDE * SIDE * SIDE);
    cvol_mask_brick *brick = malloc(sizeof *brick);
    assert_true(which && brick);
    for (int is_mixed = 0; is_mixed < 2; is_mixed++) {
        memset(which, is_mixed ? 0 : FILLS, SIDE * SIDE * SIDE);
        which[7] = FILLS;
        cut_into_cells(brick, context, which, size, FILLS);
        assert_true(cvol_mask_encode(&coder, &bytes, brick));
        assert_true(cvol_mask_decode(brick, (cvol_span){bytes.data, bytes.size}));
        assert_int_equal(brick->states[0][0][0], is_mixed ? CVOL_MASK_MIXED : FILLS);
        int refused = 0;
        for (size_t at = 0; at < bytes.size; at++)
            for (int bit = 0; bit < 8; bit++) {
                bytes.data[at] ^= (uint8_t)(1 << bit);
                refused += !cvol_mask_decode(brick, (cvol_span){bytes.data, bytes.size});
                bytes.data[at] ^= (uint8_t)(1 << bit);
            }
        assert_true(refused > 0);
    }
    cvol_range_encoder_free(&coder);
    cvol_bytes_free(&bytes);
    free(which);
    free(brick);
    cvol_context_free(context);
}

/* A smooth surface costs less than one bit for each sample next to it. */
static void test_smooth_masks_are_small(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_range_encoder coder = {0};
    cvol_bytes bytes = {0};
    const size_t size[3] = {64, 64, 64};
    uint8_t *which = malloc(MOST);
    cvol_mask_brick *brick = malloc(sizeof *brick);
    size_t edge = 0;
    assert_true(which && brick);
    for (int i = 0; i < MOST; i++) {
        const double x = i % 64 - 30.3, y = i / 64 % 64 - 33.1, z = i / 4096 - 29.6;
        which[i] = x * x + 1.3 * y * y + 0.8 * z * z > 27 * 27;
        edge += i % 64 && which[i] != which[i - 1];
        edge += i / 64 % 64 && which[i] != which[i - 64];
        edge += i >= 4096 && which[i] != which[i - 4096];
    }
    cut_into_cells(brick, context, which, size, 1);
    assert_true(cvol_mask_encode(&coder, &bytes, brick));
    assert_in_range(bytes.size, 1, edge / 20);
    cvol_range_encoder_free(&coder);
    cvol_bytes_free(&bytes);
    free(which);
    free(brick);
    cvol_context_free(context);
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
    cvol_context_free(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_fills_of_types),
        cmocka_unit_test(test_masks_keep_set_samples),
        cmocka_unit_test(test_masks_round_trip),
        cmocka_unit_test(test_smooth_masks_are_small),
        cmocka_unit_test(test_unknown_fills_are_refused),
        cmocka_unit_test(test_fillings_are_smooth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
