/* From a block's terms to its samples, on any view of its axes.
 *
 * The block's axes are called lane, row and sheet; the caller chooses which of x, y, z each is. The
 * work runs from the sparse end to the dense one:
 *   1. lane:  T1[s][r] += value lane_basis[f]   one vector operation per term and CVOL_LANES lanes
 *   2. row:   T2[s][j] from T1[s][0 .. low_row)
 *   3. sheet: out[z][j] from T2[0 .. low_sheet)[j]
 * so frequencies beyond the block's own low box cost nothing.
 *
 * Only kernel files include this file: each compiles it for its instruction set. */
#ifndef CVOL_ARRAY_BLOCK_BLOCK_INVERSE_H
#define CVOL_ARRAY_BLOCK_BLOCK_INVERSE_H

#include "array/block/block_batch.h"
#include "array/block/block_dense.h"
#include "array/block/block_inverse_steps.h"
#include "array/block/split_inverse.h"
#include "base/vector_int16.h"
#include "transform/lines.h"

/* Step 1. Line (s, r) begins at first[(s B + r) width]. */
CVOL_INLINE void cvol_block_gather_lanes(float *first, cvol_block_rows *rows,
                                         const cvol_block *block, const float *lane_basis,
                                         int block_log2, float step, int width, int lane, int row,
                                         int sheet)
{
    const int B = 1 << block_log2;
    for (int s = 0; s < block->low[sheet]; s++) {
        memset(first + (ptrdiff_t)s * B * width, 0,
               sizeof(float) * (size_t)(block->low[row] * width));
        rows->count[s] = 0;
    }
    cvol_term_batch batch;
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
    while (words < end) {
        int count;
        words = cvol_batch_next(&batch, &count, words, end, step, block_log2);
        cvol_batch_set_targets(&batch, block_log2, width, lane, row, sheet, 0, 0);
        cvol_batch_add(first, rows->count, &batch, count, lane_basis, width);
    }
}

/* Step 3, for `lanes` lanes from `part` on. Line j of slice s begins at in[(s rows + j) width]. */
CVOL_INLINE void cvol_block_sheets(const cvol_block_out *to, const cvol_block_axes *axes,
                                   const float *in, int width, int low_sheet, int part, int lanes)
{
    const int rows = axes->row_points, sheets = axes->sheet_points;
    float *out = (float *)to->at + part;
    if (__builtin_expect(axes->sheet_ends != 0, 0)) {
        for (int j = 0; j < rows; j++)
            cvol_lines_tile(out + j * to->row_stride, to->sheet_stride, in + j * width,
                            (ptrdiff_t)rows * width, low_sheet, axes->sheet_basis, sheets, 0, 2,
                            lanes);
        return;
    }
    for (int j = 0; j < rows; j++)
        cvol_lines_inverse(out + j * to->row_stride, to->sheet_stride, in + j * width,
                           (ptrdiff_t)rows * width, low_sheet, axes->sheet_basis, sheets, lanes);
}

/* Two rows, as int16: `tile` slices from i on and their mirror images. */
CVOL_INLINE void cvol_block_int16_tile(int16_t *out, ptrdiff_t row_stride, ptrdiff_t sheet_stride,
                                       float start, const float *in, int width, ptrdiff_t in_stride,
                                       int K, const float *basis, int M, int i, int tile, int lanes)
{
    cvol_vf near[2][CVOL_LINES_TILE], far[2][CVOL_LINES_TILE];
    cvol_lines_sums(near, far, 2, width, cvol_splat(start), in, in_stride, K, basis, M, i, tile);
    for (int t = 0; t < tile; t++) {
        int16_t *near_at = out + (i + t) * sheet_stride,
                *far_at = out + (M - 1 - i - t) * sheet_stride;
        cvol_store_int16_of_two(near_at, near_at + row_stride, near[0][t], near[1][t], lanes);
        cvol_store_int16_of_two(far_at, far_at + row_stride, far[0][t], far[1][t], lanes);
    }
}

/* Step 3 as int16. */
CVOL_INLINE void cvol_block_sheets_int16(const cvol_block_out *to, const cvol_block_axes *axes,
                                         const float *in, int width, int low_sheet, int part,
                                         int lanes)
{
    const int rows = axes->row_points, sheets = axes->sheet_points;
    const int wanted = axes->sheet_ends ? 2 : sheets / 2;
    for (int j = 0; j < rows; j += 2) {
        int16_t *out = (int16_t *)to->at + part + j * to->row_stride;
        int i = 0;
        for (; i + CVOL_LINES_TILE <= wanted; i += CVOL_LINES_TILE)
            cvol_block_int16_tile(out, to->row_stride, to->sheet_stride, to->start, in + j * width,
                                  width, (ptrdiff_t)rows * width, low_sheet, axes->sheet_basis,
                                  sheets, i, CVOL_LINES_TILE, lanes);
        for (; CVOL_LINES_TILE > 2 && i + 2 <= wanted; i += 2)
            cvol_block_int16_tile(out, to->row_stride, to->sheet_stride, to->start, in + j * width,
                                  width, (ptrdiff_t)rows * width, low_sheet, axes->sheet_basis,
                                  sheets, i, 2, lanes);
        for (; i < wanted; i++)
            cvol_block_int16_tile(out, to->row_stride, to->sheet_stride, to->start, in + j * width,
                                  width, (ptrdiff_t)rows * width, low_sheet, axes->sheet_basis,
                                  sheets, i, 1, lanes);
    }
}

