/* The coder: quantiser, range coder, blocks and groups, in and out; and garbage. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/group.h"
#include "codec/quantise.h"
#include "codec/rate_distortion.h"
#include "codec/search.h"
#include "random.h"

static const int sides[] = {8, 16, 32};

/* ---- range coder ------------------------------------------------------------------------ */

enum { BITS = 200000, CONTEXTS = 5 };

/* Bits of five skewed sources, and raw numbers between them. */
static void code_skewed(random_state seed, cvol_range_encoder *out, cvol_range_decoder *in)
{
    static const uint32_t ones[CONTEXTS] = {1, 100, 32768, 60000, 65535};
    cvol_probability p[CONTEXTS];
    for (int i = 0; i < CONTEXTS; i++)
        p[i] = (cvol_probability){32768, 32768};
    for (int i = 0; i < BITS; i++) {
        int which = (int)random_below(&seed, CONTEXTS);
        int bit = random_below(&seed, 65536) < ones[which];
        int count = (int)random_below(&seed, 33);
        uint32_t raw = (uint32_t)(random_u64(&seed) & ((UINT64_C(1) << count) - 1));
        if (out) {
            cvol_encode_bit(out, &p[which], bit);
            if (i % 7 == 0)
                cvol_encode_raw(out, raw, count);
        } else {
            assert_int_equal(cvol_decode_bit(in, &p[which]), bit);
            if (i % 7 == 0)
                assert_int_equal(cvol_decode_raw(in, count), raw);
        }
    }
}

static void range_coder_round_trip(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 5; seed++) {
        cvol_range_encoder out = {0};
        cvol_range_decoder in;
        cvol_bytes bytes = {0};
        cvol_range_encoder_start(&out);
        code_skewed((random_state){seed}, &out, NULL);
        assert_true(cvol_range_encoder_finish(&out, &bytes));
        /* In memory of exactly its size: a read beyond it is seen by the sanitizer. */
        uint8_t *exact = malloc(bytes.size);
        assert_non_null(exact);
        memcpy(exact, bytes.data, bytes.size);
        cvol_range_decoder_start(&in, exact, bytes.size);
        code_skewed((random_state){seed}, NULL, &in);
        assert_false(cvol_range_decoder_overrun(&in));
        free(exact);
        cvol_bytes_free(&bytes);
        cvol_range_encoder_free(&out);
    }
}

static void range_decoder_notes_the_end(void **state)
{
    (void)state;
    const uint8_t data[3] = {0x12, 0x34, 0x56};
    cvol_probability p = {32768, 32768};
    cvol_range_decoder in;
    cvol_range_decoder_start(&in, data, sizeof data);
    assert_false(cvol_range_decoder_overrun(&in));
    for (int i = 0; i < 10000; i++)
        (void)cvol_decode_bit(&in, &p);
    for (int i = 0; i < 100; i++)
        (void)cvol_decode_raw(&in, 32);
    assert_true(cvol_range_decoder_overrun(&in));
    cvol_range_decoder_start(&in, NULL, 0);
    assert_true(cvol_range_decoder_overrun(&in));
}

/* ---- blocks and groups ------------------------------------------------------------------ */

typedef enum kind { ZERO, ONLY_DC, SPARSE, DENSE, EXTREME, DECAYING, KINDS } kind;

static int32_t random_value(random_state *r, kind how, int index)
{
    switch (how) {
    case ONLY_DC:
        return index ? 0 : (int32_t)random_below(r, 2001) - 1000;
    case SPARSE:
        return random_below(r, 50) ? 0 : (int32_t)random_below(r, 7) - 3;
    case DENSE:
        return random_below(r, 2) ? (int32_t)random_below(r, 9) + 1 : -1;
    case EXTREME:
        return random_below(r, 2) ? CVOL_VALUE_LIMIT : -CVOL_VALUE_LIMIT;
    case DECAYING:
        return (int32_t)(random_signed(r) * 1e9 / (1.0 + index) / (1.0 + index));
    default:
        return 0;
    }
}

/* A source of blocks: block `index` is a function of the seed and the index. */
typedef struct random_source {
    uint64_t seed;
    int all; /* a kind, or KINDS: any */
} random_source;

static int fetch_random(const void *user, int32_t *values, cvol_block_coder *coder, size_t place,
                        size_t index)
{
    const random_source *source = user;
    random_state r = {source->seed + 977 * index};
    kind how = source->all == KINDS ? (kind)random_below(&r, KINDS) : (kind)source->all;
    int used = 1;
    (void)place;
    for (int i = 0; i < coder->scan->count; i++) {
        values[i] = random_value(&r, how, i);
        used = values[i] ? i + 1 : used;
    }
    return used;
}

