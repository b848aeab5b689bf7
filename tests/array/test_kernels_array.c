/* Kernels of arrays: each against its formula in plain C on random data, by every instruction set.
 *
 * The same bits as the reference: the scan and the packing of coefficients, sums of squares, dense
 * matrices, and exact evaluation (whose reference computes with 64-bit integers).
 *
 * Within rounding: products and convolutions of blocks, which may use fused multiply-add. u = 2^-24
 * is the unit of rounding. A sum of n products of floats, in any order, is off by at most n u times
 * the sum of the products' magnitudes (Higham, "Accuracy and stability of numerical algorithms",
 * section 3.1, n u << 1).
 *
 * Compared elsewhere: cvol_samples_* (test_samples.c), cvol_block_decode and cvol_block_forward
 * (test_block.c), cvol_cell_* (test_cell.c), cvol_lap_filter (test_lap.c), cvol_fft_*
 * (test_fft.c). */
#include "test.h"

#include "array/block/block_sums.h"
#include "array/block/exact.h"
#include "array/block/exact_kernel.h"
#include "array/convolve/block_convolve.h"
#include "array/multiply/block_product.h"
#include "array/truncate/build_pack.h"
#include "base/cpu.h"
#include "support_kernels.h"
#include "transform/block.h"
#include "transform/cell.h"
#include "transform/cell_bases.h"

enum { MOST = CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX, CASES = 24 };

#define UNIT 0x1p-24

static uint32_t words[2][2 * MOST];

/* ---- random blocks --------------------------------------------------------------------------- */

/* Terms within a random low box, at `words`; about one of 40 is an escape, of at most `most`. */
static cvol_block random_block(uint32_t *at, int block_log2, int32_t most, random_state *r)
{
    const int B = 1 << block_log2, place_bits = cvol_place_bits(block_log2);
    const int32_t plain = -cvol_term_escape(place_bits) - 1;
    const uint32_t one_of = 1 + random_below(r, 6);
    int low[3];
    cvol_block block = {.terms = at};
    for (int a = 0; a < 3; a++)
        low[a] = 1 + (int)random_below(r, (uint32_t)B);
    for (int i = 0; i < B * B * B; i++) {
        if (i % B >= low[0] || i / B % B >= low[1] || i / B / B >= low[2] ||
            random_below(r, one_of))
            continue;
        const int32_t limit = random_below(r, 40) && most > plain ? plain : most;
        const int32_t value = (int32_t)(random_signed(r) * limit);
        if (value)
            block.words += cvol_term_pack(at + block.words, (uint32_t)i, value, place_bits);
    }
    cvol_block_find_low(&block, block_log2);
    return block;
}

/* A block's values by place. */
static void spread(int32_t *values, const cvol_block *block, int block_log2)
{
    const uint32_t *next = block->terms, *end = cvol_block_end(block);
    memset(values, 0, sizeof *values << 3 * block_log2);
    while (next < end) {
        uint32_t place;
        const int32_t value = cvol_term_unpack(&next, &place, cvol_place_bits(block_log2));
        values[place] = value;
    }
}

/* ---- sums of squares ------------------------------------------------------------------------- */

CVOL_SIMD_DECLARE(double, cvol_block_squares, (const cvol_block *block, int place_bits));
typedef double squares_function(const cvol_block *, int);

/* Below 2^53 a sum of squares of integers is exact. */
static void squares_are_summed(void **state)
{
    (void)state;
    squares_function *const sets[] = CVOL_SIMD_SETS(cvol_block_squares);
    static const int32_t largest[3] = {(1 << 22) + 1000, 1 << 20, 1 << 18};
    static int32_t values[MOST];
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(number);
        const int block_log2 = 3 + (int)random_below(&r, 3);
        const cvol_block block = random_block(words[0], block_log2, largest[block_log2 - 3], &r);
        uint64_t sum = 0;
        spread(values, &block, block_log2);
        for (int i = 0; i < 1 << 3 * block_log2; i++)
            sum += (uint64_t)((int64_t)values[i] * values[i]);
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            const double found = sets[set](&block, cvol_place_bits(block_log2));
            if (found != (double)sum)
                fail_msg("squares, %s, case %d: %.17g, not %.17g", cvol_cpu_name((cvol_cpu)set),
                         (int)number, found, (double)sum);
        }
    }
}

