/* What evaluating blocks and evaluating split cells share: the view of the axes, and scratch
 * memory.
 */
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
    /* The same of the parts of split cells, by 8 and by 4; index v of the cell's axis (cell.h).
     * Those of lanes are of one array. Not looked at where no block is split. */
    const float *lane_parts[2], *row_parts[2], *sheet_parts[2];
    /* 0: all sheets. Else only the two outermost are wanted, at the low end (1), the high (2), or
     * both; others may be written, or not. Then sheet_points is 16. */
    int sheet_ends;
    /* Whether frequencies that so few rows or sheets cannot have are left out: they would come back
     * as lower ones, and cost as much as those. */
    int fewer;
} cvol_block_axes;

/* Frequencies of rows, or sheets, that are summed, of `low`. */
static inline int cvol_block_frequencies(const cvol_block_axes *axes, int points, int low)
{
    return axes->fewer && points < low ? points : low;
}

/* Scratch memory of one thread. */
typedef struct cvol_block_work {
    float first[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX] __attribute__((aligned(64)));
    float second[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX] __attribute__((aligned(64)));
} cvol_block_work;

/* Of one that evaluates blocks of 16 and 8 only: it may be used as a cvol_block_work, whose
 * beginning is all that they need. */
enum { CVOL_CELL_WORK = 16 * 16 * 16 };
typedef struct cvol_cell_work {
    float first[CVOL_CELL_WORK], second[CVOL_CELL_WORK];
} __attribute__((aligned(64))) cvol_cell_work;

CVOL_INLINE float *cvol_block_second(cvol_block_work *work, int block_log2)
{
    return block_log2 > 4 ? work->second : work->first + CVOL_CELL_WORK;
}

/* Where samples go: sample i of row j in sheet z to at[z sheet_stride + j row_stride + i]. Whether
 * they are words is known when this is compiled. */
typedef struct cvol_block_out {
    void *at;
    long row_stride, sheet_stride;
    int are_words; /* of 16 bits (sample_words.h); 0: floats */
    float start;   /* added to each, where they are */
} cvol_block_out;

/* How many rows of each sheet of frequencies have terms. */
typedef struct cvol_block_rows {
    uint8_t count[CVOL_BLOCK_MAX];
} cvol_block_rows;

#endif
