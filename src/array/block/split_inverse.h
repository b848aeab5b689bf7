/* From the terms of a split block (transform/cell.h) to its samples, on any view of its axes.
 *
 * The three steps are those of block_inverse.h. Along an axis, index v belongs to the half v & 1,
 * so the low bits of a term's place select its octant, and thus its basis: that of 8 or that of 4.
 * A vector of lanes covers both halves of the lane axis. If their octants differ, sums are made
 * with both bases, and each lane takes its own.
 *
 * Only kernel files include this file: each compiles it for its instruction set. */
#ifndef CVOL_ARRAY_BLOCK_SPLIT_INVERSE_H
#define CVOL_ARRAY_BLOCK_SPLIT_INVERSE_H

#include "array/block/block_batch.h"
#include "array/block/block_dense.h"
#include "array/block/block_inverse_steps.h"
#include "base/vector_int16.h"

/* The split of the octants of two halves of an axis: 0 not split (8), 1 into fours. */
typedef struct cvol_split_halves {
    int of[2];
} cvol_split_halves;

/* The same as cvol_block_frequencies, with the same number for every sub-block, side by side. */
CVOL_INLINE int cvol_split_frequencies(const cvol_block_axes *axes, int points, int low)
{
    return cvol_block_frequencies(axes, (points + 3) / 4 * 4, low);
}

/* Octant bits along the view's axes. */
CVOL_INLINE int cvol_split_kind(uint16_t split, const cvol_block_axes *axes, int lane_half,
                                int row_half, int sheet_half)
{
    const int octant = lane_half << axes->lane | row_half << axes->row | sheet_half << axes->sheet;
    return split >> (1 + octant) & 1;
}

CVOL_INLINE cvol_split_halves cvol_split_lanes(uint16_t split, const cvol_block_axes *axes,
                                               int row_half, int sheet_half)
{
    return (cvol_split_halves){{cvol_split_kind(split, axes, 0, row_half, sheet_half),
                                cvol_split_kind(split, axes, 1, row_half, sheet_half)}};
}

/* Step 1: terms onto lines of lanes. With lane = x, the terms of a line are consecutive, and are
 * summed in registers (cvol_batch_add). */
CVOL_INLINE void cvol_split_gather_lanes(float *first, cvol_block_rows *rows,
                                         const cvol_block *block, const cvol_block_axes *axes,
                                         float step, int lane, int row, int sheet)
{
    enum { LOG2 = 4, B = 1 << LOG2 };
    for (int s = 0; s < block->low[sheet]; s++) {
        memset(first + (ptrdiff_t)s * B * B, 0, sizeof(float) * (size_t)(block->low[row] * B));
        rows->count[s] = 0;
    }
    const int parts = (int)(axes->lane_parts[1] - axes->lane_parts[0]);
    cvol_term_batch batch;
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
    while (words < end) {
        int count;
        words = cvol_batch_next(&batch, &count, words, end, step, LOG2);
        cvol_batch_set_targets(&batch, LOG2, B, lane, row, sheet, block->split, parts);
        cvol_batch_add(first, rows->count, &batch, count, axes->lane_parts[0], B);
    }
}

/* The target of a step's lines: line i of vector j goes to at + i stride + j vector_stride (floats
 * or int16), `lanes` lanes of it. */
typedef struct cvol_split_out {
    void *at;
    ptrdiff_t stride, vector_stride;
    int are_words, lanes; /* see cvol_block_out */
    float start;
} cvol_split_out;

CVOL_INLINE void cvol_split_store(const cvol_split_out *out, ptrdiff_t i, ptrdiff_t j, cvol_vf v)
{
    const ptrdiff_t at = i * out->stride + j * out->vector_stride;
    if (out->are_words)
        cvol_store_int16((int16_t *)out->at + at, v, out->lanes);
    else if (out->lanes == CVOL_LANES)
        cvol_store((float *)out->at + at, v);
    else
        cvol_store_first((float *)out->at + at, v, out->lanes);
}