/* ---- scanning and packing -------------------------------------------------------------------- */

CVOL_SIMD_DECLARE(void, cvol_block_scan, (cvol_scan_task * task));
CVOL_SIMD_DECLARE(void, cvol_block_pack, (cvol_pack_task * task));
typedef void scan_function(cvol_scan_task *);
typedef void pack_function(cvol_pack_task *);

/* Column i of a row is squared in lane i % 16; then lanes 8 to 15 are added to 0 to 7. Whole boxes
 * are treated as one long row. */
static void scan_reference(cvol_scan_task *task)
{
    const int B = 1 << task->block_log2, rows = task->rank > 1 ? task->box[1] : 1;
    const int sheets = task->rank > 2 ? task->box[2] : 1;
    double lanes[16] = {0};
    task->count = 0;
    for (int z = 0; z < sheets; z++)
        for (int y = 0; y < rows; y++)
            for (int x = 0; x < task->box[0]; x++) {
                const int place = x + B * (y + B * z);
                const int lane = (task->box[0] == B ? x + B * y : x) % 16;
                const float value = task->coefficients[place];
                const float key = task->keys ? task->keys[place] : fabsf(value);
                if (key >= task->least) {
                    task->places[task->count] = (uint32_t)place;
                    task->values[task->count++] = value;
                } else {
                    lanes[lane] += (double)value * (double)value;
                }
            }
    task->lost = 0;
    for (int lane = 0; lane < 8; lane++)
        task->lost += lanes[lane] + lanes[8 + lane];
}

static void coefficients_are_found(void **state)
{
    (void)state;
    scan_function *const sets[] = CVOL_SIMD_SETS(cvol_block_scan);
    static float coefficients[MOST + CVOL_SCAN_MARGIN], keys[MOST + CVOL_SCAN_MARGIN];
    static float values[MOST];
    static uint32_t places[MOST];
    for (uint64_t number = 0; number < 3 * CASES; number++) {
        random_state r = kernels_random(100 + number);
        const float magnitudes[3] = {1, 2, 0.5f};
        cvol_scan_task task = {.coefficients = coefficients,
                               .keys = random_below(&r, 2) ? keys : NULL,
                               .rank = 1 + (int)random_below(&r, 3),
                               .block_log2 = 3 + (int)random_below(&r, 3),
                               .least = magnitudes[random_below(&r, 3)]};
        const int B = 1 << task.block_log2;
        for (int a = 0; a < 3; a++)
            task.box[a] = random_below(&r, 3) ? 1 + (int)random_below(&r, (uint32_t)B) : B;
        for (int i = 0; i < MOST + CVOL_SCAN_MARGIN; i++) {
            coefficients[i] = (float)(random_signed(&r) * exp(2 * random_signed(&r)));
            if (random_below(&r, 20) == 0) /* at the limit, and next to it */
                coefficients[i] = (random_below(&r, 2) ? -1.0f : 1.0f) *
                                  nextafterf(task.least, (float)random_below(&r, 4));
            keys[i] = (float)fabs(2 * random_signed(&r));
        }
        cvol_scan_task expected = task;
        expected.values = values;
        expected.places = places;
        scan_reference(&expected);
        task.values = kernels_memory(sizeof *values * (expected.count + CVOL_SCAN_MARGIN));
        task.places = kernels_memory(sizeof *places * (expected.count + CVOL_SCAN_MARGIN));
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            kernels_refill(task.values);
            kernels_refill(task.places);
            sets[set](&task);
            assert_int_equal(task.count, expected.count);
            kernels_expect_same(task.values, values, sizeof *values * task.count, "scan", set);
            kernels_expect_same(task.places, places, sizeof *places * task.count, "scan", set);
            kernels_expect_same(&task.lost, &expected.lost, sizeof task.lost, "lost", set);
            kernels_check_guards(task.values, "values", set);
            kernels_check_guards(task.places, "places", set);
        }
        kernels_free(task.values);
        kernels_free(task.places);
    }
}

