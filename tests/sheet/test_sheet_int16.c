/* int16 samples equal the float ones, rounded: evaluated on every view of the axes, at samples and
 * at fewer points, of whole blocks and of split cells; filtered across faces; with a background.
 * For every instruction set. */
#include "test.h"

#include "array/core/array.h"
#include "base/cpu.h"
#include "random.h"
#include "render/sheet/frame/frame.h"
#include "render/sheet/frame/level.h"
#include "render/sheet/frame/mask.h"
#include "support_kernels.h"
#include "transform/cell_points.h"

enum { MOST = 32, COUNT = MOST * MOST * MOST, SQUARE = MOST * MOST, ROW = 48, SHEET = ROW * 34 };

static const cvol_int16_scale int16 = {70, 9000};

static float floats[SHEET * MOST] __attribute__((aligned(64)));
static int16_t found[SHEET * MOST] __attribute__((aligned(64)));
static uint32_t words[2 * COUNT];
static cvol_block_work work;

#define EACH_SET(set) (int set = 0; set <= (int)cvol_cpu_best(); set++)

static double word_of(double value)
{
    return fmin(fmax(value * (double)int16.scale + (double)int16.offset, 0), CVOL_INT16_MAX);
}

/* Fails if an int16 sample is not its float, rounded, up to `error`. */
static void compare(const char *what, uint64_t seed, double error)
{
    for (int i = 0; i < SHEET * MOST; i++) {
        const double apart = fabs(found[i] - word_of((double)floats[i]));
        if (!(apart <= error)) {
            print_message("%s, seed %llu: word %d is %d, not %g\n", what, (unsigned long long)seed,
                          i, found[i], word_of((double)floats[i]));
            fail();
        }
    }
}

/* ---- evaluation ------------------------------------------------------------------------------ */

/* Some terms of a block, most of them low ones; samples of some hundreds, a few of them out of
 * range. */
static cvol_block random_block(random_state *r, int block_log2, int is_split)
{
    const int B = 1 << block_log2;
    uint32_t low[3];
    cvol_block block = {.terms = words};
    for (int a = 0; a < 3; a++)
        low[a] = 1 + random_below(r, (uint32_t)B);
    const uint32_t one_of = random_below(r, 2) ? 5 : 1; /* many terms use another algorithm */
    if (is_split)
        block.split = (uint16_t)(1 | (random_below(r, 4) ? random_below(r, 256) << 1 : 0x1fe));
    for (uint32_t i = 0; i < (uint32_t)(B * B * B); i++) {
        const uint32_t u = i % (uint32_t)B, v = i / (uint32_t)B % (uint32_t)B,
                       w = i / (uint32_t)(B * B);
        if (u >= low[0] || v >= low[1] || w >= low[2] || random_below(r, one_of))
            continue;
        const int32_t value = (int32_t)(random_signed(r) * 30000 / (3 + u + v + w));
        block.words += value ? cvol_term_pack(words + block.words, i, value,
                                              cvol_place_bits(block_log2))
                             : 0;
    }
    cvol_block_find_low(&block, block_log2);
    return block;
}

static void make_axes(cvol_block_axes *axes, int B, int sheet_axis, const int points[3])
{
    static float bases[9][SQUARE] __attribute__((aligned(64)));
    *axes = (cvol_block_axes){.lane = sheet_axis == 0,
                              .row = sheet_axis == 2 ? 1 : 2,
                              .sheet = sheet_axis,
                              .lane_points = points[0],
                              .row_points = points[1],
                              .sheet_points = points[2],
                              .lane_basis = bases[0],
                              .row_basis = bases[1],
                              .sheet_basis = bases[2],
                              .lane_parts = {bases[3], bases[4]},
                              .row_parts = {bases[5], bases[6]},
                              .sheet_parts = {bases[7], bases[8]}};
    cvol_sheet_basis(bases[0], B, points[0], B < 16 ? 16 : B);
    cvol_sheet_basis(bases[1], B, points[1], points[1]);
    cvol_sheet_basis(bases[2], B, points[2], points[2]);
    for (int i = 0; i < 2 && B == 16; i++) {
        cvol_cell_points_basis(bases[3 + i], i ? 4 : 8, points[0], B);
        cvol_cell_points_basis(bases[5 + i], i ? 4 : 8, points[1], points[1]);
        cvol_cell_points_basis(bases[7 + i], i ? 4 : 8, points[2], points[2]);
    }
}

