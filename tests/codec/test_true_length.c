/* Cells that a volume ends in: DCTs of their true length and terms; files with them: changed or
 * invalid. */
#include "test.h"

#include "array/core/array.h"
#include "base/bytes.h"
#include "base/cpu.h"
#include "codec/quantize/coding.h"
#include "codec/quantize/quantize.h"
#include "codec/quantize/true_length.h"
#include "codec/quantize/true_length_kernel.h"
#include "cvol/algebra.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_files.h"
#include "support_kernels.h"
#include "support_samples.h"
#include "support_terms.h"

#define PI 3.14159265358979323846

/* ---- cells ------------------------------------------------------------------------------- */

static const int insides[][3] = {{11, 16, 16}, {16, 5, 16}, {16, 16, 1},
                                 {3, 16, 9},   {11, 13, 2}, {8, 12, 4}};
static const uint16_t splits[] = {CVOL_CELL_WHOLE, CVOL_CELL_OCTANTS, CVOL_CELL_FOURS, 0x0a5};
enum { INSIDES = sizeof insides / sizeof *insides, SPLITS = sizeof splits / sizeof *splits };

/* Coefficients that a file could have, by place; 0 elsewhere. */
static void make_coded(random_state *r, int32_t *values, const int inside[3], uint16_t split)
{
    cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX];
    const int count = cvol_cell_list_sub_blocks(parts, split);
    memset(values, 0, sizeof *values * CVOL_CELL_SAMPLES);
    for (int p = 0; p < count; p++) {
        const cvol_sub_block *part = &parts[p];
        int n[3];
        for (int a = 0; a < 3; a++) {
            const int left = inside[a] - part->begin[a];
            n[a] = left < part->side ? left : part->side;
        }
        const int apart = CVOL_CELL / part->side;
        for (int w = 0; w < n[2] && n[0] > 0 && n[1] > 0; w++)
            for (int v = 0; v < n[1]; v++)
                for (int u = 0; u < n[0]; u++)
                    if (random_below(r, 3) == 0)
                        values[part->first[0] + apart * u +
                               CVOL_CELL * (part->first[1] + apart * v +
                                            CVOL_CELL * (part->first[2] + apart * w))] =
                            (int32_t)(300 * random_signed(r));
    }
}

static double cosine(int k, int x, int n)
{
    return sqrt((k ? 2.0 : 1.0) / n) * cos(PI * k * (x + 0.5) / n);
}

/* A sample of a sub-block, by its definition. */
static double sample_of(const int32_t *values, const cvol_sub_block *part, const int inside[3],
                        const int x[3])
{
    const int apart = CVOL_CELL / part->side;
    int n[3];
    double sum = 0;
    for (int a = 0; a < 3; a++) {
        const int left = inside[a] - part->begin[a];
        n[a] = left < part->side ? left : part->side;
    }
    for (int w = 0; w < n[2]; w++)
        for (int v = 0; v < n[1]; v++)
            for (int u = 0; u < n[0]; u++)
                sum += values[part->first[0] + apart * u +
                              CVOL_CELL * (part->first[1] + apart * v +
                                           CVOL_CELL * (part->first[2] + apart * w))] *
                       cosine(u, x[0] - part->begin[0], n[0]) *
                       cosine(v, x[1] - part->begin[1], n[1]) *
                       cosine(w, x[2] - part->begin[2], n[2]);
    return sum;
}

static int has(const cvol_sub_block *part, const int x[3])
{
    for (int a = 0; a < 3; a++)
        if (x[a] < part->begin[a] || x[a] >= part->begin[a] + part->side)
            return 0;
    return 1;
}

/* Terms evaluate to the samples of the shorter DCT, within rounding. */
static void check_samples(random_state *r, const int32_t *coded, const int32_t *terms,
                          const int inside[3], uint16_t split)
{
    static const int all[3] = {CVOL_CELL, CVOL_CELL, CVOL_CELL};
    static float scaled[CVOL_CELL_SAMPLES] __attribute__((aligned(64))),
        samples[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX];
    const int count = cvol_cell_list_sub_blocks(parts, split);
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++)
        scaled[i] = (float)terms[i] / (1 << CVOL_TRUE_LENGTH_BITS);
    cvol_cell_inverse(samples, scaled, split, all);
    for (int i = 0; i < 20; i++) {
        int x[3];
        for (int a = 0; a < 3; a++)
            x[a] = (int)random_below(r, (uint32_t)inside[a]);
        for (int p = 0; p < count; p++)
            if (has(&parts[p], x)) {
                const double want = sample_of(coded, &parts[p], inside, x);
                const float got = samples[x[0] + CVOL_CELL * (x[1] + CVOL_CELL * x[2])];
                /* Rounding to whole terms has a deviation of 1 / sqrt 12 at most. The squares of a
                 * sample's weights of terms sum to 1, so this is the sample's deviation as well.
                 * None of about 500 samples deviates by six times as much. */
                assert_true(fabs((double)got - want) < 6 / sqrt(12) / (1 << CVOL_TRUE_LENGTH_BITS));
            }
    }
}

