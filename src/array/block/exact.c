/* Exact evaluation: the matrices, the boxes, the reference, and the choice of kernel. */
#include "array/block/exact.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "array/block/exact_kernel.h"
#include "array/block/lapped.h"
#include "base/cpu.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "transform/block.h"
#include "transform/cell.h"
#include "transform/cell_bases.h"
#include "transform/lap.h"

#define PI 3.14159265358979323846
#define SCALE ((double)(1 << CVOL_EXACT_MATRIX_BITS))

enum { CELL = CVOL_CELL, REACH = 2 };

/* H 2^20. */
const int32_t cvol_exact_filter[4] = {-81462, -242189, 100318, -140227};

/* Filled once, then read only. */
static int32_t of_4[4 * 4], of_8[8 * 8], of_16[16 * 16], of_32[32 * 32];
static cvol_exact_bases bases;
static pthread_once_t bases_once = PTHREAD_ONCE_INIT;

CVOL_SIMD_DECLARE(void, cvol_exact_cell,
                  (double *out, const cvol_block *block, double unit, const size_t first[3],
                   const size_t last[3], const cvol_exact_bases *with));
CVOL_SIMD_DECLARE(void, cvol_exact_lap,
                  (double *samples, const cvol_exact_faces *faces, const double h[4]));
CVOL_SIMD_DECLARE(void, cvol_exact_finish,
                  (double *out, const double *in, size_t count, double offset, double step,
                   double lo, double hi, int is_integer));

/* ---- matrices -------------------------------------------------------------------------------- */

/* No entry is so near to the middle between two integers that the cosine's last bits change it: see
 * the test. */
static void fill_matrix(int32_t *C, int M)
{
    for (int f = 0; f < M; f++)
        for (int x = 0; x < M; x++) {
            const int turn = f * (2 * x + 1) % (4 * M); /* of cos(2 pi turn / (4 M)) */
            C[f * M + x] = (int32_t)lrint(SCALE * sqrt((f ? 2.0 : 1.0) / M) *
                                          cvol_cos(PI * turn / (2.0 * M)));
        }
}

static void fill_rows(void)
{
    for (int u = 0; u < CELL; u++)
        for (int x = 0; x < 8; x++) {
            const int c = u & 1, g = u / 2;
            bases.rows[CVOL_CELL_BY_16][u][8 * c + x] = of_16[u * 16 + x] / SCALE;
            bases.rows[CVOL_CELL_BY_8][u][8 * c + x] = of_8[g * 8 + x] / SCALE;
            if (g % 2 == x / 4)
                bases.rows[CVOL_CELL_BY_4][u][8 * c + x] = of_4[g / 2 * 4 + x % 4] / SCALE;
        }
}

static void fill_bases(void)
{
    fill_matrix(of_4, 4);
    fill_matrix(of_8, 8);
    fill_matrix(of_16, 16);
    fill_matrix(of_32, 32);
    fill_rows();
    for (int f = 0; f < 16; f++)
        for (int x = 0; x < 8; x++)
            bases.of_16[f][x] = of_16[f * 16 + x] / SCALE;
    for (int f = 0; f < 8; f++)
        for (int x = 0; x < 4; x++)
            bases.of_8[f][x] = of_8[f * 8 + x] / SCALE;
    for (int f = 0; f < 4; f++)
        for (int x = 0; x < 2; x++)
            bases.of_4[f][x] = of_4[f * 4 + x] / SCALE;
    for (int i = 0; i < 4; i++)
        bases.filter[i] = cvol_exact_filter[i] / SCALE;
}

const int32_t *cvol_exact_matrix(int log2)
{
    pthread_once(&bases_once, fill_bases);
    return log2 == 2 ? of_4 : log2 == 3 ? of_8 : log2 == 4 ? of_16 : of_32;
}

/* ---- fraction bits --------------------------------------------------------------------------- */

uint64_t cvol_exact_largest_sum(const cvol_array *array)
{
    uint64_t largest = 0;
    for (size_t i = 0; i < array->block_count; i++) {
        const cvol_block *block = &array->block_table[i];
        const uint32_t *words = block->terms, *end = cvol_block_end(block);
        uint64_t sum = 0;
        while (words < end) {
            uint32_t place;
            const int64_t value = cvol_term_unpack(&words, &place,
                                                   cvol_place_bits(array->block_log2));
            sum += (uint64_t)(value < 0 ? -value : value);
        }
        largest = sum > largest ? sum : largest;
    }
    return largest;
}