/* `tile` outputs from i on: the sums over places v = first, first + step, ... below K. */
CVOL_INLINE void cvol_split_sums(cvol_vf *sums, cvol_vf start, const float *in, ptrdiff_t in_stride,
                                 int first, int step, int K, const float *basis, int M, int i,
                                 int tile)
{
    for (int t = 0; t < tile; t++)
        sums[t] = start;
    for (int v = first; v < K; v += step) {
        const cvol_vf line = cvol_load(in + v * in_stride);
        for (int t = 0; t < tile; t++)
            sums[t] += basis[v * M + i + t] * line;
    }
}

/* The inputs of one half and quarter of an axis: the bases, the lane axis's first half by [0], and
 * the places that reach it. own: all bits of the lanes of that first half. */
typedef struct cvol_split_reach {
    const float *bases[2];
    int first[2], step[2], mixed, M, K;
    cvol_vi own;
} cvol_split_reach;

CVOL_INLINE cvol_split_reach cvol_split_reach_of(const float *const parts[2],
                                                 cvol_split_halves kinds, int quarter, int M, int K,
                                                 cvol_vi own)
{
    cvol_split_reach reach = {.mixed = kinds.of[0] != kinds.of[1], .M = M, .K = K, .own = own};
    for (int h = 0; h < 2; h++) {
        const int fours = kinds.of[h];
        reach.bases[h] = parts[fours];
        reach.first[h] = fours ? 2 * (quarter & 1) + (quarter >> 1) : quarter >> 1;
        reach.step[h] = fours ? 4 : 2;
    }
    return reach;
}

CVOL_INLINE void cvol_split_tile(const cvol_split_out *out, ptrdiff_t j, const float *in,
                                 ptrdiff_t in_stride, const cvol_split_reach *r, int i, int tile)
{
    const cvol_vf start = cvol_splat(out->start);
    cvol_vf sums[4], others[4];
    cvol_split_sums(sums, start, in, in_stride, r->first[0], r->step[0], r->K, r->bases[0], r->M, i,
                    tile);
    if (r->mixed) {
        cvol_split_sums(others, start, in, in_stride, r->first[1], r->step[1], r->K, r->bases[1],
                        r->M, i, tile);
        for (int t = 0; t < tile; t++)
            sums[t] = (cvol_vf)(((cvol_vi)sums[t] & r->own) | ((cvol_vi)others[t] & ~r->own));
    }
    for (int t = 0; t < tile; t++)
        cvol_split_store(out, i + t, j, sums[t]);
}

CVOL_INLINE void cvol_split_lines(const cvol_split_out *out, ptrdiff_t j, const float *in,
                                  ptrdiff_t in_stride, const cvol_split_reach *reach, int begin,
                                  int end)
{
    int i = begin;
    for (; i + 4 <= end; i += 4)
        cvol_split_tile(out, j, in, in_stride, reach, i, 4);
    if (i + 3 == end)
        cvol_split_tile(out, j, in, in_stride, reach, i, 3);
    else if (i + 2 == end)
        cvol_split_tile(out, j, in, in_stride, reach, i, 2);
    else if (i < end)
        cvol_split_tile(out, j, in, in_stride, reach, i, 1);
}

/* ---- at all 16 samples: the symmetry of the basis within each sub-block halves the work ------ */

/* Half c of an axis whose octant is not split, from the places below K; `lines` lines (1 or 2),
 * `apart` floats apart, as in cvol_lines_sums. */