static void terms_are_shorter_cosines_and_invert(void **state)
{
    (void)state;
    static int32_t coded[CVOL_CELL_SAMPLES], terms[CVOL_CELL_SAMPLES], back[CVOL_CELL_SAMPLES];
    random_state r = {3};
    for (int i = 0; i < INSIDES; i++)
        for (int s = 0; s < SPLITS; s++) {
            uint64_t found[CVOL_CELL_SAMPLES / 64] = {0};
            make_coded(&r, coded, insides[i], splits[s]);
            memcpy(terms, coded, sizeof terms);
            for (int k = 0; k < CVOL_CELL_SAMPLES; k++)
                found[k / 64] |= (uint64_t)(terms[k] != 0) << k % 64;
            assert_true(
                cvol_true_length_take(terms, found, insides[i], splits[s], CVOL_TRUE_LENGTH_BITS));
            for (int k = 0; k < CVOL_CELL_SAMPLES; k++)
                assert_int_equal(found[k / 64] >> k % 64 & 1, terms[k] != 0);
            check_samples(&r, coded, terms, insides[i], splits[s]);
            memcpy(back, terms, sizeof back);
            assert_true(cvol_true_length_put(back, insides[i], splits[s], CVOL_TRUE_LENGTH_BITS));
            assert_memory_equal(back, coded, sizeof back);
            terms[0] += 1; /* no terms give these samples */
            assert_false(cvol_true_length_put(terms, insides[i], splits[s], CVOL_TRUE_LENGTH_BITS));
        }
}

/* The stored part of a cell does not depend on samples beyond the volume. */
static void samples_beyond_the_end_are_ignored(void **state)
{
    (void)state;
    static float samples[CVOL_CELL_SAMPLES] __attribute__((aligned(64))),
        first[CVOL_CELL_SAMPLES] __attribute__((aligned(64))),
        second[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    static const int inside[3] = {11, 16, 7};
    random_state r = {9};
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++)
        samples[i] = (float)(100 * random_signed(&r));
    cvol_true_length_forward(first, samples, inside, CVOL_CELL_WHOLE);
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++)
        if (i % 16 >= inside[0] || i / 256 >= inside[2])
            samples[i] = (float)(100 * random_signed(&r));
    cvol_true_length_forward(second, samples, inside, CVOL_CELL_WHOLE);
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++) {
        assert_true(fabsf(first[i] - second[i]) < 1e-2f);
        if (i % 16 >= inside[0] || i / 256 >= inside[2])
            assert_true(first[i] == 0);
    }
}

typedef void axes_function(double *, uint16_t *, const int *, uint16_t,
                           const cvol_true_length_matrix *);
typedef int round_function(int32_t *, uint64_t *, const double *, const uint16_t *);
CVOL_SIMD_DECLARE(void, cvol_true_length_axes,
                  (double *, uint16_t *, const int *, uint16_t, const cvol_true_length_matrix *));
CVOL_SIMD_DECLARE(int, cvol_true_length_round,
                  (int32_t *, uint64_t *, const double *, const uint16_t *));
static axes_function *const axes[] = CVOL_SIMD_SETS(cvol_true_length_axes);
static round_function *const round_all[] = CVOL_SIMD_SETS(cvol_true_length_round);

/* Bytes of a cell after a set's kernels, of matrices and rows that are the same for each. */
typedef struct cell_bytes {
    double cell[CVOL_CELL_SAMPLES];
    int32_t values[CVOL_CELL_SAMPLES];
    uint64_t found[CVOL_CELL_SAMPLES / 64];
    uint16_t rows[CVOL_CELL];
    int fits;
} cell_bytes;

