/* Kernels that make a layer's samples of the sheet engine: each against its formula in double
 * precision on random data, by every instruction set. test_sheet_int16.c compares the int16 kernels
 * with these, and test_kernels_lines.c tests kernels that draw lines.
 *
 * u = 2^-24 is the unit of rounding. A sum of n products of floats is off by at most n u times the
 * sum of the products' magnitudes, in any order, with fused multiply-add or without. Memory that a
 * kernel does not write keeps its bits.
 */
#include "test.h"

#include "array/core/array.h"
#include "base/cpu.h"
#include "render/sheet/band/extreme.h"
#include "render/sheet/frame/frame.h"
#include "render/sheet/frame/mask.h"
#include "support_kernels.h"
#include "transform/cell_points.h"

enum { CASES = 30, MOST = 32, ROW = 50, SHEET = ROW * 34, ALL = SHEET * MOST };

#define UNIT 0x1p-24

static float before[ALL];
static double expected[ALL], error[ALL];

/* Random samples, which must stay unchanged. */
static void begin(random_state *r)
{
    for (int i = 0; i < ALL; i++) {
        before[i] = (float)(100 * random_signed(r));
        expected[i] = (double)before[i];
        error[i] = 0;
    }
}

/* ---- evaluation ------------------------------------------------------------------------------ */

typedef void evaluate_function(float *, long, long, const cvol_block *, const cvol_block_axes *,
                               int, float, cvol_block_work *);

static uint32_t words[2 * MOST * MOST * MOST];
static double values[MOST * MOST * MOST], sizes[MOST * MOST * MOST];

/* A matrix [frequency][point] of an axis. */
typedef struct axis_basis {
    const float *of;
    int stride, points;
} axis_basis;

static float bases[9][MOST * MOST] __attribute__((aligned(64)));

static void make_axes(cvol_block_axes *axes, int B, int sheet_axis, const int points[3])
{
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
    const int strides[3] = {B < 16 ? 16 : B, points[1], points[2]};
    for (int a = 0; a < 3; a++) {
        cvol_sheet_basis(bases[a], B, points[a], strides[a]);
        for (int i = 0; i < 2 && B == 16; i++)
            cvol_cell_points_basis(bases[3 + 2 * a + i], i ? 4 : 8, points[a], strides[a]);
    }
}

static cvol_block random_block(random_state *r, int block_log2, int is_split)
{
    const int B = 1 << block_log2;
    cvol_block block = {.terms = words};
    int low[3];
    for (int a = 0; a < 3; a++)
        low[a] = 1 + (int)random_below(r, (uint32_t)B);
    const uint32_t one_of = random_below(r, 2) ? 5 : 1; /* many terms use another algorithm */
    if (is_split)
        block.split = (uint16_t)(1 | random_below(r, 256) << 1);
    for (int i = 0; i < B * B * B; i++) {
        int32_t value = (int32_t)(100 * random_signed(r));
        if (i % B >= low[0] || i / B % B >= low[1] || i / B / B >= low[2] ||
            random_below(r, one_of) || !value)
            continue;
        value *= random_below(r, 400) ? 1 : 1000000; /* an escape */
        block.words += cvol_term_pack(words + block.words, (uint32_t)i, value,
                                      cvol_place_bits(block_log2));
    }
    cvol_block_find_low(&block, block_log2);
    return block;
}

/* data[..][f][..] becomes data[..][point][..] along one axis; `are_sizes`: of magnitudes. A cosine
 * that should be 0 is only nearly 0, and may have the other sign at a mirrored point. */
static void transform_axis(double *data, int stride, const axis_basis *by, int B, int are_sizes)
{
    double in[MOST];
    for (int first = 0; first < B * B * B; first++) {
        if (first / stride % B)
            continue;
        for (int f = 0; f < B; f++)
            in[f] = data[first + f * stride];
        for (int i = 0; i < by->points; i++) {
            double sum = 0;
            for (int f = 0; f < B; f++) {
                const double c = (double)by->of[f * by->stride + i];
                sum += (are_sizes ? fabs(c) + 1e-9 : c) * in[f];
            }
            data[first + i * stride] = sum;
        }
    }
}

/* The frequencies of an axis that are summed. */
static int frequencies(const cvol_block_axes *axes, const cvol_block *block, int points, int axis)
{
    const int room = block->split ? (points + 3) / 4 * 4 : points, low = block->low[axis];
    return axes->fewer && room < low ? room : low;
}