CVOL_INLINE void cvol_split_eights(cvol_vf out[][8], int lines, ptrdiff_t apart, cvol_vf start,
                                   const float *in, ptrdiff_t in_stride, int K, int c,
                                   const float *basis)
{
    cvol_vf even[2][4], odd[2][4];
    for (int n = 0; n < lines; n++)
        for (int t = 0; t < 4; t++) {
            even[n][t] = start;
            odd[n][t] = (cvol_vf){0};
        }
    for (int v = c; v < K; v += 4) {
        const float *at = in + v * in_stride, *of = basis + v * 16 + 8 * c;
        for (int t = 0; t < 4; t++)
            for (int n = 0; n < lines; n++)
                even[n][t] += of[t] * cvol_load(at + n * apart);
        if (v + 2 >= K)
            break;
        for (int t = 0; t < 4; t++)
            for (int n = 0; n < lines; n++)
                odd[n][t] += of[32 + t] * cvol_load(at + 2 * in_stride + n * apart);
    }
    for (int n = 0; n < lines; n++)
        for (int t = 0; t < 4; t++) {
            out[n][t] = even[n][t] + odd[n][t];
            out[n][7 - t] = even[n][t] - odd[n][t];
        }
}

/* The same for a split octant. */
CVOL_INLINE void cvol_split_fours(cvol_vf out[][8], int lines, ptrdiff_t apart, cvol_vf start,
                                  const float *in, ptrdiff_t in_stride, int K, int c,
                                  const float *basis)
{
    for (int q = 0; q < 2; q++) {
        cvol_vf even[2][2] = {{start, start}, {start, start}}, odd[2][2] = {{{0}, {0}}, {{0}, {0}}};
        for (int v = c + 2 * q; v < K; v += 8) {
            const float *at = in + v * in_stride, *of = basis + v * 16 + 8 * c + 4 * q;
            for (int t = 0; t < 2; t++)
                for (int n = 0; n < lines; n++)
                    even[n][t] += of[t] * cvol_load(at + n * apart);
            if (v + 4 >= K)
                break;
            for (int t = 0; t < 2; t++)
                for (int n = 0; n < lines; n++)
                    odd[n][t] += of[64 + t] * cvol_load(at + 4 * in_stride + n * apart);
        }
        for (int n = 0; n < lines; n++)
            for (int t = 0; t < 2; t++) {
                out[n][4 * q + t] = even[n][t] + odd[n][t];
                out[n][4 * q + 3 - t] = even[n][t] - odd[n][t];
            }
    }
}

/* The kinds of a vector's lanes: all in octants that are not split, all in split ones, or the first
 * ones (`own`) in one kind and the others in the other. */
enum { CVOL_SPLIT_EIGHTS, CVOL_SPLIT_FOURS, CVOL_SPLIT_MIXED };

CVOL_INLINE void cvol_split_half_of(cvol_vf samples[][8], int lines, ptrdiff_t apart, cvol_vf start,
                                    const float *in, ptrdiff_t in_stride, int K, int c,
                                    const float *const parts[2], int kind, cvol_vi eights)
{
    cvol_vf others[2][8];
    if (kind != CVOL_SPLIT_FOURS)
        cvol_split_eights(samples, lines, apart, start, in, in_stride, K, c, parts[0]);
    if (kind == CVOL_SPLIT_FOURS)
        cvol_split_fours(samples, lines, apart, start, in, in_stride, K, c, parts[1]);
    if (kind == CVOL_SPLIT_MIXED) {
        cvol_split_fours(others, lines, apart, start, in, in_stride, K, c, parts[1]);
        for (int n = 0; n < lines; n++)
            for (int t = 0; t < 8; t++)
                samples[n][t] = cvol_select(eights, samples[n][t], others[n][t]);
    }
}

/* Half c of an axis, for `count` vectors, which lie in_line floats apart in `in`. */
CVOL_INLINE void cvol_split_half_kind(const cvol_split_out *out, const float *in, ptrdiff_t in_line,
                                      ptrdiff_t in_stride, int K, int c,
                                      const float *const parts[2], int kind, cvol_vi eights,
                                      int count)
{
    const cvol_vf start = cvol_splat(out->start);
    cvol_vf samples[2][8];
    int j = 0;
    for (; j + 1 < count && out->are_words; j += 2) {
        cvol_split_half_of(samples, 2, in_line, start, in + j * in_line, in_stride, K, c, parts,
                           kind, eights);
        for (int t = 0; t < 8; t++) {
            int16_t *at = (int16_t *)out->at + (8 * c + t) * out->stride + j * out->vector_stride;
            cvol_store_int16_of_two(at, at + out->vector_stride, samples[0][t], samples[1][t],
                                    out->lanes);
        }
    }
    for (; j < count; j++) {
        cvol_split_half_of(samples, 1, 0, start, in + j * in_line, in_stride, K, c, parts, kind,
                           eights);
        for (int t = 0; t < 8; t++)
            cvol_split_store(out, 8 * c + t, j, samples[0][t]);
    }
}

