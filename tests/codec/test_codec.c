/* The coder: quantizer, range coder, blocks and groups, round trips, and garbage. */
#include "test.h"

#include "base/context.h"
#include "base/memory.h"
#include "codec/entropy/range_coder.h"
#include "codec/quantize/rd_choice.h"
#include "codec/quantize/split_choice.h"
#include "codec/rate/search.h"
#include "random.h"

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
        /* In memory of exactly its size: the sanitizer detects a read beyond it. */
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

static void range_decoder_detects_the_end(void **state)
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

/* ---- choice and search -------------------------------------------------------------- */

/* A sub-block's choice stays within a step of the coefficients, or drops them. */
static void optimal_choice_has_small_error(void **state)
{
    (void)state;
    cvol_token_tables *tables = cvol_token_tables_create();
    cvol_token_costs *costs = malloc(sizeof *costs);
    uint16_t *scatter = cvol_allocate_zero(CVOL_SCATTER_MAX, sizeof *scatter);
    static float c[4096];
    static int32_t values[4096];
    random_state r = {5};
    assert_true(tables && costs && scatter);
    cvol_token_costs_set(costs, tables);
    for (int i = 0; i < 4096; i++)
        c[i] = (float)(random_signed(&r) * 300 / (1 + 0.1 * i));
    for (int plain = 0; plain < 2; plain++) {
        const cvol_sub_block_context context = {0, CVOL_ROW_DC + 2 * CVOL_SPREADS, 0};
        const cvol_sub_block_choice choice = cvol_sub_block_choose(
            values, c, cvol_sub_block_scan_of(2), costs, &context, plain, scatter);
        double error = 0;
        assert_in_range(choice.used, 100, 4096);
        assert_true(values[choice.used - 1] != 0);
        for (int i = 0; i < 4096; i++) {
            const double value = i < choice.used ? values[i] : 0;
            assert_true(fabs((double)c[i] - value) <= 1.0 || value == 0);
            assert_true(!plain || fabs((double)c[i] - value) <= 0.501);
            error += ((double)c[i] - value) * ((double)c[i] - value);
        }
        assert_true(fabs(error - (double)choice.error) < 1e-3 * error);
        for (int i = 0; i < CVOL_SCATTER_MAX; i++)
            assert_int_equal(scatter[i], 0);
    }
    c[9] = 2e9f; /* beyond the coded bits */
    const cvol_sub_block_context context = {0, CVOL_ROW_DC + 2 * CVOL_SPREADS, 0};
    assert_int_equal(
        cvol_sub_block_choose(values, c, cvol_sub_block_scan_of(2), costs, &context, 0, scatter)
            .used,
        0);
    free(tables);
    free(costs);
    free(scatter);
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
            cvol_search_report(&search, step, miss);
            step = cvol_search_next(&search);
        }
        assert_true(trials < 20);
    }
}

/* No value of so fine a step reaches these samples: every sub-block reports it for any split, and
 * no unwritten value is read. */
static void oversized_values_are_reported(void **state)
{
    (void)state;
    static const cvol_split_choice splits[] = {CVOL_SPLIT_BEST, CVOL_SPLIT_NEVER,
                                               CVOL_SPLIT_OCTANTS, CVOL_SPLIT_FOURS};
    static const int inside[3] = {16, 16, 16};
    static const size_t place[3] = {0};
    cvol_token_tables *tables = cvol_token_tables_create();
    cvol_token_costs *costs = malloc(sizeof *costs);
    cvol_cell_chooser *chooser = cvol_cell_chooser_create();
    cvol_brick_context *brick = calloc(1, sizeof *brick);
    float *samples = aligned_alloc(64, 4096 * sizeof *samples);
    assert_true(tables && costs && chooser && brick && samples);
    cvol_token_costs_set(costs, tables);
    random_state r = (random_state){11};
    for (int i = 0; i < 4096; i++)
        samples[i] = (float)((double)random_below(&r, 1 << 30) * 4);
    for (size_t k = 0; k < 8; k++) {
        const cvol_chooser_options options = {
            .step = 1e-3, .split = splits[k % 4], .trellis = k >= 4};
        cvol_cell_choice choice;
        cvol_cell_choose(chooser, &choice, samples, inside, brick, place, costs, &options);
        assert_true(choice.parts > 0);
        for (int p = 0; p < choice.parts; p++)
            assert_int_equal(choice.used[p], 0);
    }
    free(samples);
    free(brick);
    cvol_cell_chooser_free(chooser);
    free(costs);
    free(tables);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(range_coder_round_trip),
        cmocka_unit_test(range_decoder_detects_the_end),
        cmocka_unit_test(optimal_choice_has_small_error),
        cmocka_unit_test(search_finds_a_step),
        cmocka_unit_test(oversized_values_are_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
