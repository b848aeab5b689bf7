/* Trellis quantization: its states; paths against all possible ones; files with it: changed, read
 * in part, or invalid. */
#include "test.h"

#include "array/core/array.h"
#include "base/bytes.h"
#include "base/cpu.h"
#include "codec/container/array_file.h"
#include "codec/quantize/coding.h"
#include "codec/quantize/quantize.h"
#include "codec/quantize/trellis.h"
#include "codec/quantize/trellis_kernel.h"
#include "codec/quantize/trellis_states.h"
#include "codec/section/section.h"
#include "cvol/algebra.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_container.h"
#include "support_terms.h"

CVOL_SIMD_DECLARE(void, cvol_trellis_walk,
                  (cvol_trellis *, const float *, int, const cvol_scan *, const cvol_token_costs *,
                   uint16_t *));

/* ---- states ------------------------------------------------------------------------------ */

static void states_can_be_reversed(void **state)
{
    (void)state;
    for (int parity = 0; parity < 2; parity++)
        for (int s = 0; s < CVOL_STATES; s++) {
            const int next = cvol_state_after[s][parity];
            assert_int_equal(cvol_state_before[parity][next], s);
            assert_int_equal(cvol_state_is_odd(s), next >= 4);
        }
}

static void indices_match_their_magnitudes(void **state)
{
    (void)state;
    for (int s = 0; s < CVOL_STATES; s++) {
        uint32_t before = 0;
        for (uint32_t k = 0; k < 1000; k++) {
            const uint32_t m = cvol_trellis_magnitude(s, k);
            assert_true(k < 2 ? m >= before : m == before + 2);
            assert_int_equal(cvol_trellis_index(s, m), k);
            if (m)
                assert_int_equal(cvol_trellis_index(s, m + 1), -1);
            before = m;
        }
        const uint32_t most = UINT32_C(1) << 29;
        assert_int_equal(cvol_trellis_index(s, cvol_trellis_magnitude(s, most)), most);
    }
}

/* ---- paths ------------------------------------------------------------------------------- */

/* Costs that do not depend on the context, but on whether a state is odd: then the best path is
 * exact. Small values cost less than large ones. */
static void make_costs(cvol_token_costs *costs, random_state *r)
{
    float rows[2][CVOL_TOKENS], lengths[CVOL_TOKENS];
    for (int t = 0; t < CVOL_TOKENS; t++) {
        for (int odd = 0; odd < 2; odd++)
            rows[odd][t] = 0.2f + (float)t + (float)random_below(r, 1000) / 1000;
        lengths[t] = (float)random_below(r, 4000) / 1000;
    }
    for (int row = 0; row < CVOL_ROWS; row++) {
        const int last = row >= CVOL_ROW_LAST_INDEX && row < CVOL_ROW_INDEX_ESCAPE;
        const int at = last ? row - CVOL_ROW_LAST_INDEX : row - CVOL_ROW_INDEX;
        const int half = CVOL_INDEX_SIZES * CVOL_FINE_LEVELS * (last ? 1 : CVOL_BANDS);
        const float *from = row < CVOL_ROW_INDEX ? lengths : rows[at / half & 1];
        memcpy(costs->of[row], from, sizeof costs->of[row]);
    }
}

typedef struct search {
    const float *scaled;
    const cvol_token_costs *costs;
    const float *length_row;
    int count, size_class;
    double best;
} search;

static float cost_of(const search *s, int i, int state, uint32_t k, int last)
{
    const int odd = cvol_state_is_odd(state);
    const float error = fabsf(s->scaled[i]) - 0.5f * (float)cvol_trellis_magnitude(state, k);
    const cvol_place_code code = last ? cvol_last_code(s->size_class, 0, 1, odd)
                                      : cvol_value_code(s->size_class, 0, 0, 1, odd);
    const float bits = last ? cvol_bits_of_last_value(s->costs, code, k)
                       : k  ? cvol_bits_of_value(s->costs, code, k)
                            : cvol_bits_of_zero(s->costs, code);
    return error * error + CVOL_LAMBDA_TRELLIS * bits;
}

/* All transitions from a state, with 0 and values up to twice a step away; no coefficient ends a
 * sub-block that every rounding makes 0. */