CVOL_INLINE void cvol_split_half(const cvol_split_out *out, const float *in, ptrdiff_t in_line,
                                 ptrdiff_t in_stride, int K, int c, const float *const parts[2],
                                 cvol_split_halves kinds, cvol_vi own, int count)
{
    int kind = CVOL_SPLIT_MIXED;
    if (kinds.of[0] == kinds.of[1] || !cvol_any(~own))
        kind = kinds.of[0];
    else if (!cvol_any(own))
        kind = kinds.of[1];
    if (kind == CVOL_SPLIT_EIGHTS)
        cvol_split_half_kind(out, in, in_line, in_stride, K, c, parts, CVOL_SPLIT_EIGHTS, own,
                             count);
    else if (kind == CVOL_SPLIT_FOURS)
        cvol_split_half_kind(out, in, in_line, in_stride, K, c, parts, CVOL_SPLIT_FOURS, own,
                             count);
    else
        cvol_split_half_kind(out, in, in_line, in_stride, K, c, parts, CVOL_SPLIT_MIXED,
                             kinds.of[0] ? ~own : own, count);
}

/* The first of M points across a block that lies in quarter q. */
CVOL_INLINE int cvol_split_point(int M, int q)
{
    return (q * M + 1) / 4; /* the least i with (i + 1/2) 4 / M >= q: ceil(q M / 4 - 1/2) */
}

/* Returns 1 if slices of this half are needed. */
CVOL_INLINE int cvol_split_needs(const cvol_block_axes *axes, int half)
{
    return !axes->sheet_ends || axes->sheet_ends >> half & 1;
}

/* The target of lanes from `part` on of slices, from row `row` on. */
CVOL_INLINE cvol_split_out cvol_split_out_of(const cvol_block_out *out, int part, int row,
                                             int lanes)
{
    const ptrdiff_t at = part + row * out->row_stride;
    return (cvol_split_out){out->are_words ? (void *)((int16_t *)out->at + at)
                                           : (void *)((float *)out->at + at),
                            out->sheet_stride,
                            out->row_stride,
                            out->are_words,
                            lanes,
                            out->start};
}

/* Step 2, for a vector of lanes. */
CVOL_INLINE void cvol_split_rows(float *second, const float *first, const cvol_block *block,
                                 const cvol_block_axes *axes, const cvol_block_rows *low_rows,
                                 cvol_vi own)
{
    enum { B = 16 };
    const int rows = axes->row_points,
              low_sheet = cvol_split_frequencies(axes, axes->sheet_points, block->low[axes->sheet]);
    for (int s = 0; s < low_sheet; s++) {
        const cvol_split_out out = {second + (ptrdiff_t)s * rows * B, B, 0, 0, CVOL_LANES, 0};
        const float *in = first + (ptrdiff_t)s * B * B;
        const int K = cvol_split_frequencies(axes, rows, low_rows->count[s]), half = s & 1;
        if (!cvol_split_needs(axes, half))
            continue;
        for (int c = 0; c < 2 && rows == B; c++)
            cvol_split_half(&out, in, 0, B, K, c, axes->row_parts,
                            cvol_split_lanes(block->split, axes, c, half), own, 1);
        for (int q = 0; q < 4 && rows != B; q++) {
            const cvol_split_reach reach = cvol_split_reach_of(
                axes->row_parts, cvol_split_lanes(block->split, axes, q >> 1, half), q, rows, K,
                own);
            cvol_split_lines(&out, 0, in, B, &reach, cvol_split_point(rows, q),
                             cvol_split_point(rows, q + 1));
        }
    }
}