/* Number i is summed in lane i % 8. */
static void pack_reference(cvol_pack_task *task)
{
    const int B = 1 << task->block_log2;
    double lost[8] = {0}, norm[8] = {0};
    task->word_count = task->terms = 0;
    task->largest = task->lost = task->norm = 0;
    memset(task->low, 0, sizeof task->low);
    for (uint32_t i = 0; i < task->count; i++) {
        const double c = (double)task->values[i], magnitude = fabs(c);
        const double steps = magnitude * (1 / task->step) + 0.5;
        const int kept = magnitude >= (double)task->least && steps < (double)(1 << CVOL_MAX_BITS);
        const int32_t whole = kept ? (int32_t)steps : 0;
        const uint32_t place = task->places[i];
        const int at[3] = {(int)place % B, (int)place / B % B, (int)place / B / B};
        task->integers[i] = c < 0 ? -whole : whole;
        const double rest = c - (double)task->integers[i] * task->step;
        lost[i % 8] += rest * rest;
        norm[i % 8] += c * c;
        task->largest = magnitude > task->largest ? magnitude : task->largest;
        if (!whole)
            continue;
        task->terms++;
        task->word_count += cvol_term_pack(task->words + task->word_count, place, task->integers[i],
                                           cvol_place_bits(task->block_log2));
        for (int a = 0; a < 3; a++)
            task->low[a] = (uint8_t)(at[a] + 1 > task->low[a] ? at[a] + 1 : task->low[a]);
    }
    for (int lane = 0; lane < 8; lane++) {
        task->lost += lost[lane];
        task->norm += norm[lane];
    }
}

static void coefficients_are_packed(void **state)
{
    (void)state;
    pack_function *const sets[] = CVOL_SIMD_SETS(cvol_block_pack);
    static float values[MOST + CVOL_SCAN_MARGIN];
    static uint32_t places[MOST + CVOL_SCAN_MARGIN];
    static int32_t integers[MOST];
    for (uint64_t number = 0; number < 3 * CASES; number++) {
        random_state r = kernels_random(200 + number);
        cvol_pack_task task = {.values = values,
                               .places = places,
                               .block_log2 = 3 + (int)random_below(&r, 3),
                               .step = 0.1 + random_below(&r, 4),
                               .least = (float)random_below(&r, 3)};
        const uint32_t one_of = 1 + random_below(&r, 9), escapes = random_below(&r, 2);
        for (uint32_t place = 0; place < 1u << 3 * task.block_log2; place++)
            if (random_below(&r, one_of) == 0) {
                double value = 9 * random_signed(&r);
                if (random_below(&r, 9) == 0) /* a tie between two */
                    value = (floor(value) + 0.5) * task.step;
                if (escapes && random_below(&r, 50) == 0)
                    value *= 1e6 * (random_below(&r, 9) ? 1 : 1e6);
                values[task.count] = (float)value;
                places[task.count++] = place;
            }
        for (uint32_t i = task.count; i < task.count + CVOL_SCAN_MARGIN; i++) {
            values[i] = (float)(1e9 * random_signed(&r));
            places[i] = (uint32_t)random_u64(&r);
        }
        cvol_pack_task expected = task;
        expected.integers = integers;
        expected.words = words[0];
        pack_reference(&expected);
        task.integers = kernels_memory(sizeof *integers * (task.count + CVOL_SCAN_MARGIN));
        task.words = kernels_memory(4 * (2 * (size_t)task.count + CVOL_SCAN_MARGIN));
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            kernels_refill(task.integers);
            kernels_refill(task.words);
            sets[set](&task);
            kernels_expect_same(task.integers, integers, sizeof *integers * task.count, "pack",
                                set);
            assert_int_equal(task.word_count, expected.word_count);
            assert_int_equal(task.terms, expected.terms);
            kernels_expect_same(task.words, words[0], 4 * (size_t)task.word_count, "words", set);
            kernels_expect_same(task.low, expected.low, sizeof task.low, "low", set);
            kernels_expect_same(&task.lost, &expected.lost, sizeof task.lost, "lost", set);
            kernels_expect_same(&task.norm, &expected.norm, sizeof task.norm, "norm", set);
            assert_true(task.largest == expected.largest);
            kernels_check_guards(task.integers, "integers", set);
            kernels_check_guards(task.words, "words", set);
        }
        kernels_free(task.integers);
        kernels_free(task.words);
    }
}

/* ---- dense matrices -------------------------------------------------------------------------- */

CVOL_SIMD_DECLARE(void, cvol_block_matrix,
                  (float *data, const float *matrix, const float *transposed, int rank,
                   int block_log2));
