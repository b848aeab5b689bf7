/* Split cells evaluate to the sums of their sub-blocks' cosines, on every view of the axes, at
 * samples and at fewer points, with the same bits on every instruction set. */
#include "test.h"

#include "array/block/block_inverse_steps.h"
#include "base/cpu.h"
#include "cvol/cvol.h"
#include "random.h"
#include "support_cells.h"
#include "support_split.h"
#include "transform/cell_points.h"

enum { CELL = 16, COUNT = CELL * CELL * CELL, WIDTH = CELL };

CVOL_SIMD_DECLARE(void, cvol_block_decode,
                  (float *out, const cvol_block *block, const cvol_block_axes *axes, int block_log2,
                   float step, cvol_block_work *work));

static float in[COUNT], out[COUNT] __attribute__((aligned(64)));
static uint32_t words[2 * COUNT];
static cvol_block_work work;

/* Any split: no octant, some, all. */
static uint16_t random_split(random_state *r)
{
    const uint32_t kind = random_below(r, 4);
    return (uint16_t)(1 | (kind == 0 ? 0 : kind == 1 ? 0x1fe : random_below(r, 256) << 1));
}

static cvol_block random_cell(random_state *r, float step)
{
    int low[3];
    for (int a = 0; a < 3; a++)
        low[a] = 1 + (int)random_below(r, CELL);
    const uint32_t one_of = random_below(r, 2) ? 4 : 1; /* many terms use another algorithm */
    memset(in, 0, sizeof in);
    cvol_block block = {.terms = words, .split = random_split(r)};
    for (uint32_t i = 0; i < COUNT; i++) {
        const int u = i % CELL, v = i / CELL % CELL, w = (int)i / CELL / CELL;
        if (u >= low[0] || v >= low[1] || w >= low[2] || random_below(r, one_of))
            continue;
        const int32_t value = (int32_t)(random_signed(r) * (random_below(r, 50) ? 50 : 5e7));
        if (!value)
            continue;
        block.words += cvol_term_pack(words + block.words, i, value, cvol_place_bits(4));
        in[i] = step * (float)value;
    }
    cvol_block_find_low(&block, 4);
    return block;
}

/* Index v of an axis at position `at` (samples from the cell's face on) in parts of this side. */
static double basis_at(int v, int side, double at)
{
    const int parts = CELL / side, half = v & 1;
    const int part = side == 8 ? half : 2 * half + (v >> 1 & 1), f = v / parts;
    const double local = at - part * side;
    if (local < 0 || local >= side)
        return 0;
    return sqrt((f ? 2.0 : 1.0) / side) * cos(M_PI * f * local / side);
}

/* The cell at places (i + 1/2) 16 / points of each axis of x, y, z, straight from the
 * definition. */
static double value_at(uint16_t split, const double at[3])
{
    double table[2][3][CELL], sum = 0;
    for (int kind = 0; kind < 2; kind++)
        for (int a = 0; a < 3; a++)
            for (int v = 0; v < CELL; v++)
                table[kind][a][v] = basis_at(v, kind ? 4 : 8, at[a]);
    for (int i = 0; i < COUNT; i++) {
        const int p[3] = {i % CELL, i / CELL % CELL, i / CELL / CELL};
        const int octant = (p[0] & 1) + 2 * (p[1] & 1) + 4 * (p[2] & 1);
        const int kind = split >> (1 + octant) & 1;
        sum += (double)in[i] * table[kind][0][p[0]] * table[kind][1][p[1]] * table[kind][2][p[2]];
    }
    return sum;
}

typedef struct view {
    cvol_block_axes axes;
    float lanes[2][CELL * WIDTH] __attribute__((aligned(64)));
    float rows[2][CELL * CELL], sheets[2][CELL * CELL];
} view;

static void make_view(view *v, int sheet_axis, const int points[3])
{
    memset(v, 0, sizeof *v);
    v->axes = (cvol_block_axes){.lane = sheet_axis == 0,
                                .row = sheet_axis == 2 ? 1 : 2,
                                .sheet = sheet_axis,
                                .lane_points = points[0],
                                .row_points = points[1],
                                .sheet_points = points[2]};
    for (int i = 0; i < 2; i++) {
        cvol_cell_points_basis(v->lanes[i], i ? 4 : 8, points[0], WIDTH);
        cvol_cell_points_basis(v->rows[i], i ? 4 : 8, points[1], points[1]);
        cvol_cell_points_basis(v->sheets[i], i ? 4 : 8, points[2], points[2]);
        v->axes.lane_parts[i] = v->lanes[i];
        v->axes.row_parts[i] = v->rows[i];
        v->axes.sheet_parts[i] = v->sheets[i];
    }
}