static void search_from(search *s, int i, int state, double cost)
{
    if (i == s->count)
        return;
    const uint32_t most = (uint32_t)fabsf(s->scaled[i]) + 2;
    double tail = 0;
    for (int j = i + 1; j < s->count; j++)
        tail += (double)s->scaled[j] * (double)s->scaled[j];
    for (uint32_t k = 0; k <= most; k++) {
        const float size = fabsf(s->scaled[i]);
        if (k && fabsf(size - 0.5f * (float)cvol_trellis_magnitude(state, k)) > 1)
            continue;
        if (k && size > 0.45f) {
            const float bits = s->length_row[cvol_bit_length((uint32_t)i)] +
                               cvol_bits_of_last(s->costs, s->size_class, (uint32_t)i);
            s->best = fmin(s->best, cost + tail + (double)cost_of(s, i, state, k, 1) +
                                        (double)(CVOL_LAMBDA_TRELLIS * bits));
        }
        search_from(s, i + 1, cvol_state_after[state][k & 1],
                    cost + (double)cost_of(s, i, state, k, 0));
    }
}

/* The cost of a choice, by the same sums; its error without that of the DC. */
static double cost_of_choice(const search *s, const int32_t *indices, int used, double *error)
{
    double cost = 0;
    int state = 0;
    *error = 0;
    for (int i = 1; i < s->count; i++) {
        const uint32_t k = i < used ? cvol_magnitude(indices[i]) : 0;
        const double off = (double)fabsf(s->scaled[i]) - 0.5 * cvol_trellis_magnitude(state, k);
        *error += off * off;
        cost += i < used ? (double)cost_of(s, i, state, k, i == used - 1) : off * off;
        if (k)
            assert_int_equal(indices[i] < 0, s->scaled[i] < 0);
        state = cvol_state_after[state][k & 1];
    }
    if (used == 1)
        return cost + (double)(CVOL_LAMBDA_TRELLIS * s->length_row[0]);
    const float bits = s->length_row[cvol_bit_length((uint32_t)used - 1)] +
                       cvol_bits_of_last(s->costs, s->size_class, (uint32_t)used - 1);
    return cost + (double)(CVOL_LAMBDA_TRELLIS * bits);
}

static void paths_have_the_least_cost(void **state)
{
    (void)state;
    static uint16_t scatter[CVOL_SCATTER_MAX];
    cvol_token_costs *costs = malloc(sizeof *costs);
    cvol_trellis *trellis = cvol_trellis_create();
    int ended_early = 0, all_zero = 0;
    assert_true(costs && trellis);
    for (uint64_t seed = 1; seed <= 300; seed++) {
        random_state r = {seed};
        float scaled[512] = {0};
        int32_t indices[512];
        const int size_class = (int)random_below(&r, 2), count = 2 + (int)random_below(&r, 6);
        make_costs(costs, &r);
        scaled[0] = 5 * (float)random_signed(&r);
        for (int i = 1; i < count; i++)
            scaled[i] = (random_below(&r, 3) ? 1.2f : 3.5f) * (float)random_signed(&r);
        const cvol_sub_block_context place = {(int64_t)lrintf(scaled[0]), CVOL_ROW_DC, 0};
        const cvol_sub_block_choice choice = cvol_trellis_choose(
            trellis, indices, scaled, cvol_sub_block_scan_of(size_class), costs, &place, scatter);
        const int64_t difference = indices[0] - place.prediction;
        search s = {scaled,
                    costs,
                    costs->of[cvol_length_row(&place, size_class, (uint64_t)llabs(difference))],
                    count,
                    size_class,
                    0};
        double error, squares = 0;
        for (int i = 1; i < count; i++)
            squares += (double)scaled[i] * (double)scaled[i];
        s.best = squares + (double)(CVOL_LAMBDA_TRELLIS * s.length_row[0]);
        search_from(&s, 1, 0, 0);
        assert_true(choice.used >= 1 && choice.used <= count);
        assert_true(choice.used == 1 || indices[choice.used - 1]);
        const double cost = cost_of_choice(&s, indices, choice.used, &error);
        if (fabs(cost - s.best) > 1e-4)
            fail_msg("seed %llu: cost %g, the best %g", (unsigned long long)seed, cost, s.best);
        const double dc = (double)scaled[0] - indices[0];
        assert_true(fabs(error + dc * dc - (double)choice.error) < 1e-4 * (1 + error));
        ended_early += choice.used < count;
        all_zero += choice.used == 1;
        for (int i = 0; i < CVOL_SCATTER_MAX; i++)
            assert_int_equal(scatter[i], 0);
    }
    assert_true(ended_early > 25 && all_zero > 2);
    cvol_trellis_free(trellis);
    free(costs);
}

