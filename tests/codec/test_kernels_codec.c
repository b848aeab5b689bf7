/* Kernels of the codec: each against plain C on random data, to the bit, by every instruction set.
 *
 * Compared elsewhere: cvol_cell_weights and cvol_cell_quantise (test_split_fast.c), cvol_compare_*
 * (test_samples.c), cvol_neural_evaluate and cvol_neural_evaluate_kinds (test_neural.c).
 */
#include "test.h"

#include "base/cpu.h"
#include "codec/neural/neural_internal.h"
#include "codec/neural/neural_kernels.h"
#include "codec/quantize/quantize.h"
#include "codec/quantize/trellis.h"
#include "codec/quantize/trellis_kernel.h"
#include "codec/quantize/true_length_kernel.h"
#include "support_kernels.h"

enum { CASES = 24, N = CVOL_CELL, ALL = CVOL_CELL_SAMPLES };

/* ---- the trellis ----------------------------------------------------------------------------- */

CVOL_SIMD_DECLARE(void, cvol_trellis_walk,
                  (cvol_trellis *, const float *, int, const cvol_scan *, const cvol_token_costs *,
                   uint16_t *));
typedef void walk_function(cvol_trellis *, const float *, int, const cvol_scan *,
                           const cvol_token_costs *, uint16_t *);

/* The nearest index of a parity to a magnitude, where values are odd or even, and its cost; or a
 * zero, if that costs less. An odd index cannot be zero. */
static float cost_of_branch(int32_t *index, float size, int odd_values, int parity,
                            cvol_place_code code, const cvol_token_costs *costs)
{
    const float offset = odd_values ? 0.5f : 0;
    const int32_t k = 2 * (int32_t)(0.5f * size + (0.5f * offset + (parity ? 0 : 0.5f))) + parity;
    const float error = size - ((float)k - offset);
    const float cost = error * error +
                       CVOL_LAMBDA_TRELLIS * cvol_bits_of_value(costs, code, (uint32_t)k);
    const float zero = size * size + CVOL_LAMBDA_TRELLIS * cvol_bits_of_zero(costs, code);
    *index = 0;
    if (!parity && !(cost < zero))
        return zero;
    *index = k;
    return cost;
}

/* The best way to each of the eight states behind a coefficient. */
static uint8_t step_reference(float sums[CVOL_STATES], const float cost[2][2])
{
    float after[CVOL_STATES];
    unsigned odd_ones = 0;
    for (int s = 0; s < CVOL_STATES; s++) {
        float way[2];
        for (int parity = 0; parity < 2; parity++) {
            const int from = cvol_state_before[parity][s];
            way[parity] = sums[from] + cost[cvol_state_is_odd(from)][parity];
        }
        odd_ones |= (unsigned)(way[1] < way[0]) << s;
        after[s] = way[1] < way[0] ? way[1] : way[0];
    }
    memcpy(sums, after, sizeof after);
    return (uint8_t)odd_ones;
}

static void walk_reference(cvol_trellis *t, const float *scaled, int extent, const cvol_scan *scan,
                           const cvol_token_costs *costs, uint16_t *scatter)
{
    float sums[CVOL_STATES] = {0, 1e30f, 1e30f, 1e30f, 1e30f, 1e30f, 1e30f, 1e30f};
    for (int i = 1, run = 0; i < extent; run++) {
        const int begin = i, end = scan->run_ends[run] < extent ? scan->run_ends[run] : extent;
        for (; i < end; i++) {
            const cvol_scan_entry *entry = &scan->entries[i];
            float cost[2][2];
            t->near[i] = scatter[entry->scatter];
            for (int branch = 0; branch < CVOL_BRANCHES; branch++)
                cost[branch / 2][branch % 2] = cost_of_branch(
                    &t->index[i][branch], fabsf(scaled[i]), branch / 2, branch % 2,
                    cvol_value_code(scan->size_class, entry->band, t->near[i], 1, branch / 2),
                    costs);
            memcpy(t->sums[i], sums, sizeof sums);
            t->odd[i] = step_reference(sums, (const float(*)[2])cost);
        }
        int best = 0;
        for (int s = 1; s < CVOL_STATES; s++)
            best = sums[s] < sums[best] ? s : best;
        for (int k = end - 1; k >= begin && end < extent; k--) {
            const uint32_t index = cvol_trellis_back(t, k, &best);
            if (index)
                cvol_scatter(scatter + scan->entries[k].scatter, scan->row, scan->sheet,
                             cvol_trellis_magnitude(best, index));
        }
    }
    memcpy(t->sums[extent], sums, sizeof sums);
}

