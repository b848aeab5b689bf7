/* The split choice of effort fast: its kernels equal reference loops to the bit, on every
 * instruction set; its values, sub-blocks and error are consistent; and files of effort fast meet
 * their tolerance. */
#include "test.h"

#include "array/block/cell_weight.h"
#include "array/core/array.h"
#include "base/cpu.h"
#include "base/memory.h"
#include "codec/quantize/split_fast.h"
#include "codec/quantize/split_kernels.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_kernels.h"
#include "transform/cell.h"

enum { SIDE = 16, ALL = CVOL_CELL_SAMPLES };

typedef void weights_function(float *, const float *, float);
typedef void quantise_function(cvol_cell_quantised *, const float *, const cvol_cell_rounding *);
CVOL_SIMD_DECLARE(void, cvol_cell_weights, (float *, const float *, float));
CVOL_SIMD_DECLARE(void, cvol_cell_quantise,
                  (cvol_cell_quantised *, const float *, const cvol_cell_rounding *));

static weights_function *const weigh[] = CVOL_SIMD_SETS(cvol_cell_weights);
static quantise_function *const quantise[] = CVOL_SIMD_SETS(cvol_cell_quantise);

static float coefficients[ALL] __attribute__((aligned(64)));
static float samples[ALL] __attribute__((aligned(64)));
static cvol_cell_quantised found, expected;

/* Coefficients that decrease with frequency, or a few large ones. */
static void make_coefficients(random_state *r)
{
    const double fall = random_signed(r) + 1;
    for (int i = 0; i < ALL; i++) {
        const int norm = i % 16 + i / 16 % 16 + i / 256;
        coefficients[i] = (float)(200 * random_signed(r) * exp(-fall * norm / 4));
        if (random_below(r, 500) == 0)
            coefficients[i] = (float)(1e5 * random_signed(r));
    }
}

/* ---- kernels ---------------------------------------------------------------------------- */

static float near_of(const cvol_cell_rounding *how, int u, int v, int w)
{
    const int place = u + SIDE * (v + SIDE * w), a = how->apart;
    const float x = u < a ? 1 : fabsf(coefficients[place - a] * how->inverse);
    const float y = v < a ? 1 : fabsf(coefficients[place - SIDE * a] * how->inverse);
    const float z = w < a ? 1 : fabsf(coefficients[place - SIDE * SIDE * a] * how->inverse);
    return (x + y) + z;
}

static void quantise_reference(const cvol_cell_rounding *how)
{
    memset(&expected, 0, sizeof expected);
    for (int w = 0; w < SIDE; w++) {
        float lanes[SIDE] = {0};
        double sum = 0;
        for (int v = 0; v < SIDE; v++)
            for (int u = 0; u < SIDE; u++) {
                const int place = u + SIDE * (v + SIDE * w);
                const float scaled = coefficients[place] * how->inverse, size = fabsf(scaled);
                const float least = how->low + how->alone / (1 + near_of(how, u, v, w));
                const int32_t m = size >= least ? (int32_t)(size + how->up) : 0;
                const float error = size - (float)m;
                lanes[u] += error * error;
                expected.values[place] = scaled < 0 ? -m : m;
                expected.found[place / 64] |= (uint64_t)(m != 0) << place % 64;
                expected.most = size > expected.most ? size : expected.most;
            }
        for (int u = 0; u < SIDE; u++)
            sum += (double)lanes[u];
        expected.error += sum;
    }
}

static void kernels_equal_reference_loops(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 60; seed += SUPPORT_STRIDE) {
        random_state r = {seed};
        make_coefficients(&r);
        const cvol_cell_rounding how = {(float)(1 / (0.01 + random_below(&r, 40))), 0.48f, 0.52f,
                                        0.4f, 1 << random_below(&r, 3)};
        float weights[8] = {0}, octants[8];
        for (int i = 0; i < ALL; i++)
            weights[(i & 1) | (i >> 3 & 2) | (i >> 6 & 4)] += cvol_cell_weight(coefficients[i],
                                                                               how.inverse);
        quantise_reference(&how);
        for (int set = 0; set <= (int)cvol_cpu_best(); set++) {
            float first[8];
            memset(&found, 255, sizeof found);
            quantise[set](&found, coefficients, &how);
            if (memcmp(found.values, expected.values, sizeof found.values) ||
                memcmp(found.found, expected.found, sizeof found.found) ||
                memcmp(&found.error, &expected.error, sizeof found.error) ||
                memcmp(&found.most, &expected.most, sizeof found.most))
                fail_msg("seed %d, set %d: quantised otherwise", (int)seed, set);
            weigh[0](first, coefficients, how.inverse);
            weigh[set](octants, coefficients, how.inverse);
            assert_memory_equal(first, octants, sizeof first);
            for (int i = 0; i < 8; i++)
                if (fabsf(octants[i] - weights[i]) > 1e-4f * weights[i])
                    fail_msg("seed %d, set %d: octant %d weighs %g, not %g", (int)seed, set, i,
                             (double)octants[i], (double)weights[i]);
        }
    }
}

