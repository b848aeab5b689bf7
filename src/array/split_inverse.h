/* From the terms of a split cell (transform/cell.h) to its samples, on any view of its axes.
 *
 * The same three steps as for blocks (block_inverse.h). Along an axis, index v belongs to the half
 * v & 1, so a term's octant follows from the low bits of its place, and says which basis it has:
 * that of 8 or that of 4. A vector of lanes reaches through both halves of the lane axis. Where
 * their octants differ, sums are made with the basis of either, and each lane takes its own.
 *
 * To be included by kernel files only: each compiles it for its instruction set.
 */
#ifndef CVOL_ARRAY_SPLIT_INVERSE_H
#define CVOL_ARRAY_SPLIT_INVERSE_H

#include "array/block_batch.h"
#include "array/block_inverse_steps.h"

/* How the octants of two halves of an axis are split: 0 into nothing (8), 1 into fours. */
typedef struct cvol_split_halves {
    int of[2];
} cvol_split_halves;

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

/* Step 1: terms onto lines of lanes. With lane = x, those of a line follow one another, and are
 * summed in registers (cvol_batch_add). */
CVOL_INLINE void cvol_split_gather_lanes(float *first, cvol_block_rows *rows,
                                         const cvol_block *block, const cvol_block_axes *axes,
                                         float step, int lane, int row, int sheet)
{
    enum { LOG2 = 4, B = 1 << LOG2 };
    for (int s = 0; s < block->low[sheet]; s++) {
        memset(first + (long)s * B * B, 0, sizeof(float) * (size_t)(block->low[row] * B));
        rows->count[s] = 0;
    }
    const int parts = (int)(axes->lane_parts[1] - axes->lane_parts[0]);
    cvol_term_batch batch;
    const uint32_t *words = block->terms, *end = cvol_block_end(block);
    while (words < end) {
        int count;
        words = cvol_batch_next(&batch, &count, words, end, step, LOG2);
        cvol_batch_aim(&batch, LOG2, B, lane, row, sheet, block->split, parts);
        cvol_batch_add(first, rows->count, &batch, count, axes->lane_parts[0], B);
    }
}

/* `tile` outputs from i on: the sums over places v = first, first + step, ... below K. */
CVOL_INLINE void cvol_split_sums(cvol_vf *sums, const float *in, long in_stride, int first,
                                 int step, int K, const float *basis, int M, int i, int tile)
{
    for (int t = 0; t < tile; t++)
        sums[t] = (cvol_vf){0};
    for (int v = first; v < K; v += step) {
        const cvol_vf line = cvol_load(in + v * in_stride);
        for (int t = 0; t < tile; t++)
            sums[t] += basis[v * M + i + t] * line;
    }
}

/* What the outputs of one half and quarter of an axis take: which bases, the lane axis' first half
 * by [0], and the places that reach them. own: all bits of the lanes of that first half. */
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

CVOL_INLINE void cvol_split_tile(float *out, long out_stride, const float *in, long in_stride,
                                 const cvol_split_reach *r, int i, int tile, int lanes)
{
    cvol_vf sums[4], others[4];
    cvol_split_sums(sums, in, in_stride, r->first[0], r->step[0], r->K, r->bases[0], r->M, i, tile);
    if (r->mixed) {
        cvol_split_sums(others, in, in_stride, r->first[1], r->step[1], r->K, r->bases[1], r->M, i,
                        tile);
        for (int t = 0; t < tile; t++)
            sums[t] = (cvol_vf)(((cvol_vi)sums[t] & r->own) | ((cvol_vi)others[t] & ~r->own));
    }
    for (int t = 0; t < tile; t++)
        if (lanes == CVOL_LANES)
            cvol_store(out + (i + t) * out_stride, sums[t]);
        else
            cvol_store_first(out + (i + t) * out_stride, sums[t], lanes);
}

CVOL_INLINE void cvol_split_lines(float *out, long out_stride, const float *in, long in_stride,
                                  const cvol_split_reach *reach, int begin, int end, int lanes)
{
    int i = begin;
    for (; i + 4 <= end; i += 4)
        cvol_split_tile(out, out_stride, in, in_stride, reach, i, 4, lanes);
    for (; i < end; i++)
        cvol_split_tile(out, out_stride, in, in_stride, reach, i, 1, lanes);
}