static void paths_have_the_lowest_cost(void **state)
{
    (void)state;
    walk_function *const sets[] = CVOL_SIMD_SETS(cvol_trellis_walk);
    static uint16_t scatter[CVOL_SCATTER_MAX];
    static float scaled[ALL];
    static cvol_token_costs costs;
    cvol_trellis *expected = cvol_trellis_create();
    cvol_trellis *found = kernels_memory(sizeof *found);
    uint16_t *sums = kernels_memory(sizeof scatter);
    assert_non_null(expected);
    for (uint64_t number = 0; number < 2 * CASES; number++) {
        random_state r = kernels_random(number);
        const cvol_scan *scan = cvol_sub_block_scan_of((int)random_below(&r, 3));
        const int extent = 2 + (int)random_below(&r, (uint32_t)scan->count - 1);
        /* Some values need escapes and raw bits. */
        const double scale = exp2(random_signed(&r) * (number % 4 ? 5 : 20));
        for (int i = 0; i < extent; i++)
            scaled[i] = (float)(scale * random_signed(&r) * random_signed(&r));
        for (int row = 0; row < CVOL_ROWS; row++)
            for (int t = 0; t < CVOL_TOKENS; t++)
                costs.of[row][t] = (float)random_below(&r, 15000) / 1000;
        memset(scatter, 0, sizeof scatter);
        cvol_scatter_dc(scatter, scan->row, scan->sheet, (int32_t)random_below(&r, 4));
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            kernels_refill(found);
            kernels_refill(sums);
            memcpy(sums, scatter, sizeof scatter);
            sets[set](found, scaled, extent, scan, &costs, sums);
            static uint16_t plain[CVOL_SCATTER_MAX];
            memcpy(plain, scatter, sizeof scatter);
            walk_reference(expected, scaled, extent, scan, &costs, plain);
            const size_t count = (size_t)extent - 1;
            kernels_expect_same(found->sums[1], expected->sums[1],
                                (count + 1) * sizeof found->sums[0], "costs of ways", set);
            kernels_expect_same(found->index[1], expected->index[1], count * sizeof found->index[0],
                                "indices", set);
            kernels_expect_same(found->near + 1, expected->near + 1, count * sizeof *found->near,
                                "sums before", set);
            kernels_expect_same(found->odd + 1, expected->odd + 1, count, "parities", set);
            kernels_expect_same(sums, plain, sizeof plain, "sums", set);
            kernels_check_guards(found, "trellis", set);
            kernels_check_guards(sums, "sums", set);
        }
    }
    kernels_free(sums);
    kernels_free(found);
    cvol_trellis_free(expected);
}

/* ---- cells that the volume ends in ----------------------------------------------------------- */

CVOL_SIMD_DECLARE(void, cvol_true_length_axes,
                  (double *, uint16_t *, const int *, uint16_t, const cvol_true_length_matrix *));
CVOL_SIMD_DECLARE(int, cvol_true_length_round,
                  (int32_t *, uint64_t *, const double *, const uint16_t *));
typedef void axes_function(double *, uint16_t *, const int *, uint16_t,
                           const cvol_true_length_matrix *);
typedef int round_function(int32_t *, uint64_t *, const double *, const uint16_t *);

/* The splits of the octants of both halves of an axis, at places of these parities on the other
 * axes, select the matrix of a line. */