/* Large coefficients, with escapes and raw bits, keep their sizes. */
static void large_values_have_small_error(void **state)
{
    (void)state;
    static uint16_t scatter[CVOL_SCATTER_MAX];
    static float scaled[4096];
    static int32_t indices[4096];
    cvol_token_costs *costs = malloc(sizeof *costs);
    cvol_token_tables *tables = cvol_token_tables_create();
    cvol_trellis *trellis = cvol_trellis_create();
    assert_true(costs && tables && trellis);
    cvol_token_costs_set(costs, tables);
    for (uint64_t seed = 1; seed <= 40; seed++) {
        random_state r = {seed};
        const int size_class = (int)random_below(&r, 3), count = 64 << 3 * size_class;
        const double largest = exp2(3 + random_below(&r, 25));
        for (int i = 0; i < count; i++)
            scaled[i] = (float)(largest * random_signed(&r));
        const cvol_sub_block_context place = {0, CVOL_ROW_DC, 0};
        const cvol_sub_block_choice choice = cvol_trellis_choose(
            trellis, indices, scaled, cvol_sub_block_scan_of(size_class), costs, &place, scatter);
        for (int i = 1, s = 0; i < choice.used; i++) {
            const uint32_t k = cvol_magnitude(indices[i]);
            const double off = fabs((double)scaled[i]) - 0.5 * cvol_trellis_magnitude(s, k);
            if (fabs(off) > 3.2 && fabs(off) > 1e-6 * largest)
                fail_msg("seed %llu: coefficient %d is off by %g", (unsigned long long)seed, i,
                         off);
            s = cvol_state_after[s][k & 1];
        }
    }
    scaled[1] = 0x1p30f; /* its index is too large */
    const cvol_sub_block_context place = {0, CVOL_ROW_DC, 0};
    assert_int_equal(cvol_trellis_choose(trellis, indices, scaled, cvol_sub_block_scan_of(0), costs,
                                         &place, scatter)
                         .used,
                     0);
    cvol_trellis_free(trellis);
    free(tables);
    free(costs);
}

/* The bits do not depend on the instruction set. */
static void kernels_agree(void **state)
{
    (void)state;
    static uint16_t scatter[2][CVOL_SCATTER_MAX];
    static float scaled[4096];
    cvol_token_costs *costs = malloc(sizeof *costs);
    cvol_token_tables *tables = cvol_token_tables_create();
    cvol_trellis *t[2] = {cvol_trellis_create(), cvol_trellis_create()};
    assert_true(costs && tables && t[0] && t[1]);
    cvol_token_costs_set(costs, tables);
    for (uint64_t seed = 1; seed <= 60; seed++) {
        random_state r = {seed};
        const cvol_scan *scan = cvol_sub_block_scan_of((int)random_below(&r, 3));
        const int extent = 2 + (int)random_below(&r, (uint32_t)scan->count - 1);
        const double scale = exp2(random_signed(&r) * 5);
        for (int i = 0; i < extent; i++)
            scaled[i] = (float)(scale * random_signed(&r) * random_signed(&r));
        memset(scatter, 0, sizeof scatter);
        cvol_trellis_walk_base(t[0], scaled, extent, scan, costs, scatter[0]);
        CVOL_SIMD_CHOOSE(cvol_trellis_walk)(t[1], scaled, extent, scan, costs, scatter[1]);
        assert_memory_equal(scatter[0], scatter[1], sizeof scatter[0]);
        for (int i = 1; i < extent; i++)
            if (t[0]->odd[i] != t[1]->odd[i] || t[0]->near[i] != t[1]->near[i] ||
                memcmp(t[0]->sums[i], t[1]->sums[i], sizeof t[0]->sums[i]) ||
                memcmp(t[0]->index[i], t[1]->index[i], sizeof t[0]->index[i]))
                fail_msg("seed %llu: other ways to %d", (unsigned long long)seed, i);
    }
    for (int i = 0; i < 2; i++)
        cvol_trellis_free(t[i]);
    free(tables);
    free(costs);
}

/* ---- files ------------------------------------------------------------------------------- */

static const cvol_grid *small_grid(void)
{
    static cvol_grid grid;
    grid = cvol_grid_make(90, 70, 67, CVOL_INT16);
    return &grid;
}

/* Smooth, with an edge and noise. */
static int16_t *make_samples(void)
{
    const cvol_grid *grid = small_grid();
    random_state r = {7};
    int16_t *samples = malloc(cvol_grid_bytes(grid));
    assert_non_null(samples);
    for (size_t i = 0; i < cvol_grid_samples(grid); i++) {
        const double x = (double)(i % 90), y = (double)(i / 90 % 70), z = (double)(i / 6300);
        const double v = 900 * sin(x / 9) * cos(y / 14 + z / 11) + (x + y > z + 60 ? 1200 : 0);
        samples[i] = (int16_t)(v + 40 * random_signed(&r));
    }
    return samples;
}