/* Zeroes the coefficients of the cell beyond these numbers of rows and slices, and as many in every
 * sub-block. */
static void leave_out(const cvol_block_axes *axes)
{
    const int most[2] = {(axes->row_points + 3) / 4 * 4, (axes->sheet_points + 3) / 4 * 4};
    for (int i = 0; i < COUNT; i++) {
        const int p[3] = {i % CELL, i / CELL % CELL, i / CELL / CELL};
        if (p[axes->row] >= most[0] || p[axes->sheet] >= most[1])
            in[i] = 0;
    }
}

static void check_view(uint64_t seed, int sheet_axis, const int points[3], int fewer)
{
    static view v;
    random_state r = {seed};
    const cvol_block block = random_cell(&r, 0.25f);
    make_view(&v, sheet_axis, points);
    v.axes.fewer = fewer;
    memset(out, 0, sizeof out);
    CVOL_SIMD_CHOOSE(cvol_block_decode)(out, &block, &v.axes, 4, 0.25f, &work);
    if (fewer)
        leave_out(&v.axes);
    double scale = 0, worst = 0;
    for (int i = 0; i < COUNT; i++)
        scale += fabs((double)in[i]) / 64;
    for (int attempt = 0; attempt < 24; attempt++) {
        int at[3];
        double place[3];
        const int axes[3] = {v.axes.lane, v.axes.row, v.axes.sheet};
        for (int a = 0; a < 3; a++) {
            at[a] = (int)random_below(&r, (uint32_t)points[a]);
            place[axes[a]] = (at[a] + 0.5) * CELL / points[a];
        }
        /* The order of lanes, rows and sheets is that of cvol_block_decode. */
        const double got = (double)out[at[0] + CELL * at[1] + CELL * CELL * at[2]];
        worst = fmax(worst, fabs(got - value_at(block.split, place)));
    }
    if (!(worst <= 1e-5 * fmax(scale, 1e-30))) {
        print_message("seed %llu: split %x, sheets along %d, %d x %d x %d places: error %g of %g\n",
                      (unsigned long long)seed, block.split, sheet_axis, points[0], points[1],
                      points[2], worst, scale);
        fail();
    }
}

static void cells_equal_sums_of_basis_functions(void **state)
{
    (void)state;
    static const int full[3] = {CELL, CELL, CELL};
    for (uint64_t seed = 1; seed <= 60; seed++)
        for (int axis = 0; axis < 3; axis++)
            check_view(seed, axis, full, 0);
}

static void cells_evaluate_at_fewer_points(void **state)
{
    (void)state;
    for (uint64_t seed = 1000; seed < 1120; seed++) {
        random_state r = {seed};
        int points[3];
        for (int a = 0; a < 3; a++)
            points[a] = 2 * (1 + (int)random_below(&r, CELL / 2));
        const int fewer = seed % 2;
        if (!fewer)
            points[2] = CELL;
        check_view(seed, (int)random_below(&r, 3), points, fewer);
    }
}

#if defined(__x86_64__)
static void every_instruction_set_gives_the_same_bits(void **state)
{
    (void)state;
    typedef void decode(float *, const cvol_block *, const cvol_block_axes *, int, float,
                        cvol_block_work *);
    decode *const decoders[] = CVOL_SIMD_SETS(cvol_block_decode);
    static float other[COUNT] __attribute__((aligned(64)));
    static view v;
    static const int full[3] = {CELL, CELL, CELL};
    for (uint64_t seed = 1; seed <= 40; seed++) {
        random_state r = {seed};
        const cvol_block block = random_cell(&r, 0.3f);
        make_view(&v, (int)(seed % 3), full);
        decoders[0](out, &block, &v.axes, 4, 0.3f, &work);
        for (int set = 1; set <= (int)cvol_cpu_best(); set++) {
            decoders[set](other, &block, &v.axes, 4, 0.3f, &work);
            assert_memory_equal(out, other, sizeof out);
        }
    }
}
#endif

/* ---- the algebra ----------------------------------------------------------------------------- */

static const size_t dims[3] = {40, 33, 17};
enum { SAMPLES = 40 * 33 * 17 };