static int way_of(uint16_t split, int axis, int first, int second)
{
    const int other[2] = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
    if (!(split & 1))
        return CVOL_TRUE_LENGTH_WHOLE;
    int way = CVOL_TRUE_LENGTH_HALVES;
    for (int half = 0; half < 2; half++) {
        const int octant = half << axis | (first & 1) << other[0] | (second & 1) << other[1];
        way += (split >> (1 + octant) & 1) << half;
    }
    return way;
}

/* Row (v, w) need not be zero. */
static int is_set(const uint16_t rows[N], int v, int w)
{
    return rows[w] >> v & 1;
}

/* True if the matrix of this line, or that of the line beside it along x, reaches place u. */
static int is_reached(const cvol_true_length_matrix *matrices, const int inside[3], uint16_t split,
                      int axis, int first, int second, int u)
{
    unsigned reached = 0;
    for (int parity = 0; parity < 2; parity++)
        reached |= matrices[CVOL_TRUE_LENGTH_WAYS * inside[axis] +
                            way_of(split, axis, (first & ~1) | parity, second)]
                       .reached;
    return reached >> u & 1;
}

static void axes_reference(double *cell, uint16_t rows[N], const int inside[3], uint16_t split,
                           const cvol_true_length_matrix *matrices)
{
    static const int strides[3] = {1, N, N * N};
    for (int axis = 0; axis < 3; axis++) {
        uint16_t after[N] = {0};
        if (inside[axis] == N)
            continue;
        for (int line = 0; line < N * N; line++) {
            const int first = line % N, second = line / N, s = strides[axis];
            double *at = cell + first * strides[axis == 0] + second * strides[axis == 2 ? 1 : 2];
            const cvol_true_length_matrix *by = &matrices[CVOL_TRUE_LENGTH_WAYS * inside[axis] +
                                                          way_of(split, axis, first, second)];
            double sums[N] = {0};
            int any = 0;
            for (int k = 0; k < N; k++) {
                const int x[3] = {axis == 0 ? k : first,
                                  axis == 1 ? k
                                  : axis    ? second
                                            : first,
                                  axis == 2 ? k : second};
                if (!is_set(rows, x[1], x[2]))
                    continue;
                any = 1;
                for (int u = 0; u < N && at[k * s] != 0; u++)
                    sums[u] += by->of[k][u] * at[k * s];
            }
            for (int u = 0; u < N && any; u++) {
                const int x[3] = {axis == 0 ? u : first,
                                  axis == 1 ? u
                                  : axis    ? second
                                            : first,
                                  axis == 2 ? u : second};
                at[u * s] = sums[u];
                if (axis == 0 || is_reached(matrices, inside, split, axis, first, second, u))
                    after[x[2]] = (uint16_t)(after[x[2]] | 1 << x[1]);
            }
        }
        memcpy(rows, after, sizeof after);
    }
}