int cvol_exact_fraction(uint64_t largest_sum)
{
    int fraction = CVOL_EXACT_FRACTION_MAX;
    while (fraction >= 0 && largest_sum > UINT64_C(1) << (CVOL_EXACT_SUM_BITS - fraction))
        fraction--;
    return fraction;
}

/* ---- the reference --------------------------------------------------------------------------- */

/* floor(sum / 2^20 + 1/2) */
static int64_t rounded(int64_t sum)
{
    const int64_t above = sum + (INT64_C(1) << (CVOL_EXACT_MATRIX_BITS - 1));
    const int64_t unit = INT64_C(1) << CVOL_EXACT_MATRIX_BITS, part = above % unit;
    return (above - (part < 0 ? part + unit : part)) / unit;
}

/* in[f stride] becomes v[x stride], for one line of a sub-block. */
static void line_reference(int64_t *line, int64_t stride, const int32_t *C, int M)
{
    int64_t in[CVOL_BLOCK_MAX];
    for (int f = 0; f < M; f++)
        in[f] = line[f * stride];
    for (int x = 0; x < M; x++) {
        int64_t sum = 0;
        for (int f = 0; f < M; f++)
            sum += C[f * M + x] * in[f];
        line[x * stride] = rounded(sum);
    }
}

/* One sub-block, M^3: gathered from a block of side B with coefficients by place, and transformed
 * where its samples lie. */
static void part_reference(int64_t *out, const int64_t *places, const cvol_sub_block *part, int B)
{
    const int M = part->side, apart = B / M, strides[3] = {1, B, B * B};
    const int32_t *C = cvol_exact_matrix(M == 4 ? 2 : M == 8 ? 3 : M == 16 ? 4 : 5);
    int64_t *corner = out + part->begin[0] + B * (part->begin[1] + B * part->begin[2]);
    for (int i = 0; i < M * M * M; i++) {
        const int at[3] = {i % M, i / M % M, i / M / M};
        corner[at[0] + B * (at[1] + B * at[2])] =
            places[part->first[0] + at[0] * apart +
                   B * (part->first[1] + at[1] * apart + B * (part->first[2] + at[2] * apart))];
    }
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < M * M; i++)
            line_reference(corner + i % M * strides[a == 0] + i / M * strides[a == 2 ? 1 : 2],
                           strides[a], C, M);
}

static void block_reference(int64_t *out, int64_t *places, const cvol_array *array, size_t index,
                            int fraction)
{
    const int B = array->block;
    const cvol_block *block = &array->block_table[index];
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
    cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX] = {{.side = B}};
    const int count = B == CELL ? cvol_cell_list_sub_blocks(parts, block->split) : 1;
    memset(places, 0, sizeof *places * cvol_array_block_terms(array));
    while (words < end) {
        uint32_t place;
        const int64_t value = cvol_term_unpack(&words, &place, cvol_place_bits(array->block_log2));
        places[place] = value * (INT64_C(1) << fraction);
    }
    for (int p = 0; p < count; p++)
        part_reference(out, places, &parts[p], B);
}

/* ---- boxes ----------------------------------------------------------------------------------- */

/* A box, widened by the reach of the filter. */
typedef struct wide_box {
    size_t begin[3], end[3], stride[3];
} wide_box;

static wide_box widen(const cvol_array *array, const size_t begin[3], const size_t end[3])
{
    wide_box box;
    memcpy(box.begin, begin, sizeof box.begin);
    memcpy(box.end, end, sizeof box.end);
    if (array->lapped)
        cvol_lapped_widen(box.begin, box.end, array);
    /* Strides that are not powers of two avoid conflicts of cache lines. */
    box.stride[0] = 1;
    box.stride[1] = (box.end[0] - box.begin[0] + 7) / 8 * 8 + 8;
    box.stride[2] = box.stride[1] * (box.end[1] - box.begin[1]) + 8;
    return box;
}