static void run_set(cell_bytes *out, int set, const int inside[3], uint16_t split,
                    const cvol_true_length_matrix *matrices)
{
    random_state r = {(uint64_t)inside[0] + 31 * (uint64_t)inside[2] + 7};
    memset(out, 0, sizeof *out);
    for (int w = 0; w < CVOL_CELL; w++)
        out->rows[w] = (uint16_t)(random_below(&r, 3) ? random_below(&r, 1 << 16) : 0);
    for (int i = 0; i < CVOL_CELL_SAMPLES; i++)
        if (out->rows[i / 256] >> i / 16 % 16 & 1)
            out->cell[i] = random_below(&r, 2) ? 1e4 * random_signed(&r) : 0;
    axes[set](out->cell, out->rows, inside, split, matrices);
    if (split & 1) /* one too large for a term */
        for (int i = 0; i < CVOL_CELL_SAMPLES; i++)
            out->cell[i] *= out->cell[i] > 3e4 ? 1e6 : 1;
    out->fits = round_all[set](out->values, out->found, out->cell, out->rows);
}

static void every_instruction_set_gives_the_same_samples(void **state)
{
    (void)state;
    static cvol_true_length_matrix matrices[CVOL_CELL * CVOL_TRUE_LENGTH_WAYS];
    static cell_bytes first, other;
    random_state r = {5};
    int fits = 0;
    for (size_t m = 0; m < sizeof matrices / sizeof *matrices; m++) {
        matrices[m].reached = 0xffff;
        for (int k = 0; k < CVOL_CELL * CVOL_CELL; k++)
            matrices[m].of[k / CVOL_CELL][k % CVOL_CELL] = random_signed(&r);
    }
    for (int i = 0; i < INSIDES; i++)
        for (int s = 0; s < SPLITS; s++) {
            run_set(&first, 0, insides[i], splits[s], matrices);
            fits += first.fits;
            for (size_t set = 1; set < sizeof axes / sizeof *axes && set <= cvol_cpu_best();
                 set++) {
                run_set(&other, (int)set, insides[i], splits[s], matrices);
                assert_memory_equal(&first, &other, sizeof first);
            }
        }
    assert_true(fits > 0 && fits < INSIDES * SPLITS);
}

/* Errors of sums of halves, which cosines of some lengths make, have no effect. */
static void halves_round_towards_zero(void **state)
{
    (void)state;
    static const double lost[] = {-1e-9, 0, 1e-9};
    static double cell[CVOL_CELL_SAMPLES];
    static int32_t values[CVOL_CELL_SAMPLES];
    uint64_t found[CVOL_CELL_SAMPLES / 64] = {0};
    const uint16_t rows[CVOL_CELL] = {1};
    for (size_t set = 0; set < sizeof round_all / sizeof *round_all && set <= cvol_cpu_best();
         set++)
        for (size_t k = 0; k < 3; k++) {
            for (int i = 0; i < CVOL_CELL; i++)
                cell[i] = (i - 8) + (i < 8 ? -0.5 : 0.5) + lost[k];
            assert_true(round_all[set](values, found, cell, rows));
            for (int i = 0; i < CVOL_CELL; i++)
                assert_int_equal(values[i], i - 8);
            assert_int_equal(found[0], 0xfeff);
        }
}

static void too_large_terms_are_refused(void **state)
{
    (void)state;
    static int32_t values[CVOL_CELL_SAMPLES];
    uint64_t found[CVOL_CELL_SAMPLES / 64] = {1};
    values[0] = CVOL_VALUE_LIMIT >> CVOL_TRUE_LENGTH_BITS;
    assert_true(cvol_true_length_take(values, found, NULL, 0, CVOL_TRUE_LENGTH_BITS));
    assert_int_equal(values[0], CVOL_VALUE_LIMIT);
    values[0] = -(CVOL_VALUE_LIMIT >> CVOL_TRUE_LENGTH_BITS) - 1;
    assert_false(cvol_true_length_take(values, found, NULL, 0, CVOL_TRUE_LENGTH_BITS));
    values[0] = CVOL_VALUE_LIMIT >>
                CVOL_TRUE_LENGTH_BITS; /* a DC of 11 samples is larger as one of 16 */
    assert_false(cvol_true_length_take(values, found, insides[0], 0, CVOL_TRUE_LENGTH_BITS));
}

/* ---- files ------------------------------------------------------------------------------- */

static const size_t dims[3] = {43, 36, 50};

static cvol_array *compress(double psnr, int fast)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    const cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_FLOAT32);
    float *samples = support_waves(dims);
    cvol_array *array;
    options.target = CVOL_TARGET_PSNR;
    options.target_value = psnr;
    options.effort = fast ? CVOL_EFFORT_FAST : CVOL_EFFORT_DEFAULT;
    check_ok(cvol_compress(context, &array, NULL, samples, &grid, &options));
    free(samples);
    return array;
}