static void shorter_axes_are_transformed(void **state)
{
    (void)state;
    axes_function *const sets[] = CVOL_SIMD_SETS(cvol_true_length_axes);
    static cvol_true_length_matrix matrices[N * CVOL_TRUE_LENGTH_WAYS];
    static double in[ALL], expected[ALL];
    double *cell = kernels_memory(sizeof in);
    for (uint64_t number = 0; number < 2 * CASES; number++) {
        random_state r = kernels_random(100 + number);
        uint16_t rows[N], after[N], own[N];
        int inside[3];
        for (int a = 0; a < 3; a++)
            inside[a] = random_below(&r, 3) ? 1 + (int)random_below(&r, N) : N;
        const uint16_t split = (uint16_t)(random_below(&r, 3) ? random_below(&r, 512) | 1 : 0);
        for (size_t m = 0; m < sizeof matrices / sizeof *matrices; m++) {
            matrices[m].reached = (uint16_t)(random_below(&r, 3) ? random_below(&r, 1 << 16)
                                                                 : 0xffff);
            for (int k = 0; k < N * N; k++) {
                const double number_there = random_signed(&r);
                matrices[m].of[k / N][k % N] = matrices[m].reached >> k % N & 1 ? number_there : 0;
            }
        }
        for (int w = 0; w < N; w++)
            rows[w] = (uint16_t)(random_below(&r, 3) ? random_below(&r, 1 << 16) : 0);
        for (int i = 0; i < ALL; i++) { /* NaN in places that are not read */
            in[i] = random_below(&r, 2) ? 1e4 * random_signed(&r) : 0;
            in[i] = is_set(rows, i / N % N, i / N / N) ? in[i] : (double)NAN;
        }
        memcpy(expected, in, sizeof in);
        memcpy(after, rows, sizeof rows);
        axes_reference(expected, after, inside, split, matrices);
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            memcpy(cell, in, sizeof in);
            memcpy(own, rows, sizeof rows);
            sets[set](cell, own, inside, split, matrices);
            assert_memory_equal(own, after, sizeof own);
            for (int i = 0; i < ALL; i++)
                if (is_set(after, i / N % N, i / N / N) && !(cell[i] == expected[i]))
                    fail_msg("shorter axes, %s, case %d: place %d is %.17g, not %.17g",
                             cvol_cpu_name((cvol_cpu)set), (int)number, i, cell[i], expected[i]);
            kernels_check_guards(cell, "shorter axes", set);
        }
    }
    kernels_free(cell);
}

static int round_reference(int32_t *values, uint64_t *found, const double *cell,
                           const uint16_t rows[N])
{
    int fits = 1;
    for (int i = 0; i < ALL; i++) {
        if (!is_set(rows, i / N % N, i / N / N))
            continue;
        const int small = fabs(cell[i]) <= CVOL_VALUE_LIMIT;
        values[i] = small ? (int32_t)rint(cell[i] - copysign(CVOL_TRUE_LENGTH_TIE_MARGIN, cell[i]))
                          : 0;
        found[i / 64] &= ~(UINT64_C(1) << i % 64);
        found[i / 64] |= (uint64_t)(values[i] != 0) << i % 64;
        fits &= small;
    }
    return fits;
}

static void terms_are_rounded(void **state)
{
    (void)state;
    round_function *const sets[] = CVOL_SIMD_SETS(cvol_true_length_round);
    static double cell[ALL];
    static int32_t expected[ALL];
    static uint64_t expected_found[ALL / 64];
    int32_t *values = kernels_memory(sizeof expected);
    uint64_t *found = kernels_memory(sizeof expected_found);
    int all_fit = 0;
    for (uint64_t number = 0; number < 2 * CASES; number++) {
        random_state r = kernels_random(200 + number);
        uint16_t rows[N];
        for (int w = 0; w < N; w++)
            rows[w] = (uint16_t)random_below(&r, 1 << 16);
        for (int i = 0; i < ALL; i++) {
            const double nearly[4] = {0.5 + 0x1p-10, -0.5 - 0x1p-10, 0.4999, -0.5};
            cell[i] = 3 * random_signed(&r);
            if (random_below(&r, 4) == 0)
                cell[i] = floor(1e3 * random_signed(&r)) + nearly[random_below(&r, 4)];
            if (number % 2 && random_below(&r, 3000) == 0)
                cell[i] = random_below(&r, 2) ? 0x1p30 * (1 + random_signed(&r)) : (double)NAN;
        }
        kernels_refill(values);
        kernels_refill(found);
        memcpy(expected, values, sizeof expected);
        memcpy(expected_found, found, sizeof expected_found);
        const int fits = round_reference(expected, expected_found, cell, rows);
        all_fit += fits;
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            kernels_refill(values);
            kernels_refill(found);
            assert_int_equal(sets[set](values, found, cell, rows), fits);
            kernels_expect_same(values, expected, sizeof expected, "rounded terms", set);
            kernels_expect_same(found, expected_found, sizeof expected_found, "their bits", set);
            kernels_check_guards(values, "rounded terms", set);
            kernels_check_guards(found, "their bits", set);
        }
    }
    assert_true(all_fit >= CASES && all_fit < 2 * CASES);
    kernels_free(found);
    kernels_free(values);
}