static void check_block(uint64_t seed, int block_log2, int is_split, int all)
{
    typedef void evaluator(int16_t *, long, long, const cvol_block *, const cvol_block_axes *, int,
                           float, const cvol_int16_scale *, cvol_block_work *);
    evaluator *const sets[] = CVOL_SIMD_SETS(cvol_sheet_evaluate_int16);
    const int B = 1 << block_log2;
    random_state r = {seed};
    const cvol_block block = random_block(&r, block_log2, is_split);
    int points[3];
    cvol_block_axes axes;
    for (int a = 0; a < 3; a++)
        points[a] = all ? B : B / 2 + 2 * (int)random_below(&r, (uint32_t)B / 4 + 1);
    make_axes(&axes, B, (int)random_below(&r, 3), points);
    axes.sheet_ends = points[2] == 16 && random_below(&r, 4) == 0 ? 1 + (int)random_below(&r, 3)
                                                                  : 0;
    memset(floats, 0, sizeof floats);
    CVOL_SIMD_CHOOSE(cvol_sheet_evaluate)
    (floats, ROW, SHEET, &block, &axes, block_log2, 0.25f, &work);
    for (int i = 0; i < SHEET * MOST; i++) {
        const int sheet = i / SHEET, row = i % SHEET / ROW, lane = i % ROW;
        const int is_unwanted = (axes.sheet_ends == 1 && sheet > 1) ||
                                (axes.sheet_ends == 2 && sheet < 14) ||
                                (axes.sheet_ends == 3 && sheet > 1 && sheet < 14);
        if (lane >= points[0] || row >= points[1] || sheet >= points[2] || is_unwanted)
            floats[i] = NAN;
    }
    for
        EACH_SET(set)
        {
            memset(found, 0x55, sizeof found);
            sets[set](found, ROW, SHEET, &block, &axes, block_log2, 0.25f, &int16, &work);
            for (int i = 0; i < SHEET * MOST; i++)
                if (isnan(floats[i])) {
                    const int sheet = i / SHEET, row = i % SHEET / ROW, lane = i % ROW;
                    if (lane >= points[0] || row >= points[1] || sheet >= points[2])
                        assert_int_equal(found[i], 0x5555);
                    found[i] = 0; /* the value in place of NaN */
                }
            compare("block", seed, 0.52);
        }
}

static void blocks_are_rounded(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 60; seed++)
        check_block(seed, 3 + (int)(seed % 3), 0, seed % 2 == 0);
}

static void split_cells_are_rounded(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 60; seed++)
        check_block(seed, 4, 1, seed % 2 == 0);
}

/* ---- operations on samples ------------------------------------------------------------------- */

/* int16 samples, and the floats that they represent; some of these are at the ends of the range. */
static void fill_random(random_state *r)
{
    for (int i = 0; i < SHEET * MOST; i++) {
        const uint32_t kind = random_below(r, 20);
        found[i] = (int16_t)(kind == 0   ? 0
                             : kind == 1 ? CVOL_INT16_MAX
                                         : random_below(r, CVOL_INT16_MAX));
        floats[i] = ((float)found[i] - int16.offset) / int16.scale;
    }
}

static void faces_are_filtered(void **state)
{
    (void)state;
    typedef void lanes(int16_t *, long, long, int, int, const float *);
    typedef void across(int16_t *const *, long, int, int, const float *);
    lanes *const of_lanes[] = CVOL_SIMD_SETS(cvol_sheet_lap_lanes_int16);
    across *const of_others[] = CVOL_SIMD_SETS(cvol_sheet_lap_across_int16);
    const float h[4] = {0.31f, -0.12f, 0.07f, 0.45f};
    for
        EACH_SET(set)
    for (int attempt = 0; attempt < 12; attempt++) {
        random_state r = {100 + (uint64_t)attempt};
        const long at = 16 + 2 * attempt + 3L * ROW;
        const int rows = 16 - attempt, columns = 30 - 2 * attempt;
        fill_random(&r);
        CVOL_SIMD_CHOOSE(cvol_sheet_lap_lanes)(floats + at, ROW, SHEET, rows, 9, h);
        of_lanes[set](found + at, ROW, SHEET, rows, 9, h);
        compare("lanes", r.state, 0.52);
        fill_random(&r);
        float *a[4];
        int16_t *b[4];
        for (int k = 0; k < 4; k++) {
            a[k] = floats + at + (k + attempt) * SHEET;
            b[k] = found + at + (k + attempt) * SHEET;
        }
        CVOL_SIMD_CHOOSE(cvol_sheet_lap_across)(a, ROW, columns, rows, h);
        of_others[set](b, ROW, columns, rows, h);
        compare("across", r.state, 0.52);
    }
}