typedef void matrix_function(float *, const float *, const float *, int, int);

/* Along one axis: sums begin with 0 and run from the first sample to the last. */
static void multiply_axis(float *data, const float *matrix, int stride, int count, int B)
{
    float in[CVOL_BLOCK_MAX];
    for (int first = 0; first < count; first++) {
        if (first / stride % B)
            continue;
        for (int x = 0; x < B; x++)
            in[x] = data[first + x * stride];
        for (int u = 0; u < B; u++) {
            float sum = 0;
            for (int x = 0; x < B; x++)
                sum += matrix[u * B + x] * in[x];
            data[first + u * stride] = sum;
        }
    }
}

static void matrices_are_multiplied(void **state)
{
    (void)state;
    matrix_function *const sets[] = CVOL_SIMD_SETS(cvol_block_matrix);
    static float matrix[1024] __attribute__((aligned(64)));
    static float transposed[1024] __attribute__((aligned(64)));
    static float in[MOST], expected[MOST];
    for (uint64_t number = 0; number < 9; number++) {
        random_state r = kernels_random(300 + number);
        const int rank = 1 + (int)number % 3, block_log2 = 3 + (int)number / 3, B = 1 << block_log2;
        const int count = rank == 1 ? B : rank == 2 ? B * B : B * B * B;
        const size_t bytes = sizeof *in * (size_t)count;
        for (int i = 0; i < B * B; i++)
            transposed[i % B * B + i / B] = matrix[i] = (float)random_signed(&r);
        for (int i = 0; i < count; i++)
            in[i] = (float)(100 * random_signed(&r));
        memcpy(expected, in, bytes);
        for (int a = 0, stride = 1; a < rank; a++, stride *= B)
            multiply_axis(expected, matrix, stride, count, B);
        float *data = kernels_memory(bytes);
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            memcpy(data, in, bytes);
            sets[set](data, matrix, transposed, rank, block_log2);
            kernels_expect_same(data, expected, bytes, "matrix", set);
            kernels_check_guards(data, "matrix", set);
        }
        kernels_free(data);
    }
}

/* ---- exact evaluation ------------------------------------------------------------------------ */

CVOL_SIMD_DECLARE(void, cvol_exact_cell,
                  (double *out, const cvol_block *block, double unit, const size_t first[3],
                   const size_t last[3], const cvol_exact_bases *bases));
CVOL_SIMD_DECLARE(void, cvol_exact_lap,
                  (double *samples, const cvol_exact_faces *faces, const double h[4]));
CVOL_SIMD_DECLARE(void, cvol_exact_finish,
                  (double *out, const double *in, size_t count, double offset, double step,
                   double lo, double hi, int is_integer));
typedef void cell_function(double *, const cvol_block *, double, const size_t[3], const size_t[3],
                           const cvol_exact_bases *);
typedef void exact_lap_function(double *, const cvol_exact_faces *, const double[4]);
typedef void finish_function(double *, const double *, size_t, double, double, double, double, int);

#define MATRIX_ONE ((double)(1 << CVOL_EXACT_MATRIX_BITS))

/* The matrices as the kernels read them, from the integers. */
static void make_bases(cvol_exact_bases *bases)
{
    const int32_t *of_4 = cvol_exact_matrix(2), *of_8 = cvol_exact_matrix(3),
                  *of_16 = cvol_exact_matrix(4);
    memset(bases, 0, sizeof *bases);
    for (int u = 0; u < 16; u++)
        for (int x = 0; x < 8; x++) {
            const int c = u & 1, g = u / 2;
            bases->rows[CVOL_CELL_BY_16][u][8 * c + x] = of_16[u * 16 + x] / MATRIX_ONE;
            bases->rows[CVOL_CELL_BY_8][u][8 * c + x] = of_8[g * 8 + x] / MATRIX_ONE;
            if (g % 2 == x / 4)
                bases->rows[CVOL_CELL_BY_4][u][8 * c + x] = of_4[g / 2 * 4 + x % 4] / MATRIX_ONE;
            bases->of_16[u][x] = of_16[u * 16 + x] / MATRIX_ONE;
        }
    for (int i = 0; i < 8 * 4; i++)
        bases->of_8[i / 4][i % 4] = of_8[i / 4 * 8 + i % 4] / MATRIX_ONE;
    for (int i = 0; i < 4 * 2; i++)
        bases->of_4[i / 2][i % 2] = of_4[i / 2 * 4 + i % 2] / MATRIX_ONE;
}