/* Step 1, with the axes and sizes known at compile time. */
CVOL_INLINE void cvol_block_lanes_of(cvol_block_work *work, cvol_block_rows *low_rows,
                                     const cvol_block *block, const cvol_block_axes *axes,
                                     int block_log2, float step, int lane, int row, int sheet)
{
    const int B = 1 << block_log2, width = B < 16 ? 16 : B;
    if (block_log2 == CVOL_DENSE_LOG2 && cvol_dense_is_cheaper(block, lane, row, sheet)) {
        const int low_row = cvol_block_frequencies(axes, axes->row_points, block->low[row]),
                  low_sheet = cvol_block_frequencies(axes, axes->sheet_points, block->low[sheet]);
        const float *const of = axes->lane_basis;
        const float *const bases[2][2][2] = {{{of, of}, {of, of}}, {{of, of}, {of, of}}};
        cvol_dense_lanes(work->first, (int32_t *)cvol_block_second(work, block_log2), low_rows,
                         block, bases, 1, step, lane, row, sheet, low_row, low_sheet);
    } else {
        cvol_block_gather_lanes(work->first, low_rows, block, axes->lane_basis, block_log2, step,
                                width, lane, row, sheet);
    }
}

CVOL_INLINE void cvol_block_lanes_of_size(cvol_block_work *work, cvol_block_rows *low_rows,
                                          const cvol_block *block, const cvol_block_axes *axes,
                                          int block_log2, float step)
{
    if (axes->sheet == 2)
        cvol_block_lanes_of(work, low_rows, block, axes, block_log2, step, 0, 1, 2);
    else if (axes->sheet == 1)
        cvol_block_lanes_of(work, low_rows, block, axes, block_log2, step, 0, 2, 1);
    else
        cvol_block_lanes_of(work, low_rows, block, axes, block_log2, step, 1, 2, 0);
}

/* The same on any view, of blocks of any size: one function, since it is long. */
static __attribute__((noinline)) void
cvol_block_lanes(cvol_block_work *work, cvol_block_rows *low_rows, const cvol_block *block,
                 const cvol_block_axes *axes, int block_log2, float step)
{
    if (block_log2 == 4)
        cvol_block_lanes_of_size(work, low_rows, block, axes, 4, step);
    else if (block_log2 == 3)
        cvol_block_lanes_of_size(work, low_rows, block, axes, 3, step);
    else
        cvol_block_lanes_of_size(work, low_rows, block, axes, 5, step);
}

/* Steps 2 and 3. `width`: floats per line, known at compile time. */
CVOL_INLINE void cvol_block_rows_and_sheets(const cvol_block_out *out, cvol_block_work *work,
                                            const cvol_block_rows *low_rows,
                                            const cvol_block *block, const cvol_block_axes *axes,
                                            int block_log2, int width)
{
    const int rows = axes->row_points;
    const int low_sheet = cvol_block_frequencies(axes, axes->sheet_points, block->low[axes->sheet]);
    float *second = cvol_block_second(work, block_log2);
    for (int part = 0; part < width; part += CVOL_LANES) {
        int lanes = axes->lane_points - part < CVOL_LANES ? axes->lane_points - part : CVOL_LANES;
        if (lanes <= 0)
            break;
        for (int s = 0; s < low_sheet; s++)
            cvol_lines_inverse(second + (ptrdiff_t)s * rows * width + part, width,
                               work->first + ((ptrdiff_t)s << block_log2) * width + part, width,
                               cvol_block_frequencies(axes, rows, low_rows->count[s]),
                               axes->row_basis, rows, CVOL_LANES);
        if (out->are_words)
            cvol_block_sheets_int16(out, axes, second + part, width, low_sheet, part, lanes);
        else
            cvol_block_sheets(out, axes, second + part, width, low_sheet, part, lanes);
    }
}

/* Samples of the block. */
CVOL_INLINE void cvol_block_inverse_to(const cvol_block_out *out, const cvol_block *block,
                                       const cvol_block_axes *axes, int block_log2, float step,
                                       cvol_block_work *work)
{
    if (__builtin_expect(block->split != 0, 0)) {
        cvol_split_inverse(out, block, axes, step, work);
        return;
    }
    cvol_block_rows low_rows;
    cvol_block_lanes(work, &low_rows, block, axes, block_log2, step);
    if (block_log2 <= 4)
        cvol_block_rows_and_sheets(out, work, &low_rows, block, axes, block_log2, 16);
    else
        cvol_block_rows_and_sheets(out, work, &low_rows, block, axes, block_log2, 32);
}

/* As floats: out[z * sheet_stride + j * row_stride + i] for slice z, row j, lane i. */
CVOL_INLINE void cvol_block_inverse(float *out, ptrdiff_t row_stride, ptrdiff_t sheet_stride,
                                    const cvol_block *block, const cvol_block_axes *axes,
                                    int block_log2, float step, cvol_block_work *work)
{
    const cvol_block_out to = {out, row_stride, sheet_stride, 0, 0};
    cvol_block_inverse_to(&to, block, axes, block_log2, step, work);
}

#endif