/* ---- the neural coder's transforms ----------------------------------------------------------- */

CVOL_SIMD_DECLARE(void, cvol_neural_inverse,
                  (int32_t * samples, const int32_t *known, const int n[3], int cube,
                   const cvol_neural_basis *basis));
CVOL_SIMD_DECLARE(void, cvol_neural_face,
                  (int32_t * level, int32_t *slope, const int32_t *near, const int32_t *far,
                   const int stride[2], const int n[2], const cvol_neural_basis *basis));
typedef void inverse_function(int32_t *, const int32_t *, const int *, int,
                              const cvol_neural_basis *);
typedef void face_function(int32_t *, int32_t *, const int32_t *, const int32_t *, const int *,
                           const int *, const cvol_neural_basis *);

static cvol_neural_basis basis;

/* Random entries, 0 beyond `n` frequencies and samples. */
static void make_basis(random_state *r)
{
    memset(&basis, 0, sizeof basis);
    for (int n = 1; n <= N; n++)
        for (int k = 0; k < n; k++)
            for (int x = 0; x < n; x++)
                basis.of[n][k][x] = (int32_t)(1024 * random_signed(r));
}

/* round(a / 2^10) of a number after overflow. */
static uint32_t rounded(uint32_t a)
{
    return (uint32_t)((int32_t)(a + 512) >> 10);
}

/* Along one axis of at[16][16][16]: `from` numbers become `to`, by basis[f][x], or, from samples to
 * frequencies, by its transpose. */
static void transform(uint32_t *at, int stride, int from, int to, int n, int is_forward)
{
    uint32_t out[N] = {0};
    for (int k = 0; k < from; k++)
        for (int x = 0; x < to; x++)
            out[x] += at[k * stride] *
                      (uint32_t)(is_forward ? basis.of[n][x][k] : basis.of[n][k][x]);
    for (int x = 0; x < to; x++)
        at[x * stride] = rounded(out[x]);
}

static void sub_blocks_are_predicted(void **state)
{
    (void)state;
    inverse_function *const sets[] = CVOL_SIMD_SETS(cvol_neural_inverse);
    enum { COUNT = N + CVOL_NEURAL_SIDE * N + CVOL_NEURAL_SLICE * N };
    static int32_t known[COUNT], expected[COUNT];
    static uint32_t cell[N * N * N];
    int32_t *samples = kernels_memory(sizeof expected);
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(300 + number);
        const int cube = 1 + (int)random_below(&r, N);
        int n[3], count[3];
        make_basis(&r);
        for (int a = 0; a < 3; a++) {
            n[a] = 1 + (int)random_below(&r, N);
            count[a] = cube < n[a] ? cube : n[a];
        }
        for (int i = 0; i < COUNT; i++) /* some so large that they overflow */
            known[i] = random_below(&r, 3) ? (int32_t)random_u64(&r) >> (number % 2 ? 2 : 20) : 0;
        memset(cell, 0, sizeof cell);
        for (int i = 0; i < N * N * N; i++)
            if (i % N < count[0] && i / N % N < count[1] && i / N / N < count[2])
                cell[i] = (uint32_t)known[i % N + CVOL_NEURAL_SIDE * (i / N % N) +
                                          CVOL_NEURAL_SLICE * (i / N / N)]
                          << 4;
        for (int line = 0; line < count[1] * count[2]; line++)
            transform(cell + N * (line % count[1]) + N * N * (line / count[1]), 1, count[0], n[0],
                      n[0], 0);
        for (int line = 0; line < n[0] * count[2]; line++)
            transform(cell + line % n[0] + N * N * (line / n[0]), N, count[1], n[1], n[1], 0);
        for (int line = 0; line < n[0] * n[1]; line++)
            transform(cell + line % n[0] + N * (line / n[0]), N * N, count[2], n[2], n[2], 0);
        kernels_refill(samples);
        memcpy(expected, samples, sizeof expected);
        for (int i = 0; i < N * N * N; i++)
            if (i % N < n[0] && i / N % N < n[1] && i / N / N < n[2])
                expected[i % N + CVOL_NEURAL_SIDE * (i / N % N) + CVOL_NEURAL_SLICE * (i / N / N)] =
                    (int32_t)cell[i];
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            kernels_refill(samples);
            sets[set](samples, known, n, cube, &basis);
            kernels_expect_same(samples, expected, sizeof expected, "foretold samples", set);
            kernels_check_guards(samples, "foretold samples", set);
        }
    }
    kernels_free(samples);
}

