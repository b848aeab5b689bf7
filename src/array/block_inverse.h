/* From a block's terms to its samples, on any view of its axes.
 *
 * The block's axes are called lane, row and sheet: which of x, y, z each is, the caller says. The
 * work runs from the sparse end to the dense one:
 *   1. lane:  T1[s][r] += value lane_basis[f]   one vector operation a term and CVOL_LANES lanes
 *   2. row:   T2[s][j] from T1[s][0 .. low_row)
 *   3. sheet: out[z][j] from T2[0 .. low_sheet)[j]
 * so that frequencies beyond the block's own low box cost nothing.
 *
 * To be included by kernel files only: each compiles it for its instruction set.
 */
#ifndef CVOL_ARRAY_BLOCK_INVERSE_H
#define CVOL_ARRAY_BLOCK_INVERSE_H

#include "array/array.h"
#include "transform/block.h"
#include "transform/lines.h"

typedef struct cvol_block_axes {
    int lane, row, sheet; /* 0 x, 1 y, 2 z: each once */
    /* Points per block and axis, even, at most B, and the basis there: basis[v * points + i], the
     * lane basis padded with zeros to lane_width, a multiple of 16. All 64-byte aligned. */
    int lane_points, lane_width, row_points, sheet_points;
    const float *lane_basis, *row_basis, *sheet_basis;
} cvol_block_axes;

/* Scratch memory of one thread. */
typedef struct cvol_block_work {
    float first[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX] __attribute__((aligned(64)));
    float second[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX] __attribute__((aligned(64)));
} cvol_block_work;

/* Step 1. */
CVOL_INLINE void cvol_block_gather_lanes(float *first, const cvol_block *block,
                                         const cvol_block_axes *axes, int block_log2, float step,
                                         int width)
{
    const int B = 1 << block_log2, place_bits = cvol_place_bits(block_log2);
    const int low_row = block->low[axes->row], low_sheet = block->low[axes->sheet];
    const int lane_shift = axes->lane * block_log2, row_shift = axes->row * block_log2,
              sheet_shift = axes->sheet * block_log2;
    for (int s = 0; s < low_sheet; s++)
        memset(first + (long)s * low_row * width, 0, sizeof(float) * (size_t)(low_row * width));
    const uint32_t *words = block->terms, *end = words + block->words;
    while (words < end) {
        uint32_t place;
        float value = step * (float)cvol_term_unpack(&words, &place, place_bits);
        int f = (int)(place >> lane_shift) & (B - 1), r = (int)(place >> row_shift) & (B - 1),
            s = (int)(place >> sheet_shift) & (B - 1);
        float *line = first + ((long)s * low_row + r) * width;
        const float *lanes = axes->lane_basis + f * width;
        for (int part = 0; part < width; part += CVOL_LANES)
            cvol_store(line + part, cvol_load(line + part) + value * cvol_load(lanes + part));
    }
}

/* Samples of the block: out[z * sheet_stride + j * row_stride + i] for sheet z, row j, lane i. */
CVOL_INLINE void cvol_block_inverse_width(float *out, long row_stride, long sheet_stride,
                                          const cvol_block *block, const cvol_block_axes *axes,
                                          int block_log2, float step, cvol_block_work *work,
                                          int width)
{
    const int low_row = block->low[axes->row], low_sheet = block->low[axes->sheet];
    const int rows = axes->row_points, sheets = axes->sheet_points;
    cvol_block_gather_lanes(work->first, block, axes, block_log2, step, width);
    for (int part = 0; part < width; part += CVOL_LANES) {
        int lanes = axes->lane_points - part < CVOL_LANES ? axes->lane_points - part : CVOL_LANES;
        if (lanes <= 0)
            break;
        for (int s = 0; s < low_sheet; s++)
            cvol_lines_inverse(work->second + (long)s * rows * width + part, width,
                               work->first + (long)s * low_row * width + part, width, low_row,
                               axes->row_basis, rows, CVOL_LANES);
        for (int j = 0; j < rows; j++)
            cvol_lines_inverse(out + j * row_stride + part, sheet_stride,
                               work->second + j * width + part, (long)rows * width, low_sheet,
                               axes->sheet_basis, sheets, lanes);
    }
}

CVOL_INLINE void cvol_block_inverse(float *out, long row_stride, long sheet_stride,
                                    const cvol_block *block, const cvol_block_axes *axes,
                                    int block_log2, float step, cvol_block_work *work)
{
    if (axes->lane_width == 16)
        cvol_block_inverse_width(out, row_stride, sheet_stride, block, axes, block_log2, step, work,
                                 16);
    else
        cvol_block_inverse_width(out, row_stride, sheet_stride, block, axes, block_log2, step, work,
                                 32);
}

#endif