/* Adds the sum of the terms of one octant (-1: a whole block) at the points. */
static void evaluate_octant(double *to, const cvol_block *block, const cvol_block_axes *axes,
                            int block_log2, double step, int octant, int are_sizes)
{
    static double data[MOST * MOST * MOST];
    const int B = 1 << block_log2, fours = octant >= 0 && block->split >> (1 + octant) & 1;
    const int view[3] = {axes->lane, axes->row, axes->sheet};
    const int points[3] = {axes->lane_points, axes->row_points, axes->sheet_points};
    const uint32_t *next = block->terms, *end = cvol_block_end(block);
    memset(data, 0, sizeof data);
    while (next < end) {
        uint32_t place;
        const int32_t value = cvol_term_unpack(&next, &place, cvol_place_bits(block_log2));
        const int at[3] = {(int)place % B, (int)place / B % B, (int)place / B / B};
        const int own = (at[0] & 1) + 2 * (at[1] & 1) + 4 * (at[2] & 1);
        if ((octant >= 0 && own != octant) ||
            at[axes->row] >= frequencies(axes, block, points[1], axes->row) ||
            at[axes->sheet] >= frequencies(axes, block, points[2], axes->sheet))
            continue;
        data[place] = step * (are_sizes ? abs(value) : value);
    }
    for (int a = 0; a < 3; a++) {
        const axis_basis by = {octant < 0 ? bases[a] : bases[3 + 2 * a + fours],
                               a == 0 ? (B < 16 ? 16 : B) : points[a], points[a]};
        transform_axis(data, 1 << block_log2 * view[a], &by, B, are_sizes);
    }
    for (int i = 0; i < B * B * B; i++)
        to[i] += data[i];
}

static void evaluate_reference(const cvol_block *block, const cvol_block_axes *axes, int block_log2,
                               double step)
{
    const int B = 1 << block_log2;
    memset(values, 0, sizeof values);
    memset(sizes, 0, sizeof sizes);
    for (int octant = block->split ? 0 : -1; octant < (block->split ? 8 : 0); octant++) {
        evaluate_octant(values, block, axes, block_log2, step, octant, 0);
        evaluate_octant(sizes, block, axes, block_log2, step, octant, 1);
    }
    for (int z = 0; z < axes->sheet_points; z++)
        for (int y = 0; y < axes->row_points; y++)
            for (int x = 0; x < axes->lane_points; x++) {
                const int from = (x << block_log2 * axes->lane) + (y << block_log2 * axes->row) +
                                 (z << block_log2 * axes->sheet);
                const int unwanted = (axes->sheet_ends == 1 && z > 1) ||
                                     (axes->sheet_ends == 2 && z < 14) ||
                                     (axes->sheet_ends == 3 && z > 1 && z < 14);
                expected[SHEET * z + ROW * y + x] = values[from];
                /* B products along each axis, and the step. */
                error[SHEET * z + ROW * y + x] = unwanted ? (double)INFINITY
                                                          : (3 * B + 3) * UNIT * sizes[from];
            }
}

static void blocks_are_evaluated(void **state)
{
    (void)state;
    evaluate_function *const sets[] = CVOL_SIMD_SETS(cvol_sheet_evaluate);
    static cvol_block_work work;
    float *out = kernels_memory(sizeof before);
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(number);
        const int is_split = number % 4 == 3, block_log2 = is_split ? 4 : 3 + (int)number % 4;
        const int B = 1 << block_log2;
        const cvol_block block = random_block(&r, block_log2, is_split);
        cvol_block_axes axes;
        int points[3];
        for (int a = 0; a < 3; a++)
            points[a] = number / 4 % 2 ? B : B / 2 + 2 * (int)random_below(&r, (uint32_t)B / 4 + 1);
        make_axes(&axes, B, (int)random_below(&r, 3), points);
        axes.sheet_ends = points[2] == 16 ? (int)random_below(&r, 4) : 0;
        axes.fewer = (int)random_below(&r, 2);
        begin(&r);
        evaluate_reference(&block, &axes, block_log2, 0.25);
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            memcpy(out, before, sizeof before);
            sets[set](out, ROW, SHEET, &block, &axes, block_log2, 0.25f, &work);
            kernels_expect_near(out, expected, error, ALL, "evaluated block", set);
            kernels_check_guards(out, "evaluated block", set);
        }
    }
    kernels_free(out);
}