static cvol_array *compress(const int16_t *samples, double psnr, int fast, int threads)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array;
    options.target = CVOL_TARGET_PSNR;
    options.target_value = psnr;
    options.effort = fast ? CVOL_EFFORT_FAST : CVOL_EFFORT_DEFAULT;
    cvol_context_set_threads(context, threads);
    check_ok(cvol_compress(context, &array, NULL, samples, small_grid(), &options));
    cvol_context_set_threads(context, 2);
    return array;
}

static cvol_array *read_back(void)
{
    cvol_array *array;
    char *path = support_path(folder, "a.cvol");
    check_ok(cvol_array_read(context, &array, path, NULL));
    free(path);
    return array;
}

static void bytes_are_the_same_for_any_threads(void **state)
{
    (void)state;
    int16_t *samples = make_samples();
    size_t size, other_size;
    cvol_array *array = compress(samples, 45, 0, 1), *other = compress(samples, 45, 0, 5);
    uint8_t *data = container_verified(array, &size),
            *again = container_verified(other, &other_size);
    assert_int_equal(cvol_coding_of(array)->trellis, 1);
    assert_int_equal(size, other_size);
    assert_memory_equal(data, again, size);
    free(again);
    cvol_array_free(other);
    other = read_back();
    assert_int_equal(cvol_coding_of(other)->trellis, 1);
    support_terms_expect_same(array, other);
    again = container_verified(other, &other_size); /* coded again */
    assert_true(other_size <= size + size / 50);
    cvol_array_free(other);
    other = read_back();
    assert_int_equal(cvol_coding_of(other)->trellis, 1);
    support_terms_expect_same(array, other);
    free(again);
    free(data);
    free(samples);
    cvol_array_free(array);
    cvol_array_free(other);
}

static void effort_fast_and_bounds_use_no_trellis(void **state)
{
    (void)state;
    int16_t *samples = make_samples();
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array = compress(samples, 45, 1, 2), *back;
    size_t size;
    free(container_verified(array, &size));
    back = read_back();
    assert_int_equal(cvol_coding_of(back)->trellis, 0);
    support_terms_expect_same(array, back);
    cvol_array_free(array);
    cvol_array_free(back);
    options.target = CVOL_TARGET_MAX_ERROR;
    options.target_value = 30;
    check_ok(cvol_compress(context, &array, NULL, samples, small_grid(), &options));
    assert_int_equal(cvol_coding_of(array)->trellis, 0);
    free(container_verified(array, &size));
    cvol_array_free(array);
    free(samples);
}

/* Terms without a path are coded without trellis; changes of signs or of the step alone keep it. */
static void changed_terms_are_coded_without_trellis(void **state)
{
    (void)state;
    int16_t *samples = make_samples();
    cvol_array *array = compress(samples, 45, 0, 2), *changed, *back;
    const double step = array->step;
    size_t size, own;
    free(container_verified(array, &own));
    check_ok(cvol_array_scale(context, &changed, -2, array, 5));
    assert_int_equal(cvol_coding_of(changed)->trellis, 1);
    free(container_verified(changed, &size));
    assert_true(size <= own + own / 50);
    back = read_back();
    assert_int_equal(cvol_coding_of(back)->trellis, 1);
    support_terms_expect_same(changed, back);
    cvol_array_free(back);
    cvol_array_free(changed);
    const cvol_keep keep = cvol_keep_threshold(3.5 * step);
    check_ok(cvol_array_truncate(context, &changed, array, &keep));
    assert_true(changed->coefficients < array->coefficients);
    free(container_verified(changed, &size));
    back = read_back();
    assert_int_equal(cvol_coding_of(back)->trellis, 0);
    support_terms_expect_same(changed, back);
    cvol_array_free(back);
    /* The writer checks a false claim. */
    assert_int_equal(cvol_coding_need(context, changed), CVOL_OK);
    cvol_coding_own(changed)->trellis = 1;
    free(container_verified(changed, &size));
    back = read_back();
    assert_int_equal(cvol_coding_of(back)->trellis, 0);
    support_terms_expect_same(changed, back);
    cvol_array_free(back);
    /* Both claims, of which neither, or one, is true. */
    for (int bits = 1; bits < 3; bits++) {
        cvol_coding_own(changed)->trellis = 1;
        cvol_coding_own(changed)->true_length = bits;
        free(container_verified(changed, &size));
        back = read_back();
        assert_int_equal(cvol_coding_of(back)->trellis, 0);
        support_terms_expect_same(changed, back);
        cvol_array_free(back);
    }
    cvol_array_free(changed);
    free(samples);
    cvol_array_free(array);
}