size_t cvol_exact_scratch(const cvol_array *array, const size_t begin[3], const size_t end[3])
{
    const wide_box box = widen(array, begin, end);
    const size_t B = (size_t)array->block;
    size_t sheet, all;
    if (!cvol_size_multiply(&sheet, box.stride[1], box.end[1] - box.begin[1]) ||
        !cvol_size_add(&sheet, sheet, 8) ||
        !cvol_size_multiply(&all, sheet, box.end[2] - box.begin[2]) ||
        !cvol_size_add(&all, all, 2 * B * B * B))
        return 0;
    return all;
}

/* Copies the part of the box that lies in a block with samples first .. last - 1. */
static void put_cell(double *to, const wide_box *box, const double *cell, size_t B,
                     const size_t at[3], const size_t first[3], const size_t last[3])
{
    const size_t width = last[0] - first[0];
    for (size_t z = first[2]; z < last[2]; z++)
        for (size_t y = first[1]; y < last[1]; y++)
            memcpy(to + (at[0] + first[0] - box->begin[0]) +
                       (at[1] + y - box->begin[1]) * box->stride[1] +
                       (at[2] + z - box->begin[2]) * box->stride[2],
                   cell + first[0] + B * (y + B * z), width * sizeof *to);
}

static void evaluate_block(double *cell, double *spare, const cvol_array *array, size_t index,
                           int fraction, const size_t first[3], const size_t last[3])
{
    const cvol_block *block = &array->block_table[index];
    const size_t count = cvol_array_block_terms(array);
    if (!block->words) {
        memset(cell, 0, count * sizeof *cell);
    } else if (array->block == CELL) {
        CVOL_SIMD_CHOOSE(cvol_exact_cell)
        (cell, block, (double)(1 << fraction), first, last, &bases);
    } else {
        int64_t *out = (int64_t *)(void *)cell;
        block_reference(out, (int64_t *)(void *)spare, array, index, fraction);
        for (size_t i = 0; i < count; i++) {
            int64_t value;
            memcpy(&value, cell + i, sizeof value);
            cell[i] = (double)value;
        }
    }
}

/* Filters the faces across an axis whose four samples lie in the box. It filters at least the lines
 * that later axes or the result need. */
static void filter_axis(double *samples, const cvol_array *array, const wide_box *box, int axis)
{
    const size_t face = (box->begin[axis] + REACH + CELL - 1) / CELL * CELL;
    const size_t first = face ? face : CELL;
    size_t end = box->end[axis];
    const int near = axis == 0 ? 1 : 0, far = axis == 2 ? 1 : 2;
    if (end > array->grid.dims[axis])
        end = array->grid.dims[axis];
    if (first + REACH > end)
        return;
    const cvol_exact_faces faces = {
        .stride = (int64_t)box->stride[axis],
        .count = (int64_t)((end - REACH - first) / CELL + 1),
        .face_stride = (int64_t)(CELL * box->stride[axis]),
        .lines = {(int64_t)(box->end[near] - box->begin[near]),
                  (int64_t)(box->end[far] - box->begin[far])},
        .line_stride = {(int64_t)box->stride[near], (int64_t)box->stride[far]}};
    CVOL_SIMD_CHOOSE(cvol_exact_lap)
    (samples + (first - REACH - box->begin[axis]) * box->stride[axis], &faces, bases.filter);
}

static void finish(double *out, const double *samples, const cvol_array *array, int fraction,
                   const wide_box *box, const size_t begin[3], const size_t end[3])
{
    const size_t width = end[0] - begin[0];
    const int is_integer = cvol_type_is_integer(array->grid.type);
    const double step = ldexp(array->step, -fraction);
    for (size_t z = begin[2]; z < end[2]; z++)
        for (size_t y = begin[1]; y < end[1]; y++, out += width) {
            CVOL_SIMD_CHOOSE(cvol_exact_finish)
            (out,
             samples + (begin[0] - box->begin[0]) + (y - box->begin[1]) * box->stride[1] +
                 (z - box->begin[2]) * box->stride[2],
             width, array->offset, step, array->error_bound.value_min, array->error_bound.value_max,
             is_integer);
            if (array->grid.type == CVOL_FLOAT32)
                for (size_t x = 0; x < width; x++)
                    out[x] = (double)(float)out[x];
        }
}