/* ---- the filter across faces ----------------------------------------------------------------- */

typedef void lanes_function(float *, long, long, int, int, const float[4]);
typedef void across_function(float *const[4], long, int, int, const float[4]);
typedef void clamp_function(float *, long, long, int, int, int, float, float);

static const float h[4] = {0.31f, -0.12f, 0.07f, 0.45f};

/* Filters the four samples at `at`; an output is made of seven operations on numbers of at most
 * the sum of the four. */
static void filter_reference(const int at[4])
{
    double a[4], d[2], size = 0;
    for (int k = 0; k < 4; k++) {
        a[k] = expected[at[k]];
        size += fabs(a[k]);
    }
    const double w[2] = {a[1] - a[2], a[0] - a[3]};
    for (int k = 0; k < 2; k++)
        d[k] = (double)h[2 * k] * w[0] + (double)h[2 * k + 1] * w[1];
    expected[at[1]] += d[0];
    expected[at[2]] -= d[0];
    expected[at[0]] += d[1];
    expected[at[3]] -= d[1];
    for (int k = 0; k < 4; k++)
        error[at[k]] = 7 * UNIT * size;
}

static void faces_between_lanes_are_filtered(void **state)
{
    (void)state;
    lanes_function *const sets[] = CVOL_SIMD_SETS(cvol_sheet_lap_lanes);
    float *out = kernels_memory(sizeof before);
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(100 + number);
        const int rows = 1 + (int)random_below(&r, 20), sheets = 1 + (int)random_below(&r, 20);
        const int a2 = 2 + (int)random_below(&r, ROW - 4) + ROW * (int)random_below(&r, 10);
        begin(&r);
        for (int z = 0; z < sheets; z++)
            for (int y = 0; y < rows; y++) {
                const int at = a2 + SHEET * z + ROW * y;
                filter_reference((const int[4]){at - 2, at - 1, at, at + 1});
            }
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            memcpy(out, before, sizeof before);
            sets[set](out + a2, ROW, SHEET, rows, sheets, h);
            kernels_expect_near(out, expected, error, ALL, "faces between lanes", set);
            kernels_check_guards(out, "faces between lanes", set);
        }
    }
    kernels_free(out);
}

static void other_faces_are_filtered(void **state)
{
    (void)state;
    across_function *const sets[] = CVOL_SIMD_SETS(cvol_sheet_lap_across);
    float *out = kernels_memory(sizeof before);
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(200 + number);
        const int columns = 1 + (int)random_below(&r, 31), lines = 1 + (int)random_below(&r, 20);
        const int first = (int)random_below(&r, ROW - 32) + ROW * (int)random_below(&r, 10);
        const int apart = random_below(&r, 2) ? SHEET : 2 * SHEET; /* any order is valid */
        begin(&r);
        for (int y = 0; y < lines; y++)
            for (int x = 0; x < columns; x++) {
                const int at = first + ROW * y + x;
                filter_reference((const int[4]){at + apart, at, at + 2 * apart, at + 3 * apart});
            }
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            float *const at[4] = {out + first + apart, out + first, out + first + 2 * apart,
                                  out + first + 3 * apart};
            memcpy(out, before, sizeof before);
            sets[set](at, ROW, columns, lines, h);
            kernels_expect_near(out, expected, error, ALL, "other faces", set);
            kernels_check_guards(out, "other faces", set);
        }
    }
    kernels_free(out);
}

static void samples_are_bounded(void **state)
{
    (void)state;
    clamp_function *const sets[] = CVOL_SIMD_SETS(cvol_sheet_clamp);
    float *out = kernels_memory(sizeof before);
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(300 + number);
        const int columns = 1 + (int)random_below(&r, 31), rows = 1 + (int)random_below(&r, 20),
                  sheets = 1 + (int)random_below(&r, 20), first = (int)random_below(&r, 19);
        begin(&r);
        for (int z = 0; z < sheets; z++)
            for (int y = 0; y < rows; y++)
                for (int x = 0; x < columns; x++) {
                    double *at = &expected[first + SHEET * z + ROW * y + x];
                    *at = *at < -40 ? -40 : *at > 60 ? 60 : *at;
                }
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            memcpy(out, before, sizeof before);
            sets[set](out + first, ROW, SHEET, columns, rows, sheets, -40, 60);
            kernels_expect_near(out, expected, error, ALL, "bounds", set);
            kernels_check_guards(out, "bounds", set);
        }
    }
    kernels_free(out);
}