static cvol_array *random_array(cvol_context *context, random_state *r, int is_split)
{
    static float samples[SAMPLES];
    const cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_FLOAT32);
    const cvol_keep all = cvol_keep_all();
    cvol_array *array;
    for (int i = 0; i < SAMPLES; i++)
        samples[i] = (float)(2 + random_signed(r) + sin(0.3 * (i % 40)));
    assert_int_equal(cvol_array_compress(context, &array, samples, &grid, 3, CVOL_DCT, 16, &all),
                     0);
    if (is_split)
        support_split_cells(context, array, random_u64(r));
    return array;
}

static void expect_near(cvol_context *context, const cvol_array *got, const cvol_array *expected)
{
    static float x[SAMPLES], y[SAMPLES];
    const size_t begin[3] = {0, 0, 0};
    assert_int_equal(cvol_array_evaluate_real(context, x, got, begin, dims), 0);
    assert_int_equal(cvol_array_evaluate_real(context, y, expected, begin, dims), 0);
    double apart = 0, size = 0;
    for (int i = 0; i < SAMPLES; i++) {
        apart = fmax(apart, fabs((double)x[i] - (double)y[i]));
        size = fmax(size, fabs((double)y[i]));
    }
    assert_true(apart <= 1e-5 * size);
}

/* Two operands may each be split or not: all four combinations give the result of whole cells. */
static void operations_accept_split_cells(void **state)
{
    (void)state;
    cell_operation *const operations[] = {cell_add,          cell_multiply, cell_scale,
                                          cell_truncate_all, cell_filter,   cell_gradient};
    cvol_context *context = cvol_context_create();
    assert_non_null(context);
    for (uint64_t seed = 1; seed <= 4; seed++)
        for (int way = 1; way < 4; way++) {
            random_state first = {seed}, second = {seed};
            cvol_array *whole[2], *cells[2];
            for (int i = 0; i < 2; i++) {
                whole[i] = random_array(context, &first, 0);
                cells[i] = random_array(context, &second, way >> i & 1);
                if (way >> i & 1)
                    (void)random_u64(&first);
            }
            for (size_t k = 0; k < sizeof operations / sizeof *operations; k++) {
                cvol_array *got, *expected;
                assert_int_equal(operations[k](context, &got, cells[0], cells[1]), 0);
                assert_int_equal(operations[k](context, &expected, whole[0], whole[1]), 0);
                expect_near(context, got, expected);
                cvol_array_free(got);
                cvol_array_free(expected);
            }
            cvol_array_statistics got, expected;
            assert_int_equal(cvol_array_compute_statistics(context, &got, cells[0]), 0);
            assert_int_equal(cvol_array_compute_statistics(context, &expected, whole[0]), 0);
            assert_true(fabs(got.sum - expected.sum) <= 1e-5 * fabs(expected.sum));
            assert_true(fabs(got.l2_norm - expected.l2_norm) <= 1e-5 * expected.l2_norm);
            cvol_array_comparison near, wanted;
            assert_int_equal(cvol_array_compare(context, &near, cells[0], cells[1]), 0);
            assert_int_equal(cvol_array_compare(context, &wanted, whole[0], whole[1]), 0);
            assert_true(fabs(near.inner_product - wanted.inner_product) <=
                        1e-5 * fabs(wanted.inner_product));
            assert_true(fabs(near.distance - wanted.distance) <= 1e-4 * wanted.distance);
            for (int i = 0; i < 2; i++) {
                cvol_array_free(whole[i]);
                cvol_array_free(cells[i]);
            }
        }
    cvol_context_free(context);
}

static void files_round_trip(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    random_state r = {1};
    cvol_array *array = random_array(context, &r, 1), *read;
    assert_int_equal(cvol_array_write(context, array, "split.cvol", NULL), CVOL_OK);
    assert_int_equal(cvol_array_read(context, &read, "split.cvol", NULL), CVOL_OK);
    assert_true(cvol_array_has_splits(read));
    expect_near(context, read, array);
    remove("split.cvol");
    cvol_array_free(read);
    cvol_array_free(array);
    cvol_context_free(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cells_equal_sums_of_basis_functions),
        cmocka_unit_test(cells_evaluate_at_fewer_points),
        cmocka_unit_test(operations_accept_split_cells),
        cmocka_unit_test(files_round_trip),
#if defined(__x86_64__)
        cmocka_unit_test(every_instruction_set_gives_the_same_bits),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