/* floor(sum / 2^20 + 1/2) */
static int64_t rounded(int64_t sum)
{
    const int64_t one = INT64_C(1) << CVOL_EXACT_MATRIX_BITS, above = sum + one / 2;
    return above >= 0 ? above / one : -((-above + one - 1) / one);
}

/* v[x] = round(sum over f of C[f][x] v[f]) along one axis of a part. */
static void exact_line(int64_t *line, int stride, int M)
{
    const int32_t *C = cvol_exact_matrix(M == 4 ? 2 : M == 8 ? 3 : 4);
    int64_t in[16];
    for (int f = 0; f < M; f++)
        in[f] = line[f * stride];
    for (int x = 0; x < M; x++) {
        int64_t sum = 0;
        for (int f = 0; f < M; f++)
            sum += C[f * M + x] * in[f];
        line[x * stride] = rounded(sum);
    }
}

static void exact_cell_reference(int64_t out[CVOL_CELL_SAMPLES], const cvol_block *block, int unit)
{
    static int32_t values[CVOL_CELL_SAMPLES];
    static const int strides[3] = {1, 16, 256};
    cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX];
    spread(values, block, 4);
    for (int p = 0, count = cvol_cell_list_sub_blocks(parts, block->split); p < count; p++) {
        const int M = parts[p].side, apart = 16 / M, *to = parts[p].begin, *from = parts[p].first;
        int64_t *corner = out + to[0] + 16 * to[1] + 256 * to[2];
        for (int i = 0; i < M * M * M; i++)
            corner[i % M + 16 * (i / M % M) + 256 * (i / M / M)] =
                (int64_t)unit *
                values[from[0] + i % M * apart + 16 * (from[1] + i / M % M * apart) +
                       256 * (from[2] + i / M / M * apart)];
        for (int a = 0; a < 3; a++)
            for (int i = 0; i < M * M; i++)
                exact_line(corner + i % M * strides[a == 0] + i / M * strides[a == 2 ? 1 : 2],
                           strides[a], M);
    }
}

static void cells_equal_integer_arithmetic(void **state)
{
    (void)state;
    cell_function *const sets[] = CVOL_SIMD_SETS(cvol_exact_cell);
    static cvol_exact_bases bases;
    static int64_t expected[CVOL_CELL_SAMPLES];
    double *out = kernels_memory(sizeof *out * CVOL_CELL_SAMPLES);
    make_bases(&bases);
    for (uint64_t number = 0; number < 2 * CASES; number++) {
        random_state r = kernels_random(400 + number);
        cvol_block block = random_block(words[0], 4, 500, &r);
        const uint16_t split = (uint16_t)(1 | random_below(&r, 512));
        block.split = number % 3 ? split : 0;
        size_t first[3], last[3];
        for (int a = 0; a < 3; a++) {
            first[a] = random_below(&r, 3) ? 0 : random_below(&r, 16);
            last[a] = first[a] + 1 + random_below(&r, (uint32_t)(16 - first[a]));
        }
        exact_cell_reference(expected, &block, 1 << number % 3);
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            kernels_refill(out);
            sets[set](out, &block, (double)(1 << number % 3), first, last, &bases);
            kernels_check_guards(out, "exact cell", set);
            for (size_t i = 0; i < CVOL_CELL_SAMPLES; i++) {
                const size_t at[3] = {i % 16, i / 16 % 16, i / 256};
                int inside = 1;
                for (int a = 0; a < 3; a++)
                    inside &= at[a] >= first[a] && at[a] < last[a];
                if (inside && out[i] != (double)expected[i])
                    fail_msg("exact cell, %s, case %d: sample %d is %.17g, not %.17g",
                             cvol_cpu_name((cvol_cpu)set), (int)number, (int)i, out[i],
                             (double)expected[i]);
            }
        }
    }
    kernels_free(out);
}