/* ---- masked samples -------------------------------------------------------------------------- */

typedef void fill_masked_function(float *, long, long, int, int, int, const uint16_t *, int, int,
                                  float);
typedef void cover_function(const cvol_sheet_piece *, const cvol_mask_grid *);
typedef void points_function(const cvol_sheet_piece *, const cvol_mask_grid *, float);

static uint16_t bits[2 * MOST * MOST];

/* Rows of bits; of blocks of 8 the upper half of a word is 0. */
static void make_bits(random_state *r, int block)
{
    for (int i = 0; i < 2 * MOST * MOST; i++) {
        const uint32_t some = random_below(r, 0x10000) & (block == 8 ? 0xff : 0xffff);
        bits[i] = (uint16_t)(random_below(r, 2) ? some : 0);
    }
}

static void masked_samples_are_filled(void **state)
{
    (void)state;
    fill_masked_function *const sets[] = CVOL_SIMD_SETS(cvol_sheet_fill_masked);
    float *out = kernels_memory(sizeof before);
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(400 + number);
        const int block = 8 << number % 3, of_row = (block + 15) / 16;
        const int rows = 1 + (int)random_below(&r, (uint32_t)block),
                  sheets = 1 + (int)random_below(&r, (uint32_t)block),
                  first = (int)random_below(&r, ROW - MOST);
        make_bits(&r, block);
        begin(&r);
        for (int z = 0; z < sheets; z++)
            for (int y = 0; y < rows; y++)
                for (int x = 0; x < block; x++)
                    if (bits[(z * block + y) * of_row + x / 16] >> x % 16 & 1)
                        expected[first + SHEET * z + ROW * y + x] = -20;
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            memcpy(out, before, sizeof before);
            sets[set](out + first, ROW, SHEET, rows, sheets, block, bits, of_row, of_row * block,
                      -20);
            kernels_expect_near(out, expected, error, ALL, "background", set);
            kernels_check_guards(out, "background", set);
        }
    }
    kernels_free(out);
}

/* The weights, along three axes, of the samples around a point that are not masked. */
static double cover_reference(const cvol_mask_grid *g, int x, int y, int z)
{
    double cover = 0;
    for (int corner = 0; corner < 8; corner++) {
        const cvol_mask_points *axes[3] = {g->lane, g->row, g->sheet};
        const int point[3] = {x, y, z};
        int at[3];
        double weight = 1;
        for (int a = 0; a < 3; a++) {
            const int is_far = corner >> a & 1;
            const double far = (double)axes[a]->weight[point[a]];
            at[a] = is_far ? axes[a]->far[point[a]] : axes[a]->near[point[a]];
            weight *= is_far ? far : 1 - far;
        }
        const int masked = g->bits[at[1] * g->row_step + at[2] * g->sheet_step + at[0] / 16] >>
                               at[0] % 16 &
                           1;
        cover += masked ? 0 : weight;
    }
    return cover;
}

/* A cover is the sum of eight products of three weights: 11 roundings of numbers up to 1. Four more
 * compute a value near the background. */