/* ---- at all 16 samples: the basis' symmetry within each part halves the work -------------------
 */

/* Half c of an axis whose octant is not split, from the places below K. */
CVOL_INLINE void cvol_split_eights(cvol_vf out[8], const float *in, long in_stride, int K, int c,
                                   const float *basis)
{
    cvol_vf even[4], odd[4];
    for (int t = 0; t < 4; t++)
        even[t] = odd[t] = (cvol_vf){0};
    for (int v = c; v < K; v += 4) {
        const cvol_vf line = cvol_load(in + v * in_stride);
        for (int t = 0; t < 4; t++)
            even[t] += basis[v * 16 + 8 * c + t] * line;
        if (v + 2 >= K)
            break;
        const cvol_vf next = cvol_load(in + (v + 2) * in_stride);
        for (int t = 0; t < 4; t++)
            odd[t] += basis[(v + 2) * 16 + 8 * c + t] * next;
    }
    for (int t = 0; t < 4; t++) {
        out[t] = even[t] + odd[t];
        out[7 - t] = even[t] - odd[t];
    }
}

/* The same where it is. */
CVOL_INLINE void cvol_split_fours(cvol_vf out[8], const float *in, long in_stride, int K, int c,
                                  const float *basis)
{
    for (int q = 0; q < 2; q++) {
        cvol_vf even[2] = {{0}, {0}}, odd[2] = {{0}, {0}};
        const float *at = basis + 8 * c + 4 * q;
        for (int v = c + 2 * q; v < K; v += 8) {
            const cvol_vf line = cvol_load(in + v * in_stride);
            for (int t = 0; t < 2; t++)
                even[t] += at[v * 16 + t] * line;
            if (v + 4 >= K)
                break;
            const cvol_vf next = cvol_load(in + (v + 4) * in_stride);
            for (int t = 0; t < 2; t++)
                odd[t] += at[(v + 4) * 16 + t] * next;
        }
        for (int t = 0; t < 2; t++) {
            out[4 * q + t] = even[t] + odd[t];
            out[4 * q + 3 - t] = even[t] - odd[t];
        }
    }
}

/* What the lanes of a vector are: all of octants that are not split, all of such that are, or the
 * first ones (`own`) of one kind, the others of the other. */
enum { CVOL_SPLIT_EIGHTS, CVOL_SPLIT_FOURS, CVOL_SPLIT_MIXED };

CVOL_INLINE void cvol_split_half_of(float *out, long out_stride, const float *in, long in_stride,
                                    int K, int c, const float *const parts[2], int kind,
                                    cvol_vi eights, int lanes)
{
    cvol_vf samples[8], others[8];
    if (kind != CVOL_SPLIT_FOURS)
        cvol_split_eights(samples, in, in_stride, K, c, parts[0]);
    if (kind == CVOL_SPLIT_FOURS)
        cvol_split_fours(samples, in, in_stride, K, c, parts[1]);
    if (kind == CVOL_SPLIT_MIXED) {
        cvol_split_fours(others, in, in_stride, K, c, parts[1]);
        for (int t = 0; t < 8; t++)
            samples[t] = cvol_select(eights, samples[t], others[t]);
    }
    for (int t = 0; t < 8; t++)
        if (lanes == CVOL_LANES)
            cvol_store(out + (8 * c + t) * out_stride, samples[t]);
        else
            cvol_store_first(out + (8 * c + t) * out_stride, samples[t], lanes);
}

/* Half c of an axis, for `count` vectors `line` floats apart. */
CVOL_INLINE void cvol_split_half(float *out, long out_line, long out_stride, const float *in,
                                 long in_line, long in_stride, int K, int c,
                                 const float *const parts[2], cvol_split_halves kinds, cvol_vi own,
                                 int count, int lanes)
{
    int kind = CVOL_SPLIT_MIXED;
    if (kinds.of[0] == kinds.of[1] || !cvol_any(~own))
        kind = kinds.of[0];
    else if (!cvol_any(own))
        kind = kinds.of[1];
    if (kind == CVOL_SPLIT_EIGHTS)
        for (int j = 0; j < count; j++)
            cvol_split_half_of(out + j * out_line, out_stride, in + j * in_line, in_stride, K, c,
                               parts, CVOL_SPLIT_EIGHTS, own, lanes);
    else if (kind == CVOL_SPLIT_FOURS)
        for (int j = 0; j < count; j++)
            cvol_split_half_of(out + j * out_line, out_stride, in + j * in_line, in_stride, K, c,
                               parts, CVOL_SPLIT_FOURS, own, lanes);
    else
        for (int j = 0; j < count; j++)
            cvol_split_half_of(out + j * out_line, out_stride, in + j * in_line, in_stride, K, c,
                               parts, CVOL_SPLIT_MIXED, kinds.of[0] ? ~own : own, lanes);
}