static void exact_lap_reference(double *samples, const cvol_exact_faces *faces)
{
    for (int64_t j = 0; j < faces->lines[1]; j++)
        for (int64_t f = 0; f < faces->count; f++)
            for (int64_t i = 0; i < faces->lines[0]; i++) {
                double *a = samples + j * faces->line_stride[1] + f * faces->face_stride +
                            i * faces->line_stride[0];
                const int64_t s = faces->stride;
                const int64_t w[2] = {(int64_t)a[s] - (int64_t)a[2 * s],
                                      (int64_t)a[0] - (int64_t)a[3 * s]};
                int64_t d[2];
                for (int k = 0; k < 2; k++)
                    d[k] = rounded(cvol_exact_filter[2 * k] * w[0] +
                                   cvol_exact_filter[2 * k + 1] * w[1]);
                a[0] += (double)d[1];
                a[s] += (double)d[0];
                a[2 * s] -= (double)d[0];
                a[3 * s] -= (double)d[1];
            }
}

static void exact_faces_are_filtered(void **state)
{
    (void)state;
    enum { COUNT = 40 * 40 * 9 };
    exact_lap_function *const sets[] = CVOL_SIMD_SETS(cvol_exact_lap);
    static const cvol_exact_faces ways[] = {
        {.count = 3, .face_stride = 10, .stride = 1, .lines = {37, 5}, .line_stride = {40, 1600}},
        {.count = 3, .face_stride = 400, .stride = 40, .lines = {37, 7}, .line_stride = {1, 1600}},
        {.count = 2, .face_stride = 80, .stride = 7, .lines = {3, 9}, .line_stride = {2, 1600}},
    };
    static double in[COUNT], expected[COUNT];
    double h[4], *out = kernels_memory(sizeof in);
    for (int i = 0; i < 4; i++)
        h[i] = cvol_exact_filter[i] / MATRIX_ONE;
    for (uint64_t number = 0; number < 9; number++) {
        random_state r = kernels_random(500 + number);
        for (int i = 0; i < COUNT; i++)
            in[i] = floor(0x1p31 * random_signed(&r));
        memcpy(expected, in, sizeof in);
        exact_lap_reference(expected, &ways[number % 3]);
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            memcpy(out, in, sizeof in);
            sets[set](out, &ways[number % 3], h);
            kernels_expect_same(out, expected, sizeof in, "exact filter", set);
            kernels_check_guards(out, "exact filter", set);
        }
    }
    kernels_free(out);
}

static void exact_samples_are_finished(void **state)
{
    (void)state;
    finish_function *const sets[] = CVOL_SIMD_SETS(cvol_exact_finish);
    static double in[70], expected[70];
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(600 + number);
        const int is_integer = (int)number % 2;
        const size_t count = random_below(&r, 70);
        const double step = 0x1p-9 * (1 + random_below(&r, 9)), offset = 100 * random_signed(&r);
        const double lo = is_integer ? -40 : -33.3, hi = is_integer ? 255 : 200.7;
        for (size_t i = 0; i < count; i++) {
            in[i] = floor(1e5 * random_signed(&r));
            const double value = fmin(fmax(offset + step * in[i], lo), hi);
            expected[i] = is_integer ? floor(value + 0.5) : value;
        }
        double *out = kernels_memory(sizeof *out * count);
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            kernels_refill(out);
            sets[set](out, in, count, offset, step, lo, hi, is_integer);
            kernels_expect_same(out, expected, sizeof *out * count, "exact samples", set);
            kernels_check_guards(out, "exact samples", set);
        }
        kernels_free(out);
    }
}

/* ---- products -------------------------------------------------------------------------------- */

CVOL_SIMD_DECLARE(void, cvol_block_product,
                  (float *out, int box[3], const cvol_product_factor *a,
                   const cvol_product_factor *b, int block_log2, cvol_product_work *work));
typedef void product_function(float *, int[3], const cvol_product_factor *,
                              const cvol_product_factor *, int, cvol_product_work *);

/* Along each axis by a matrix, or by its transpose, in double precision. */
static void transform(double *data, const float *matrix, int is_transposed, int B)
{
    double in[CVOL_BLOCK_MAX];
    for (int stride = 1; stride < B * B * B; stride *= B)
        for (int first = 0; first < B * B * B; first++) {
            if (first / stride % B)
                continue;
            for (int x = 0; x < B; x++)
                in[x] = data[first + x * stride];
            for (int u = 0; u < B; u++) {
                double sum = 0;
                for (int x = 0; x < B; x++)
                    sum += (double)matrix[is_transposed ? x * B + u : u * B + x] * in[x];
                data[first + u * stride] = sum;
            }
        }
}