static void points_are_covered(void **state)
{
    (void)state;
    cover_function *const covers[] = CVOL_SIMD_SETS(cvol_sheet_cover);
    points_function *const sets[] = CVOL_SIMD_SETS(cvol_sheet_fill_masked_points);
    static double cover[ALL], cover_error[ALL];
    float *out = kernels_memory(sizeof before);
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(500 + number);
        const int block = 8 << number % 3, of_row = (block + 15) / 16;
        const uint32_t quarter = (uint32_t)block / 4;
        cvol_sheet_plan plan = {.points_lane = block - 2 * (int)random_below(&r, quarter + 1),
                                .points_row = block - 2 * (int)random_below(&r, quarter + 1),
                                .points_sheet = block - 2 * (int)random_below(&r, quarter + 1)};
        plan.pitch_lane = (double)block / plan.points_lane;
        plan.pitch_row = (double)block / plan.points_row;
        plan.pitch_sheet = (double)block / plan.points_sheet;
        plan.first_lane = (plan.pitch_lane - 1) / 2;
        plan.first_row = (plan.pitch_row - 1) / 2;
        plan.first_sheet = (plan.pitch_sheet - 1) / 2;
        cvol_mask_points points[3];
        cvol_mask_points_find(points, &plan, block);
        const cvol_mask_grid grid = {bits,       of_row,     of_row * block, block,
                                     &points[0], &points[1], &points[2]};
        cvol_sheet_piece piece = {
            out, ROW, SHEET, (int)random_below(&r, quarter), 1, (int)random_below(&r, quarter), 1};
        piece.rows = plan.points_row - piece.row - (int)random_below(&r, quarter);
        piece.sheets = plan.points_sheet - piece.sheet - (int)random_below(&r, quarter);
        make_bits(&r, block);
        begin(&r);
        memcpy(cover, expected, sizeof cover);
        memset(cover_error, 0, sizeof cover_error);
        for (int z = 0; z < piece.sheets; z++)
            for (int y = 0; y < piece.rows; y++)
                for (int x = 0; x < plan.points_lane; x++) {
                    const int at = SHEET * z + ROW * y + x;
                    const double of = cover_reference(&grid, x, y + piece.row, z + piece.sheet);
                    error[at] = 15 * UNIT * (20 + fabs(expected[at]));
                    expected[at] = -20 + of * (expected[at] + 20);
                    cover[at] = of;
                    cover_error[at] = 11 * UNIT;
                }
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            memcpy(out, before, sizeof before);
            covers[set](&piece, &grid);
            kernels_expect_near(out, cover, cover_error, ALL, "cover", set);
            memcpy(out, before, sizeof before);
            sets[set](&piece, &grid, -20);
            kernels_expect_near(out, expected, error, ALL, "points of a background", set);
            kernels_check_guards(out, "points", set);
        }
    }
    kernels_free(out);
}

/* ---- contents of tiles ----------------------------------------------------------------------- */

typedef void accumulate_function(float *, const float *, int, int, int);

static void extremes_are_accumulated(void **state)
{
    (void)state;
    accumulate_function *const sets[] = CVOL_SIMD_SETS(cvol_extremes_accumulate);
    enum { TILES = 3, WIDTH = TILES * CVOL_TILE };
    static float lines[CVOL_TILE][CVOL_LINES][WIDTH];
    float *held = kernels_memory(sizeof *held * TILES);
    for (uint64_t number = 0; number < CASES; number++) {
        random_state r = kernels_random(600 + number);
        const int count = 1 + (int)random_below(&r, CVOL_TILE), sign = number % 2 ? 1 : -1;
        float first[TILES], least[TILES];
        for (int j = 0; j < CVOL_TILE; j++)
            for (int i = 0; i < WIDTH; i++) {
                lines[j][0][i] = (float)random_signed(&r);
                lines[j][1][i] = (float)(random_below(&r, 1000) > 0 || i / CVOL_TILE == 1);
            }
        for (int t = 0; t < TILES; t++) {
            first[t] = t == 1 && number % 3 ? -2 : -INFINITY;
            least[t] = INFINITY;
            for (int j = 0; j < count; j++)
                for (int i = CVOL_TILE * t; i < CVOL_TILE * (t + 1); i++) {
                    const float value = lines[j][1][i] > 0 ? (float)sign * lines[j][0][i]
                                                           : -INFINITY;
                    least[t] = value < least[t] ? value : least[t];
                }
        }
        for (int set = 0; set < KERNELS_SETS(sets); set++) {
            memcpy(held, first, sizeof first);
            sets[set](held, lines[0][0], WIDTH, count, sign);
            kernels_expect_same(held, least, sizeof least, "extremes", set);
            kernels_check_guards(held, "extremes", set);
        }
    }
    kernels_free(held);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_are_evaluated),
        cmocka_unit_test(faces_between_lanes_are_filtered),
        cmocka_unit_test(other_faces_are_filtered),
        cmocka_unit_test(samples_are_bounded),
        cmocka_unit_test(masked_samples_are_filled),
        cmocka_unit_test(points_are_covered),
        cmocka_unit_test(extremes_are_accumulated),
    };
    kernels_begin();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