/* ---- a cell ----------------------------------------------------------------------------- */

/* A sharp edge in a part of the cell, a smooth field, noise; or cubes: splits of all kinds. */
static void make_samples(random_state *r)
{
    const double slope = 20 * random_signed(r), noise = 5 * (1 + random_signed(r));
    const int edge = (int)random_below(r, 24), from = (int)random_below(r, 16);
    const int cubes = random_below(r, 4) == 0;
    float cube[64];
    for (int i = 0; i < 64; i++)
        cube[i] = cubes ? (float)(300 * random_signed(r)) : 0;
    for (int i = 0; i < ALL; i++) {
        const int x = i % 16, y = i / 16 % 16, z = i / 256;
        samples[i] = (float)(slope * sin(0.2 * x + 0.1 * y) + noise * random_signed(r) +
                             (x + y / 2 > edge && z > from ? 90 : 0));
        samples[i] = cubes ? cube[x / 4 + 4 * (y / 4 + 4 * (z / 4))] : samples[i];
    }
}

/* The values of all parts by place. */
static void spread(int32_t values[ALL], const cvol_cell_choice *choice)
{
    cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX];
    const int count = cvol_cell_list_sub_blocks(parts, choice->split);
    memset(values, 0, ALL * sizeof *values);
    assert_int_equal(count, choice->parts);
    for (int p = 0; p < count; p++) {
        const cvol_scan *scan = cvol_sub_block_scan_of(cvol_size_class(parts[p].side));
        const int first = parts[p].first[0] + SIDE * (parts[p].first[1] + SIDE * parts[p].first[2]);
        assert_in_range(choice->used[p], 1, scan->count);
        assert_true(choice->used[p] == 1 || choice->values[p][choice->used[p] - 1]);
        for (int i = 0; i < choice->used[p]; i++)
            values[first + scan->entries[i].in_cell] = choice->values[p][i];
    }
}

static void choices_match_their_coefficients(void **state)
{
    static const int all[3] = {SIDE, SIDE, SIDE};
    static int32_t values[ALL];
    static uint32_t words[2 * ALL];
    cvol_split_fast *quick = cvol_split_fast_create();
    int kinds = 0;
    (void)state;
    assert_non_null(quick);
    for (uint64_t seed = 1; seed <= 120; seed += SUPPORT_STRIDE) {
        random_state r = {seed};
        const int plain = (int)random_below(&r, 2);
        const double step = 0.02 + 8 * (1 + random_signed(&r));
        cvol_cell_choice choice;
        size_t terms = 0, kept = 0;
        double error = 0;
        make_samples(&r);
        cvol_split_fast_choose(quick, &choice, samples, all, step, plain);
        kinds |= choice.split == CVOL_CELL_WHOLE ? 1 : choice.split < CVOL_CELL_FOURS ? 2 : 4;
        spread(values, &choice);
        cvol_cell_forward(coefficients, samples, choice.split);
        for (int i = 0; i < ALL; i++) {
            const double off = (double)coefficients[i] / step - values[i];
            error += off * off;
            kept += values[i] != 0;
            if (plain && fabs(off) > 0.5 + 1e-5 * fabs((double)values[i]))
                fail_msg("seed %d: place %d is %g off", (int)seed, i, off);
        }
        if (fabs(error - (double)choice.error) > 1e-3 * error + 1e-6)
            fail_msg("seed %d: error %g, not %g", (int)seed, error, (double)choice.error);
        const uint32_t count = cvol_split_fast_terms(quick, words, &terms);
        const uint32_t *at = words;
        assert_int_equal(terms, kept);
        while (at < words + count) {
            uint32_t place;
            const int32_t value = cvol_term_unpack(&at, &place, cvol_place_bits(4));
            assert_int_equal(value, values[place]);
        }
        assert_true(cvol_split_fast_error(quick, samples, all, step, plain) > 0.999 * error - 1e-6);
        cvol_split_fast_choose(quick, &choice, samples, all, 1e-12, plain);
        assert_int_equal(choice.used[0], 0);
        assert_true(isinf(cvol_split_fast_error(quick, samples, all, 1e-12, plain)));
    }
    assert_int_equal(kinds, 7);
    cvol_split_fast_free(quick);
}