/* The DCT of plane[i][j], times 2^8, to[v + 16 w]. */
static void plane_reference(int32_t *to, uint32_t plane[N * N], const int n[2])
{
    for (int j = 0; j < n[1]; j++)
        transform(plane + j, N, n[0], n[0], n[0], 1);
    for (int v = 0; v < n[0]; v++)
        transform(plane + N * v, 1, n[1], n[1], n[1], 1);
    for (int v = 0; v < n[0]; v++)
        for (int w = 0; w < n[1]; w++)
            to[v + N * w] = (int32_t)(plane[N * v + w] << 8);
}

static void faces_are_transformed(void **state)
{
    (void)state;
    face_function *const sets[] = CVOL_SIMD_SETS(cvol_neural_face);
    enum { COUNT = 2 * CVOL_NEURAL_SLICE };
    static int32_t near[COUNT], far[COUNT], expected[2][N * N];
    static uint32_t planes[2][N * N];
    int32_t *level = kernels_memory(sizeof *expected), *slope = kernels_memory(sizeof *expected);
    for (uint64_t number = 0; number < 2 * CASES; number++) {
        random_state r = kernels_random(400 + number);
        static const int strides[3][2] = {{1, CVOL_NEURAL_SIDE}, {CVOL_NEURAL_SIDE, 1}, {3, 67}};
        const int *stride = strides[number % 3];
        const int n[2] = {1 + (int)random_below(&r, N), 1 + (int)random_below(&r, N)};
        make_basis(&r);
        for (int i = 0; i < COUNT; i++) {
            near[i] = (int32_t)random_u64(&r) >> (number % 2 ? 2 : 20);
            far[i] = (int32_t)random_u64(&r) >> (number % 2 ? 2 : 20);
        }
        for (int i = 0; i < n[0]; i++)
            for (int j = 0; j < n[1]; j++) {
                const int at = stride[0] * i + stride[1] * j;
                planes[0][N * i + j] = (uint32_t)near[at];
                planes[1][N * i + j] = (uint32_t)near[at] - (uint32_t)far[at];
            }
        kernels_refill(level);
        memcpy(expected[0], level, sizeof *expected);
        memcpy(expected[1], level, sizeof *expected);
        plane_reference(expected[0], planes[0], n);
        plane_reference(expected[1], planes[1], n);
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            kernels_refill(level);
            kernels_refill(slope);
            sets[set](level, slope, near, far, stride, n, &basis);
            kernels_expect_same(level, expected[0], sizeof *expected, "level of a face", set);
            kernels_expect_same(slope, expected[1], sizeof *expected, "slope of a face", set);
            kernels_check_guards(level, "level of a face", set);
            kernels_check_guards(slope, "slope of a face", set);
        }
    }
    kernels_free(level);
    kernels_free(slope);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(paths_have_the_lowest_cost),
        cmocka_unit_test(shorter_axes_are_transformed),
        cmocka_unit_test(terms_are_rounded),
        cmocka_unit_test(sub_blocks_are_predicted),
        cmocka_unit_test(faces_are_transformed),
    };
    kernels_begin();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