void cvol_exact_box(double *out, double *scratch, const cvol_array *array, int fraction,
                    const size_t begin[3], const size_t end[3])
{
    const wide_box box = widen(array, begin, end);
    const size_t B = (size_t)array->block, terms = B * B * B;
    double *cell = scratch, *spare = scratch + terms, *samples = scratch + 2 * terms;
    pthread_once(&bases_once, fill_bases);
    for (size_t l = box.begin[2] / B; l * B < box.end[2]; l++)
        for (size_t j = box.begin[1] / B; j * B < box.end[1]; j++)
            for (size_t i = box.begin[0] / B; i * B < box.end[0]; i++) {
                const size_t at[3] = {i * B, j * B, l * B};
                size_t first[3], last[3];
                for (int a = 0; a < 3; a++) {
                    first[a] = box.begin[a] > at[a] ? box.begin[a] - at[a] : 0;
                    last[a] = box.end[a] < at[a] + B ? box.end[a] - at[a] : B;
                }
                evaluate_block(cell, spare, array,
                               i + array->blocks[0] * (j + array->blocks[1] * l), fraction, first,
                               last);
                put_cell(samples, &box, cell, B, at, first, last);
            }
    for (int axis = 0; axis < 3 && array->lapped; axis++)
        filter_axis(samples, array, &box, axis);
    finish(out, samples, array, fraction, &box, begin, end);
}

/* ---- the reference's boxes ------------------------------------------------------------------- */

/* The whole volume, filtered. */
static void filter_reference(int64_t *samples, const size_t dims[3])
{
    const size_t stride[3] = {1, dims[0], dims[0] * dims[1]};
    const int32_t *h = cvol_exact_filter;
    for (int axis = 0; axis < 3; axis++)
        for (size_t i = 0; i < dims[0] * dims[1] * dims[2]; i++) {
            const size_t x = i / stride[axis] % dims[axis], s = stride[axis];
            if ((x + REACH) % CELL || x + 2 * REACH > dims[axis])
                continue;
            int64_t *a = samples + i;
            const int64_t w0 = a[s] - a[2 * s], w1 = a[0] - a[3 * s];
            const int64_t d0 = rounded(h[0] * w0 + h[1] * w1), d1 = rounded(h[2] * w0 + h[3] * w1);
            a[0] += d1;
            a[s] += d0;
            a[2 * s] -= d0;
            a[3 * s] -= d1;
        }
}

static double base_reference(int64_t value, const cvol_array *array, int fraction)
{
    double base = ldexp(array->step, -fraction) * (double)value;
    base = array->offset + base;
    if (base < array->error_bound.value_min)
        base = array->error_bound.value_min;
    if (base > array->error_bound.value_max)
        base = array->error_bound.value_max;
    if (cvol_type_is_integer(array->grid.type))
        return floor(base + 0.5);
    return array->grid.type == CVOL_FLOAT32 ? (double)(float)base : base;
}

int cvol_exact_box_reference(double *out, const cvol_array *array, int fraction,
                             const size_t begin[3], const size_t end[3])
{
    const size_t *dims = array->grid.dims, B = (size_t)array->block, terms = B * B * B;
    int64_t *samples = cvol_allocate(cvol_grid_samples(&array->grid), sizeof *samples);
    int64_t *block = cvol_allocate(2 * terms, sizeof *block);
    const int done = samples && block;
    for (size_t b = 0; b < array->block_count && done; b++) {
        size_t at[3];
        cvol_block_origin(at, array, b);
        block_reference(block, block + terms, array, b, fraction);
        for (size_t i = 0; i < terms; i++) {
            const size_t x = at[0] + i % B, y = at[1] + i / B % B, z = at[2] + i / B / B;
            if (x < dims[0] && y < dims[1] && z < dims[2])
                samples[x + dims[0] * (y + dims[1] * z)] = block[i];
        }
    }
    if (done && array->lapped)
        filter_reference(samples, dims);
    for (size_t z = begin[2]; z < end[2] && done; z++)
        for (size_t y = begin[1]; y < end[1]; y++)
            for (size_t x = begin[0]; x < end[0]; x++)
                *out++ = base_reference(samples[x + dims[0] * (y + dims[1] * z)], array, fraction);
    free(samples);
    free(block);
    return done;
}