/* An array whose terms are what was encoded; fails the test if not. */
static cvol_array *decode(cvol_context *context, const cvol_array *shape, const cvol_groups *groups)
{
    cvol_array *array;
    cvol_span *spans = malloc(groups->count * sizeof *spans);
    assert_non_null(spans);
    for (size_t g = 0; g < groups->count; g++)
        spans[g] = (cvol_span){groups->bytes[g].data, groups->bytes[g].size};
    assert_int_equal(cvol_array_create(context, &array, &shape->grid, shape->block), CVOL_OK);
    int code = cvol_array_decode(context, array, spans, NULL, "test");
    if (code)
        print_message("%s\n", cvol_context_message(context));
    assert_int_equal(code, CVOL_OK);
    free(spans);
    return array;
}

static void check_block(const cvol_array *array, size_t index, const int32_t *values,
                        const cvol_scan *scan)
{
    const cvol_block *block = &array->block_table[index];
    const uint32_t *words = block->terms, *end = words + block->words;
    uint32_t place, before = 0;
    size_t terms = 0, expected = 0;
    while (words < end) {
        int32_t value = cvol_term_unpack(&words, &place, cvol_place_bits(array->block_log2));
        assert_true(terms == 0 || place > before);
        assert_int_equal(value, values[scan->index_of_place[place]]);
        before = place;
        terms++;
    }
    for (int i = 0; i < scan->count; i++)
        expected += values[i] != 0;
    assert_int_equal(terms, expected);
}

static void round_trip_groups(int side, const cvol_grid *grid, int all, uint64_t seed)
{
    cvol_context *context = cvol_context_create();
    cvol_array *shape, *array;
    cvol_groups groups = {0}, again = {0};
    random_source random = {seed, all};
    cvol_block_source source = {fetch_random, &random};
    cvol_block_coder *coder = cvol_allocate_zero(1, sizeof *coder);
    int32_t *values = cvol_allocate(CVOL_BLOCK_SAMPLES_MAX, sizeof *values);
    assert_true(context && coder && values);
    assert_int_equal(cvol_array_create(context, &shape, grid, side), CVOL_OK);
    assert_int_equal(cvol_groups_encode(context, &groups, shape, &source, 0, 1, 0), CVOL_OK);
    array = decode(context, shape, &groups);
    coder->scan = cvol_scan_of(side);
    for (size_t b = 0; b < array->block_count; b++) {
        int used = fetch_random(&random, values, coder, 0, b);
        memset(values + used, 0, sizeof *values * (size_t)(coder->scan->count - used));
        check_block(array, b, values, coder->scan);
    }
    /* The terms give the same bytes again. */
    assert_int_equal(cvol_array_encode(context, &again, array), CVOL_OK);
    assert_int_equal(again.count, groups.count);
    for (size_t g = 0; g < groups.count; g++) {
        assert_int_equal(again.bytes[g].size, groups.bytes[g].size);
        assert_memory_equal(again.bytes[g].data, groups.bytes[g].data, groups.bytes[g].size);
    }
    cvol_groups_free(&groups);
    cvol_groups_free(&again);
    cvol_array_free(array);
    cvol_array_free(shape);
    cvol_context_destroy(context);
    free(coder);
    free(values);
}

static void groups_round_trip(void **state)
{
    (void)state;
    for (int s = 0; s < 3; s++)
        for (int all = 0; all <= KINDS; all++) {
            uint64_t seed = 100 * (uint64_t)s + (uint64_t)all;
            cvol_grid grid = cvol_grid_make(150, 70, 33, CVOL_UINT8);
            print_message("side %d, kind %d, seed %d\n", sides[s], all, (int)seed);
            round_trip_groups(sides[s], &grid, all, seed);
        }
}

static void scans_are_permutations(void **state)
{
    (void)state;
    for (int s = 0; s < 3; s++) {
        const cvol_scan *scan = cvol_scan_of(sides[s]);
        assert_int_equal(scan->count, sides[s] * sides[s] * sides[s]);
        assert_int_equal(scan->entries[0].place, 0);
        for (int i = 0; i < scan->count; i++)
            assert_int_equal(scan->index_of_place[scan->entries[i].place], i);
    }
}

/* ---- garbage ---------------------------------------------------------------------------- */

/* Decodes bytes as a volume of a few blocks: anything may come out, but within bounds. */
static void decode_garbage(cvol_context *context, int side, const uint8_t *data, size_t size)
{
    cvol_grid grid = cvol_grid_make(40, 35, 33, CVOL_UINT8);
    cvol_array *array;
    uint8_t *exact = malloc(size ? size : 1);
    assert_non_null(exact);
    memcpy(exact, data, size);
    cvol_span span = {exact, size};
    assert_int_equal(cvol_array_create(context, &array, &grid, side), CVOL_OK);
    int code = cvol_array_decode(context, array, &span, NULL, "garbage");
    assert_true(code == CVOL_OK || code == CVOL_ERROR_CORRUPT);
    for (size_t b = 0; b < array->block_count && !code; b++) {
        const cvol_block *block = &array->block_table[b];
        const uint32_t *words = block->terms, *end = words + block->words;
        while (words < end) {
            uint32_t place;
            int32_t value = cvol_term_unpack(&words, &place, cvol_place_bits(array->block_log2));
            assert_true(place < (uint32_t)(side * side * side));
            assert_true(value != 0 && value >= -CVOL_VALUE_LIMIT && value <= CVOL_VALUE_LIMIT);
        }
        assert_ptr_equal(words, end);
    }
    cvol_array_free(array);
    free(exact);
}