/* Boxes are read from a few bricks, levels from a few subbands. */
static void partial_files_are_read(void **state)
{
    (void)state;
    static const size_t begin[3] = {60, 3, 61}, end[3] = {90, 66, 67};
    static int16_t whole[30 * 63 * 6], part[30 * 63 * 6];
    int16_t *samples = make_samples();
    cvol_array *array = compress(samples, 40, 0, 2), *box;
    char *path = support_path(folder, "a.cvol");
    size_t size;
    free(container_verified(array, &size));
    check_ok(cvol_array_read_box(context, &box, path, begin, end, NULL));
    check_ok(cvol_array_evaluate_box(context, whole, array, begin, end));
    check_ok(cvol_array_evaluate_box(context, part, box, begin, end));
    assert_memory_equal(whole, part, sizeof whole);
    cvol_array_free(box);
    for (int level = 1; level < 4; level++) {
        const cvol_file_part some = {.size = sizeof(cvol_file_part), .level = level};
        cvol_file_report report;
        check_ok(cvol_array_read_part(context, &box, &report, path, &some));
        assert_true(box->coefficients > 0 && box->coefficients < array->coefficients);
        cvol_array_free(box);
    }
    free(path);
    free(samples);
    cvol_array_free(array);
}

/* HEAD names another quantization than the one used. */
static void invalid_values_do_not_crash(void **state)
{
    (void)state;
    enum { HEAD_AT = 12, TRELLIS_AT = HEAD_AT + 24 + 44 };
    int16_t *samples = make_samples();
    for (int fast = 0; fast < 2; fast++) {
        cvol_array *array = compress(samples, 40, fast, 2);
        for (uint32_t overwrite = 0; overwrite < 4; overwrite++) {
            cvol_array *back;
            char *path = support_path(folder, "a.cvol");
            size_t size;
            uint8_t *data = support_unpack(container_verified(array, &size), &size);
            assert_int_equal(data[TRELLIS_AT], !fast);
            data[TRELLIS_AT] = (uint8_t)overwrite;
            for (int i = 0; i < 2; i++) { /* of the content, then of the header that has it */
                const uint32_t sum = i ? cvol_crc32c(data + HEAD_AT, 20)
                                       : cvol_crc32c(data + HEAD_AT + 24, 88);
                for (int b = 0; b < 4; b++)
                    data[HEAD_AT + 16 + 4 * i + b] = (uint8_t)(sum >> 8 * b);
            }
            support_write(path, data, size);
            const int code = cvol_array_read(context, &back, path, NULL);
            if (overwrite == (uint32_t)!fast)
                assert_int_equal(code, CVOL_OK);
            else
                assert_int_equal(code, CVOL_ERROR_CORRUPT);
            if (overwrite > 1)
                assert_non_null(strstr(cvol_context_message(context), "HEAD: dependent is"));
            cvol_array_free(back);
            free(data);
            free(path);
        }
        cvol_array_free(array);
    }
    free(samples);
}

/* Samples near the largest float have infinite terms or NaN. */
static void nan_is_refused(void **state)
{
    (void)state;
    float terms[40] = {0};
    for (int i = 0; i < 40; i++) {
        assert_true(cvol_quantise_fits(terms, 40, 0.5));
        terms[i] = NAN;
        assert_false(cvol_quantise_fits(terms, 40, 0.5));
        terms[i] = -INFINITY;
        assert_false(cvol_quantise_fits(terms, 40, 0.5));
        terms[i] = i % 2 ? 0x1p28f : -3;
    }
    terms[7] = 0x1p29f;
    assert_false(cvol_quantise_fits(terms, 40, 0.5));
    assert_true(cvol_quantise_fits(terms, 40, 1));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(states_can_be_reversed),
        cmocka_unit_test(indices_match_their_magnitudes),
        cmocka_unit_test(paths_have_the_least_cost),
        cmocka_unit_test(large_values_have_small_error),
        cmocka_unit_test(kernels_agree),
        cmocka_unit_test(bytes_are_the_same_for_any_threads),
        cmocka_unit_test(effort_fast_and_bounds_use_no_trellis),
        cmocka_unit_test(changed_terms_are_coded_without_trellis),
        cmocka_unit_test(partial_files_are_read),
        cmocka_unit_test(invalid_values_do_not_crash),
        cmocka_unit_test(nan_is_refused),
    };
    return cmocka_run_group_tests(tests, files_setup, files_teardown);
}