/* The first of M points across a cell that lies in quarter q. */
CVOL_INLINE int cvol_split_point(int M, int q)
{
    return (q * M + 1) / 4; /* the least i with (i + 1/2) 4 / M >= q: ceil(q M / 4 - 1/2) */
}

/* Whether sheets of this half are wanted. */
CVOL_INLINE int cvol_split_wants(const cvol_block_axes *axes, int half)
{
    return !axes->sheet_ends || axes->sheet_ends >> half & 1;
}

static void cvol_split_inverse(float *out, long row_stride, long sheet_stride,
                               const cvol_block *block, const cvol_block_axes *axes, float step,
                               cvol_block_work *work)
{
    enum { B = 16 };
    const int low_sheet = block->low[axes->sheet];
    const int rows = axes->row_points, sheets = axes->sheet_points;
    cvol_block_rows low_rows;
    if (axes->lane == 1)
        cvol_split_gather_lanes(work->first, &low_rows, block, axes, step, 1, 2, 0);
    else if (axes->sheet == 1)
        cvol_split_gather_lanes(work->first, &low_rows, block, axes, step, 0, 2, 1);
    else
        cvol_split_gather_lanes(work->first, &low_rows, block, axes, step, 0, 1, 2);
    for (int part = 0; part < axes->lane_points; part += CVOL_LANES) {
        const int lanes = axes->lane_points - part < CVOL_LANES ? axes->lane_points - part
                                                                : CVOL_LANES;
        cvol_vi own;
        for (int i = 0; i < CVOL_LANES; i++)
            own[i] = part + i < axes->lane_points / 2 ? -1 : 0;
        for (int s = 0; s < low_sheet && rows == B; s++)
            for (int c = 0; c < 2 && cvol_split_wants(axes, s & 1); c++)
                cvol_split_half(work->second + (long)s * B * B + part, 0, B,
                                work->first + (long)s * B * B + part, 0, B, low_rows.count[s], c,
                                axes->row_parts, cvol_split_lanes(block->split, axes, c, s & 1),
                                own, 1, CVOL_LANES);
        for (int s = 0; s < low_sheet && rows != B; s++)
            for (int q = 0; q < 4 && cvol_split_wants(axes, s & 1); q++) {
                const cvol_split_reach reach = cvol_split_reach_of(
                    axes->row_parts, cvol_split_lanes(block->split, axes, q >> 1, s & 1), q, rows,
                    low_rows.count[s], own);
                cvol_split_lines(work->second + (long)s * rows * B + part, B,
                                 work->first + (long)s * B * B + part, B, &reach,
                                 cvol_split_point(rows, q), cvol_split_point(rows, q + 1),
                                 CVOL_LANES);
            }
        for (int half = 0; half < 2 && sheets == B; half++)
            for (int c = 0; c < 2; c++)
                if (cvol_split_wants(axes, c))
                    cvol_split_half(out + half * rows / 2 * row_stride + part, row_stride,
                                    sheet_stride, work->second + half * rows / 2 * B + part, B,
                                    (long)rows * B, low_sheet, c, axes->sheet_parts,
                                    cvol_split_lanes(block->split, axes, half, c), own, rows / 2,
                                    lanes);
        for (int half = 0; half < 2 && sheets != B; half++)
            for (int q = 0; q < 4; q++) {
                const cvol_split_reach reach = cvol_split_reach_of(
                    axes->sheet_parts, cvol_split_lanes(block->split, axes, half, q >> 1), q,
                    sheets, low_sheet, own);
                for (int j = half * rows / 2; j < (half + 1) * rows / 2; j++)
                    cvol_split_lines(out + j * row_stride + part, sheet_stride,
                                     work->second + j * B + part, (long)rows * B, &reach,
                                     cvol_split_point(sheets, q), cvol_split_point(sheets, q + 1),
                                     lanes);
            }
    }
}

#endif
