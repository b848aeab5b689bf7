/* The common part of evaluating blocks and split blocks: the view of the axes, and scratch
 * memory. */
#ifndef CVOL_ARRAY_BLOCK_BLOCK_INVERSE_STEPS_H
#define CVOL_ARRAY_BLOCK_BLOCK_INVERSE_STEPS_H

#include "array/core/array.h"
#include "base/vector.h"
#include "transform/block.h"

typedef struct cvol_block_axes {
    int lane, row, sheet; /* 0 x, 1 y, 2 z: each once, lane < row */
    /* Points per block and axis, even, at most B, and the basis there: basis[v * points + i], the
     * lane basis padded with zeros to a row of 16 or 32. All 64-byte aligned. */
    int lane_points, row_points, sheet_points;
    const float *lane_basis, *row_basis, *sheet_basis;
    /* The same for sub-blocks of 8 and of 4; index v of the block's axis (cell.h). The lane bases
     * are in one array. Unused if no block is split. */
    const float *lane_parts[2], *row_parts[2], *sheet_parts[2];
    /* 0: all slices. Else only the two outermost are needed, at the low end (1), the high (2), or
     * both; others may or may not be written. Then sheet_points is 16. */
    int sheet_ends;
    /* 1: skips frequencies too high for this number of rows or slices; they would alias to lower
     * ones, at the same cost. */
    int fewer;
} cvol_block_axes;

/* The number of frequencies of rows, or slices, that are summed, of `low`. */
static inline int cvol_block_frequencies(const cvol_block_axes *axes, int points, int low)
{
    return axes->fewer && points < low ? points : low;
}

/* Scratch memory of one thread. */
typedef struct cvol_block_work {
    float first[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX] __attribute__((aligned(64)));
    float second[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX] __attribute__((aligned(64)));
} cvol_block_work;

/* For a caller that evaluates only blocks of 16 and 8: it may be used as a cvol_block_work, since
 * these need only its beginning. */
enum { CVOL_CELL_WORK = 16 * 16 * 16 };
typedef struct cvol_cell_work {
    float first[CVOL_CELL_WORK], second[CVOL_CELL_WORK];
} __attribute__((aligned(64))) cvol_cell_work;

CVOL_INLINE float *cvol_block_second(cvol_block_work *work, int block_log2)
{
    return block_log2 > 4 ? work->second : work->first + CVOL_CELL_WORK;
}

/* The target of samples: sample i of row j in slice z goes to at[z sheet_stride + j row_stride +
 * i]. The type is known at compile time. */
typedef struct cvol_block_out {
    void *at;
    ptrdiff_t row_stride, sheet_stride;
    int are_words; /* int16 (vector_int16.h); 0: floats */
    float start;   /* added to each float */
} cvol_block_out;

/* The number of rows with terms, for each slice of frequencies. */
typedef struct cvol_block_rows {
    uint8_t count[CVOL_BLOCK_MAX];
} cvol_block_rows;

#endif