/* Step 3, for a vector of lanes. */
CVOL_INLINE void cvol_split_sheets(const cvol_block_out *to, int part, int lanes,
                                   const float *second, const cvol_block *block,
                                   const cvol_block_axes *axes, cvol_vi own)
{
    enum { B = 16 };
    const int rows = axes->row_points, sheets = axes->sheet_points,
              K = cvol_split_frequencies(axes, sheets, block->low[axes->sheet]);
    for (int half = 0; half < 2; half++) {
        const cvol_split_out out = cvol_split_out_of(to, part, half * rows / 2, lanes);
        const float *in = second + half * rows / 2 * B;
        for (int c = 0; c < 2 && sheets == B; c++)
            if (cvol_split_needs(axes, c))
                cvol_split_half(&out, in, B, (ptrdiff_t)rows * B, K, c, axes->sheet_parts,
                                cvol_split_lanes(block->split, axes, half, c), own, rows / 2);
        for (int q = 0; q < 4 && sheets != B; q++) {
            const cvol_split_reach reach = cvol_split_reach_of(
                axes->sheet_parts, cvol_split_lanes(block->split, axes, half, q >> 1), q, sheets, K,
                own);
            for (int j = 0; j < rows / 2; j++)
                cvol_split_lines(&out, j, in + j * B, (ptrdiff_t)rows * B, &reach,
                                 cvol_split_point(sheets, q), cvol_split_point(sheets, q + 1));
        }
    }
}

CVOL_INLINE void cvol_split_step_lanes(cvol_block_work *work, cvol_block_rows *rows,
                                       const cvol_block *block, const cvol_block_axes *axes,
                                       float step, int lane, int row, int sheet)
{
    if (cvol_dense_is_cheaper(block, lane, row, sheet)) {
        const float *bases[2][2][2];
        for (int half = 0; half < 4; half++) {
            const cvol_split_halves kinds = cvol_split_lanes(block->split, axes, half & 1,
                                                             half >> 1);
            for (int f = 0; f < 2; f++)
                bases[half >> 1][half & 1][f] = axes->lane_parts[kinds.of[f]];
        }
        cvol_dense_lanes(work->first, (int32_t *)cvol_block_second(work, 4), rows, block,
                         (const float *const(*)[2][2])bases, 2, step, lane, row, sheet,
                         cvol_split_frequencies(axes, axes->row_points, block->low[row]),
                         cvol_split_frequencies(axes, axes->sheet_points, block->low[sheet]));
    } else
        cvol_split_gather_lanes(work->first, rows, block, axes, step, lane, row, sheet);
}

CVOL_INLINE void cvol_split_inverse(const cvol_block_out *out, const cvol_block *block,
                                    const cvol_block_axes *axes, float step, cvol_block_work *work)
{
    cvol_block_rows low_rows;
    if (axes->lane == 1)
        cvol_split_step_lanes(work, &low_rows, block, axes, step, 1, 2, 0);
    else if (axes->sheet == 1)
        cvol_split_step_lanes(work, &low_rows, block, axes, step, 0, 2, 1);
    else
        cvol_split_step_lanes(work, &low_rows, block, axes, step, 0, 1, 2);
    for (int part = 0; part < axes->lane_points; part += CVOL_LANES) {
        const int lanes = axes->lane_points - part < CVOL_LANES ? axes->lane_points - part
                                                                : CVOL_LANES;
        cvol_vi own;
        for (int i = 0; i < CVOL_LANES; i++)
            own[i] = part + i < axes->lane_points / 2 ? -1 : 0;
        cvol_split_rows(cvol_block_second(work, 4) + part, work->first + part, block, axes,
                        &low_rows, own);
        cvol_split_sheets(out, part, lanes, cvol_block_second(work, 4) + part, block, axes, own);
    }
}

#endif