/* The samples of terms. */
static void evaluate(double *samples, const cvol_block *block, double step, int block_log2)
{
    static int32_t values[MOST];
    const int B = 1 << block_log2;
    spread(values, block, block_log2);
    for (int i = 0; i < B * B * B; i++)
        samples[i] = step * values[i];
    transform(samples, cvol_block_basis(B), 1, B);
}

/* The transforms are orthonormal, so that norms of errors pass unchanged. Each of the three axes
 * adds sums of B products, whose errors, which are independent, have a norm of at most sqrt(B) u
 * times that of the numbers: for the two factors and for the result. */
static double product_tolerance(int B)
{
    return 9 * sqrt(B) * UNIT;
}

static void check_product(const float *found, const int box[3], const cvol_product_factor *a,
                          const cvol_product_factor *b, int block_log2, int set)
{
    static double of_a[MOST], of_b[MOST];
    const int B = 1 << block_log2, count = B * B * B;
    double size = 0, error = 0;
    evaluate(of_a, a->block, (double)a->step, block_log2);
    evaluate(of_b, b->block, (double)b->step, block_log2);
    for (int i = 0; i < count; i++) {
        const double most = fabs(of_a[i]) * (fabs(of_b[i]) + fabs((double)b->offset)) +
                            fabs((double)a->offset * of_b[i]);
        size += most * most;
        of_a[i] = (double)a->offset * of_b[i] + (double)b->offset * of_a[i] + of_a[i] * of_b[i];
    }
    transform(of_a, cvol_block_basis(B), 0, B);
    for (int i = 0; i < count; i++) {
        const int inside = i % B < box[0] && i / B % B < box[1] && i / B / B < box[2];
        const double off = (inside ? (double)found[i] : 0) - of_a[i];
        error += off * off;
    }
    if (!(sqrt(error) <= product_tolerance(B) * sqrt(size)))
        fail_msg("product, %s: error %g, at most %g", cvol_cpu_name((cvol_cpu)set), sqrt(error),
                 product_tolerance(B) * sqrt(size));
}

static void blocks_are_multiplied(void **state)
{
    (void)state;
    product_function *const sets[] = CVOL_SIMD_SETS(cvol_block_product);
    static cvol_product_work work;
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(700 + number);
        const int block_log2 = 3 + (int)number % 3, B = 1 << block_log2;
        cvol_block blocks[2];
        for (int k = 0; k < 2; k++) {
            blocks[k] = random_block(words[k], block_log2, 1000, &r);
            if ((int)random_below(&r, 8) == k) { /* with nothing but its offset */
                blocks[k].words = 0;
                memset(blocks[k].low, 0, sizeof blocks[k].low);
            }
        }
        const cvol_product_factor a = {&blocks[0], 0.5f, (float)(50 * random_signed(&r))},
                                  b = {&blocks[1], 0.25f, (float)(50 * random_signed(&r))};
        float *out = kernels_memory(sizeof *out * (size_t)(B * B * B));
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            int box[3];
            kernels_refill(out);
            sets[set](out, box, &a, &b, block_log2, &work);
            check_product(out, box, &a, &b, block_log2, set);
            kernels_check_guards(out, "product", set);
        }
        kernels_free(out);
    }
}

/* ---- convolutions ---------------------------------------------------------------------------- */

CVOL_SIMD_DECLARE(void, cvol_block_convolve,
                  (float *out, const cvol_block *const near[27], const cvol_convolve_part *parts,
                   int part_count, int block_log2, cvol_convolve_work *work));
typedef void convolve_function(float *, const cvol_block *const[27], const cvol_convolve_part *,
                               int, int, cvol_convolve_work *);

enum { PARTS = 2 };
static float matrices[PARTS][3][3][1024] __attribute__((aligned(64)));
static cvol_convolve_part parts[PARTS];

/* Random matrices; some are missing. */
static void make_parts(random_state *r, int B)
{
    const int width = B < 16 ? 16 : B;
    for (int p = 0; p < PARTS; p++) {
        cvol_face_matrices *of[3] = {&parts[p].x, &parts[p].y, &parts[p].z};
        parts[p].weight = (float)random_signed(r);
        for (int a = 0; a < 3; a++)
            for (int d = 0; d < 3; d++) {
                float *matrix = matrices[p][a][d];
                memset(matrix, 0, sizeof matrices[p][a][d]);
                for (int i = 0; i < B * B; i++)
                    matrix[i / B * (a ? B : width) + i % B] = (float)random_signed(r);
                of[a]->of[d] = d != 1 && random_below(r, 3) == 0 ? NULL : matrix;
            }
    }
}