/* ---- volumes ---------------------------------------------------------------------------- */

static const size_t dims[3] = {150, 117, 91};

static int16_t *make_volume(void)
{
    int16_t *volume = malloc(dims[0] * dims[1] * dims[2] * sizeof *volume);
    random_state r = {5};
    assert_non_null(volume);
    for (size_t i = 0; i < dims[0] * dims[1] * dims[2]; i++) {
        const double x = (double)(i % dims[0]) - 70, y = (double)(i / dims[0] % dims[1]) - 60;
        const double z = (double)(i / dims[0] / dims[1]) - 45, d = sqrt(x * x + y * y + z * z);
        const double inside = d < 55 ? 900 + 300 * sin(d / 3) + 60 * random_signed(&r) : 0;
        volume[i] = (int16_t)(-1000 + inside);
    }
    return volume;
}

static void file_error_equals_measured_error(void **state)
{
    static const double targets[] = {30, 38, 47};
    cvol_context *context = cvol_context_create();
    int16_t *volume = make_volume();
    const cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_INT16);
    const size_t begin[3] = {0, 0, 0}, count = dims[0] * dims[1] * dims[2];
    int16_t *own = malloc(count * sizeof *own), *decoded = malloc(count * sizeof *decoded);
    char *folder = support_folder_make(), path[4096];
    (void)state;
    assert_non_null(own);
    assert_non_null(decoded);
    snprintf(path, sizeof path, "%s/quick.cvol", folder);
    for (size_t t = 0; t < 6; t++) {
        cvol_compress_options options = cvol_compress_options_defaults();
        cvol_compress_report report;
        cvol_array *array, *again;
        uint64_t bytes;
        options.effort = CVOL_EFFORT_FAST;
        if (t < 3) {
            options.target = CVOL_TARGET_PSNR;
            options.target_value = targets[t];
        } else if (t == 4) {
            options.target = CVOL_TARGET_MAX_ERROR;
            options.target_value = 25;
        } else if (t == 5) {
            options.lossless = 1;
        }
        cvol_context_set_threads(context, 1 + (int)t % 2);
        assert_int_equal(cvol_compress(context, &array, &report, volume, &grid, &options), 0);
        assert_true(report.target_met);
        assert_int_equal(cvol_array_write(context, array, path, &bytes), 0);
        assert_int_equal(bytes, report.file_bytes);
        assert_int_equal(cvol_array_read(context, &again, path, NULL), 0);
        assert_int_equal(cvol_array_evaluate_box(context, own, array, begin, dims), 0);
        assert_int_equal(cvol_array_evaluate_box(context, decoded, again, begin, dims), 0);
        assert_memory_equal(own, decoded, count * sizeof *own);
        double sum = 0, most = 0;
        for (size_t i = 0; i < count; i++) {
            const double error = fabs((double)volume[i] - decoded[i]);
            sum += error * error;
            most = error > most ? error : most;
        }
        const double span = again->error_bound.value_max - again->error_bound.value_min;
        assert_true(t != 4 || most <= 25);
        assert_true(t != 5 || most <= 0);
        const double psnr = 10 * log10(span * span * (double)count / sum);
        assert_true(psnr == report.psnr_db || fabs(psnr - report.psnr_db) < 1e-6);
        assert_true(fabs(most - report.max_error) < 1e-9);
        if (t < 3 && (psnr < targets[t] || psnr > targets[t] + 0.5))
            fail_msg("%g dB were asked for, %g it is", targets[t], psnr);
        cvol_array_free(array);
        cvol_array_free(again);
    }
    support_folder_remove(folder);
    free(own);
    free(decoded);
    free(volume);
    cvol_context_free(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kernels_equal_reference_loops),
        cmocka_unit_test(choices_match_their_coefficients),
        cmocka_unit_test(file_error_equals_measured_error),
    };
    kernels_print_sets();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