static void samples_are_bounded(void **state)
{
    (void)state;
    typedef void clamp(int16_t *, long, long, int, int, int, int16_t, int16_t);
    clamp *const sets[] = CVOL_SIMD_SETS(cvol_sheet_clamp_int16);
    for
        EACH_SET(set)
    for (int columns = 8; columns <= 16; columns += 2) {
        random_state r = {7};
        fill_random(&r);
        CVOL_SIMD_CHOOSE(cvol_sheet_clamp)(floats + 32, ROW, SHEET, columns, 5, 3, -50, 130);
        sets[set](found + 32, ROW, SHEET, columns, 5, 3, cvol_int16_scale_of(&int16, -50),
                  cvol_int16_scale_of(&int16, 130));
        compare("bounded", 7, 0.52);
    }
}

static void masked_samples_are_filled(void **state)
{
    (void)state;
    typedef void lay(int16_t *, long, long, int, int, int, const uint16_t *, int, int, int16_t);
    typedef void points_lay(const cvol_sheet_piece *, const cvol_mask_grid *, int16_t);
    lay *const sets[] = CVOL_SIMD_SETS(cvol_sheet_fill_masked_int16);
    points_lay *const point_sets[] = CVOL_SIMD_SETS(cvol_sheet_fill_masked_points_int16);
    const float background = -20;
    const int16_t word = cvol_int16_scale_of(&int16, background);
    uint16_t bits[2 * SQUARE];
    for
        EACH_SET(set)
    for (int block = 8; block <= 32; block *= 2) {
        const int of_row = (block + 15) / 16;
        random_state r = {(uint64_t)block};
        for (int i = 0; i < 2 * SQUARE; i++)
            bits[i] = (uint16_t)(random_below(&r, 0x10000) & (block == 8 ? 0xff : 0xffff) &
                                 (random_below(&r, 2) ? 0 : 0xffff));
        fill_random(&r);
        CVOL_SIMD_CHOOSE(cvol_sheet_fill_masked)
        (floats, ROW, SHEET, block, block, block, bits, of_row, of_row * block, background);
        sets[set](found, ROW, SHEET, block, block, block, bits, of_row, of_row * block, word);
        compare("background", (uint64_t)block, 0.52);

        cvol_sheet_plan plan = {
            .points_lane = block / 2 + 2, .points_row = block / 2, .points_sheet = block};
        plan.pitch_lane = (double)block / plan.points_lane;
        plan.pitch_row = (double)block / plan.points_row;
        plan.pitch_sheet = 1;
        plan.first_lane = (plan.pitch_lane - 1) / 2;
        plan.first_row = (plan.pitch_row - 1) / 2;
        cvol_mask_points points[3];
        cvol_mask_points_find(points, &plan, block);
        const cvol_mask_grid grid = {bits,       of_row,     of_row * block, block,
                                     &points[0], &points[1], &points[2]};
        cvol_sheet_piece piece = {floats, ROW, SHEET, 0, plan.points_row, 0, block};
        fill_random(&r);
        CVOL_SIMD_CHOOSE(cvol_sheet_fill_masked_points)(&piece, &grid, background);
        piece.at = found;
        point_sets[set](&piece, &grid, word);
        compare("points of a background", (uint64_t)block, 1.02);
    }
}

static void levels_are_copied(void **state)
{
    (void)state;
    typedef void copy(int16_t *, long, long, const float *, long, long, const cvol_int16_scale *);
    copy *const sets[] = CVOL_SIMD_SETS(cvol_sheet_copy_int16);
    static float level[2 * CVOL_LEVEL_BLOCK_SAMPLES];
    random_state r = {5};
    for (int i = 0; i < 2 * CVOL_LEVEL_BLOCK_SAMPLES; i++)
        level[i] = (float)(400 * random_signed(&r));
    for (int axis = 0; axis < 3; axis++) {
        const cvol_sheet_plan plan = {.axis_lane = axis == 0,
                                      .axis_row = axis == 2 ? 1 : 2,
                                      .axis_sheet = axis,
                                      .int16 = int16};
        fill_random(&r);
        cvol_sheet_level_copy(floats, ROW, SHEET, level, 1, &plan);
        cvol_sheet_level_copy_int16(found, ROW, SHEET, level, 1, &plan);
        compare("level", (uint64_t)axis, 0.52);
    }
    for
        EACH_SET(set)
        {
            fill_random(&r);
            const cvol_sheet_plan plan = {.axis_row = 1, .axis_sheet = 2};
            cvol_sheet_level_copy(floats, ROW, SHEET, level, 0, &plan);
            sets[set](found, ROW, SHEET, level, 16, 256, &int16);
            compare("copy", (uint64_t)set, 0.52);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_are_rounded),        cmocka_unit_test(split_cells_are_rounded),
        cmocka_unit_test(faces_are_filtered),        cmocka_unit_test(samples_are_bounded),
        cmocka_unit_test(masked_samples_are_filled), cmocka_unit_test(levels_are_copied),
    };
    kernels_print_sets();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