/* out[u'] += sum_u H[u'][u] in[u] along one axis; along x H is transposed. `sizes`: of
 * magnitudes. */
static void apply(double *data, const float *matrix, int axis, int B, int sizes)
{
    const int width = B < 16 ? 16 : B, stride = axis == 0 ? 1 : axis == 1 ? B : B * B;
    double in[CVOL_BLOCK_MAX];
    for (int first = 0; first < B * B * B; first++) {
        if (first / stride % B)
            continue;
        for (int x = 0; x < B; x++)
            in[x] = data[first + x * stride];
        for (int u = 0; u < B; u++) {
            double sum = 0;
            for (int x = 0; x < B; x++) {
                const double h = (double)(axis ? matrix[u * B + x] : matrix[x * width + u]);
                sum += (sizes ? fabs(h) : h) * in[x];
            }
            data[first + u * stride] = sum;
        }
    }
}

static void convolve_reference(double *out, const cvol_block *const near[27], int block_log2,
                               int sizes)
{
    static int32_t values[MOST];
    static double one[MOST];
    const int B = 1 << block_log2;
    memset(out, 0, sizeof *out * MOST);
    for (int p = 0; p < PARTS; p++)
        for (int d = 0; d < 27; d++) {
            const float *const of[3] = {parts[p].x.of[d % 3], parts[p].y.of[d / 3 % 3],
                                        parts[p].z.of[d / 9]};
            const double weight = (double)parts[p].weight;
            if (!near[d] || !of[0] || !of[1] || !of[2])
                continue;
            spread(values, near[d], block_log2);
            for (int i = 0; i < B * B * B; i++)
                one[i] = sizes ? abs(values[i]) : values[i];
            for (int a = 0; a < 3; a++)
                apply(one, of[a], a, B, sizes);
            for (int i = 0; i < B * B * B; i++)
                out[i] += (sizes ? fabs(weight) : weight) * one[i];
        }
}

static void blocks_are_convolved(void **state)
{
    (void)state;
    convolve_function *const sets[] = CVOL_SIMD_SETS(cvol_block_convolve);
    static cvol_convolve_work work;
    static uint32_t near_words[27][2 * MOST];
    static double expected[MOST], sizes[MOST];
    for (uint64_t number = 0; number < 6; number++) {
        random_state r = kernels_random(800 + number);
        const int block_log2 = 3 + (int)number % 3, B = 1 << block_log2;
        cvol_block blocks[27];
        const cvol_block *near[27];
        for (int d = 0; d < 27; d++) {
            blocks[d] = random_block(near_words[d], block_log2, 1000, &r);
            near[d] = d != 13 && random_below(&r, 3) ? NULL : &blocks[d];
        }
        make_parts(&r, B);
        convolve_reference(expected, near, block_log2, 0);
        convolve_reference(sizes, near, block_log2, 1);
        /* A path has at most 3 B products along each axis, of three matrices, and a weight. */
        for (int i = 0; i < B * B * B; i++)
            sizes[i] *= (3 * 3 * B + 2 * PARTS) * UNIT;
        float *out = kernels_memory(sizeof *out * (size_t)(B * B * B));
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            kernels_refill(out);
            sets[set](out, near, parts, PARTS, block_log2, &work);
            kernels_expect_near(out, expected, sizes, (size_t)(B * B * B), "convolution", set);
            kernels_check_guards(out, "convolution", set);
        }
        kernels_free(out);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(squares_are_summed),
        cmocka_unit_test(coefficients_are_found),
        cmocka_unit_test(coefficients_are_packed),
        cmocka_unit_test(matrices_are_multiplied),
        cmocka_unit_test(cells_equal_integer_arithmetic),
        cmocka_unit_test(exact_faces_are_filtered),
        cmocka_unit_test(exact_samples_are_finished),
        cmocka_unit_test(blocks_are_multiplied),
        cmocka_unit_test(blocks_are_convolved),
    };
    kernels_begin();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