static cvol_array *write_and_read(const cvol_array *array)
{
    cvol_array *back;
    char *path = support_path(folder, "a.cvol");
    check_ok(cvol_array_write(context, array, path, NULL));
    check_ok(cvol_file_verify(context, NULL, path));
    check_ok(cvol_array_read(context, &back, path, NULL));
    free(path);
    return back;
}

static void files_round_trip(void **state)
{
    (void)state;
    cvol_array *array = compress(40, 0), *back = write_and_read(array), *again, *turned;
    cvol_array_info info;
    assert_int_equal(cvol_coding_of(array)->true_length, CVOL_TRUE_LENGTH_BITS);
    assert_int_equal(cvol_coding_of(back)->true_length, CVOL_TRUE_LENGTH_BITS);
    assert_true(back->step == array->step);
    cvol_array_get_info(&info, back); /* the report states the coder's options */
    assert_true(info.step == ldexp(back->step, CVOL_TRUE_LENGTH_BITS));
    support_terms_expect_same(array, back);
    again = write_and_read(back); /* coded again */
    assert_int_equal(cvol_coding_of(again)->true_length, CVOL_TRUE_LENGTH_BITS);
    support_terms_expect_same(array, again);
    cvol_array_free(again);
    check_ok(cvol_array_scale(context, &turned, -2, back, 1));
    again = write_and_read(turned);
    assert_int_equal(cvol_coding_of(again)->true_length, CVOL_TRUE_LENGTH_BITS);
    support_terms_expect_same(turned, again);
    cvol_array_free(again);
    cvol_array_free(turned);
    const cvol_keep keep = cvol_keep_threshold(20 * array->step);
    check_ok(cvol_array_truncate(context, &turned, array, &keep));
    assert_int_equal(cvol_coding_need(context, turned), CVOL_OK);
    cvol_coding_own(turned)->true_length =
        CVOL_TRUE_LENGTH_BITS; /* the writer checks a false claim */
    again = write_and_read(turned);
    assert_int_equal(cvol_coding_of(again)->true_length, 0);
    support_terms_expect_same(turned, again);
    cvol_array_free(again);
    cvol_array_free(turned);
    cvol_array_free(back);
    cvol_array_free(array);
}

static void effort_fast_does_not_use_true_length(void **state)
{
    (void)state;
    cvol_array *array = compress(40, 1);
    assert_int_equal(cvol_coding_of(array)->true_length, 0);
    cvol_array_free(array);
}

/* TRUE has an invalid number of bits. */
static void invalid_values_are_reported(void **state)
{
    (void)state;
    cvol_array *array = compress(35, 0), *back;
    char *path = support_path(folder, "a.cvol");
    for (uint32_t bits = 0; bits < 20; bits += 3) {
        size_t size, at = 0;
        check_ok(cvol_array_write(context, array, path, NULL));
        uint8_t *data = support_unpack(support_read(path, &size), &size);
        while (memcmp(data + at, "TRUE", 4))
            at++;
        data[at + 24] = (uint8_t)bits;
        for (int i = 0; i < 2; i++) { /* of the content, then of the header that has it */
            const uint32_t sum = i ? cvol_crc32c(data + at, 20) : cvol_crc32c(data + at + 24, 4);
            for (int b = 0; b < 4; b++)
                data[at + 16 + 4 * (size_t)i + (size_t)b] = (uint8_t)(sum >> 8 * b);
        }
        support_write(path, data, size);
        const int code = cvol_array_read(context, &back, path, NULL);
        assert_int_equal(code, bits == CVOL_TRUE_LENGTH_BITS ? CVOL_OK : CVOL_ERROR_CORRUPT);
        if (bits < 1 || bits > CVOL_TRUE_LENGTH_BITS_MAX)
            assert_non_null(strstr(cvol_context_message(context), "TRUE: bits is"));
        cvol_array_free(back);
        free(data);
    }
    free(path);
    cvol_array_free(array);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(terms_are_shorter_cosines_and_invert),
        cmocka_unit_test(samples_beyond_the_end_are_ignored),
        cmocka_unit_test(every_instruction_set_gives_the_same_samples),
        cmocka_unit_test(halves_round_towards_zero),
        cmocka_unit_test(too_large_terms_are_refused),
        cmocka_unit_test(files_round_trip),
        cmocka_unit_test(effort_fast_does_not_use_true_length),
        cmocka_unit_test(invalid_values_are_reported),
    };
    kernels_print_sets();
    return cmocka_run_group_tests(tests, files_setup, files_teardown);
}