static void garbage_decodes_within_bounds(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_context_set_threads(context, 1);
    random_state r = {42};
    uint8_t data[3000];
    for (int trial = 0; trial < 1000; trial++) {
        size_t size = random_below(&r, sizeof data);
        for (size_t i = 0; i < size; i++)
            data[i] = (uint8_t)(trial % 3 == 0 ? random_u64(&r)
                                : trial % 3 == 1
                                    ? random_u64(&r) & random_u64(&r) & random_u64(&r)
                                    : random_u64(&r) | random_u64(&r) | random_u64(&r));
        decode_garbage(context, sides[trial % 3], data, size);
    }
    cvol_context_destroy(context);
}

static void flipped_groups_decode_within_bounds(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_context_set_threads(context, 1);
    cvol_grid grid = cvol_grid_make(40, 35, 33, CVOL_UINT8);
    random_state r = {43};
    for (int s = 0; s < 3; s++) {
        cvol_array *shape;
        cvol_groups groups = {0};
        random_source random = {7, SPARSE};
        cvol_block_source source = {fetch_random, &random};
        assert_int_equal(cvol_array_create(context, &shape, &grid, sides[s]), CVOL_OK);
        assert_int_equal(cvol_groups_encode(context, &groups, shape, &source, 0, 1, 0), CVOL_OK);
        cvol_bytes *bytes = &groups.bytes[0];
        for (int trial = 0; trial < 400; trial++) {
            size_t at = random_below(&r, (uint32_t)bytes->size);
            uint8_t flip = (uint8_t)(1u << random_below(&r, 8));
            bytes->data[at] ^= flip;
            decode_garbage(context, sides[s], bytes->data, bytes->size);
            decode_garbage(context, sides[s], bytes->data, at);
            bytes->data[at] ^= flip;
        }
        cvol_groups_free(&groups);
        cvol_array_free(shape);
    }
    cvol_context_destroy(context);
}

/* ---- quantisers and search -------------------------------------------------------------- */

static void quantiser_rounds_to_nearest(void **state)
{
    (void)state;
    float c[512] = {10.0f, 0.49f, -0.51f, 1.49f, -1.51f};
    int32_t values[512];
    c[300] = 0.51f;
    assert_int_equal(cvol_quantise(values, c, 512, 1.0), 301);
    assert_int_equal(values[0], 10);
    assert_int_equal(values[1], 0);
    assert_int_equal(values[2], -1);
    assert_int_equal(values[3], 1);
    assert_int_equal(values[4], -2);
    assert_int_equal(values[300], 1);
    assert_int_equal(cvol_quantise(values, c, 512, 100.0), 1);
    assert_int_equal(cvol_quantise(values, c, 512, 1e-9), 0);
    c[0] = (float)INFINITY;
    assert_int_equal(cvol_quantise(values, c, 512, 1.0), 0);
}

static void optimal_quantiser_stays_near(void **state)
{
    (void)state;
    cvol_block_coder *coder = cvol_allocate_zero(1, sizeof *coder);
    float c[4096];
    int32_t values[4096];
    random_state r = {5};
    const size_t one[3] = {1, 1, 1};
    assert_non_null(coder);
    cvol_block_coder_start(coder, 16, one);
    for (int i = 0; i < 4096; i++)
        c[i] = (float)(random_signed(&r) * 300 / (1 + 0.1 * i));
    int used = cvol_quantise_optimally(values, c, coder, 0, 1.0);
    assert_in_range(used, 100, 4096);
    for (int i = 0; i < used; i++)
        assert_true(fabs((double)c[i] - values[i]) <= 1.0 || values[i] == 0);
    for (int i = 0; i < CVOL_SCATTER_MAX; i++)
        assert_int_equal(coder->scatter[i], 0);
    free(coder);
}

static void search_finds_a_step(void **state)
{
    (void)state;
    for (double wanted = 1e-3; wanted < 1e4; wanted *= 7) {
        cvol_search search = cvol_search_make(1e-6, 1e6, 1);
        double step = 1;
        int trials = 0;
        for (; trials < 40; trials++) {
            double miss = log(step) - log(wanted) + 0.3 * sin(log(step) - log(wanted));
            if (fabs(miss) < 1e-3)
                break;
            cvol_search_tell(&search, step, miss);
            step = cvol_search_next(&search);
        }
        assert_true(trials < 20);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(range_coder_round_trip),
        cmocka_unit_test(range_decoder_notes_the_end),
        cmocka_unit_test(scans_are_permutations),
        cmocka_unit_test(groups_round_trip),
        cmocka_unit_test(garbage_decodes_within_bounds),
        cmocka_unit_test(flipped_groups_decode_within_bounds),
        cmocka_unit_test(quantiser_rounds_to_nearest),
        cmocka_unit_test(optimal_quantiser_stays_near),
        cmocka_unit_test(search_finds_a_step),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
