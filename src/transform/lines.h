/* The inverse DCT along one axis of a block, for vectors of adjacent lines.
 *
 * It is evaluated at M points that are symmetric about the block's centre (M = B: its samples;
 * fewer: a coarser grid of the same span), from the frequencies 0 .. K - 1 only: out[i] = sum_{v <
 * K} basis[v M + i] in[v] The basis' symmetry basis[v][M - 1 - i] = (-1)^v basis[v][i] halves the
 * work: the sums over even and over odd v give out[i] by their sum and out[M - 1 - i] by their
 * difference.
 *
 * Only kernel files include this file: each compiles it for its instruction set.
 */
#ifndef CVOL_TRANSFORM_LINES_H
#define CVOL_TRANSFORM_LINES_H

#include <stddef.h>

#include "base/vector.h"

/* Outputs computed together: as many as fit into the registers. */
#ifdef __AVX512F__
#define CVOL_LINES_TILE 4
#else
#define CVOL_LINES_TILE 2
#endif

/* Sums of one line, `tile` of them. Not an array: the compiler would store it in memory until it
 * knows that a loop adding to it runs at all. */
typedef struct cvol_lines_accumulators {
    cvol_vf a, b, c, d;
} cvol_lines_accumulators;

CVOL_INLINE cvol_lines_accumulators cvol_lines_begin(cvol_vf start)
{
    return (cvol_lines_accumulators){start, start, start, start};
}

CVOL_INLINE void cvol_lines_add(cvol_lines_accumulators *sums, const float *weights, cvol_vf line,
                                int tile)
{
    sums->a += weights[0] * line;
    if (tile > 1)
        sums->b += weights[1] * line;
    if (tile > 2) {
        sums->c += weights[2] * line;
        sums->d += weights[3] * line;
    }
}

CVOL_INLINE void cvol_lines_end(cvol_vf near[CVOL_LINES_TILE], cvol_vf far[CVOL_LINES_TILE],
                                const cvol_lines_accumulators *even,
                                const cvol_lines_accumulators *odd, int tile)
{
    near[0] = even->a + odd->a;
    far[0] = even->a - odd->a;
    if (tile > 1) {
        near[1] = even->b + odd->b;
        far[1] = even->b - odd->b;
    }
#if CVOL_LINES_TILE > 2
    if (tile > 2) {
        near[2] = even->c + odd->c;
        far[2] = even->c - odd->c;
        near[3] = even->d + odd->d;
        far[3] = even->d - odd->d;
    }
#endif
}

/* `tile` outputs (1, 2, or all of a tile) from i0 on and their mirror images: `start` plus the
 * sums. Vectors of in lie in_stride floats apart. With `lines` 2, it also computes a second line,
 * `apart` floats further, with the same loads of the basis. */
CVOL_INLINE void cvol_lines_sums(cvol_vf near[][CVOL_LINES_TILE], cvol_vf far[][CVOL_LINES_TILE],
                                 int lines, ptrdiff_t apart, cvol_vf start, const float *in,
                                 ptrdiff_t in_stride, int K, const float *basis, int M, int i0,
                                 int tile)
{
    cvol_lines_accumulators even = cvol_lines_begin(start), odd = cvol_lines_begin((cvol_vf){0});
    cvol_lines_accumulators other_even = even, other_odd = odd; /* of the second line */
    int v = 0;
    for (; v + 1 < K; v += 2) {
        const float *at = in + v * in_stride, *of = basis + v * M + i0;
        const cvol_vf a = cvol_load(at), b = cvol_load(at + in_stride);
        cvol_lines_add(&even, of, a, tile);
        cvol_lines_add(&odd, of + M, b, tile);
        if (lines > 1) {
            cvol_lines_add(&other_even, of, cvol_load(at + apart), tile);
            cvol_lines_add(&other_odd, of + M, cvol_load(at + in_stride + apart), tile);
        }
    }
    if (v < K) {
        const float *at = in + v * in_stride, *of = basis + v * M + i0;
        cvol_lines_add(&even, of, cvol_load(at), tile);
        if (lines > 1)
            cvol_lines_add(&other_even, of, cvol_load(at + apart), tile);
    }
    cvol_lines_end(near[0], far[0], &even, &odd, tile);
    if (lines > 1)
        cvol_lines_end(near[1], far[1], &other_even, &other_odd, tile);
}

/* The same, and stores them: vectors of out lie out_stride floats apart; the first `lanes` of each
 * are stored. */
CVOL_INLINE void cvol_lines_tile(float *out, ptrdiff_t out_stride, const float *in,
                                 ptrdiff_t in_stride, int K, const float *basis, int M, int i0,
                                 int tile, int lanes)
{
    cvol_vf near[1][CVOL_LINES_TILE], far[1][CVOL_LINES_TILE];
    cvol_lines_sums(near, far, 1, 0, (cvol_vf){0}, in, in_stride, K, basis, M, i0, tile);
    for (int t = 0; t < tile; t++) {
        float *near_at = out + (i0 + t) * out_stride, *far_at = out + (M - 1 - i0 - t) * out_stride;
        if (lanes == CVOL_LANES) {
            cvol_store(near_at, near[0][t]);
            cvol_store(far_at, far[0][t]);
        } else {
            cvol_store_first(near_at, near[0][t], lanes);
            cvol_store_first(far_at, far[0][t], lanes);
        }
    }
}

/* All M outputs, M even. out and in may not overlap. */
CVOL_INLINE void cvol_lines_inverse(float *out, ptrdiff_t out_stride, const float *in,
                                    ptrdiff_t in_stride, int K, const float *basis, int M,
                                    int lanes)
{
    int i = 0;
    for (; i + CVOL_LINES_TILE <= M / 2; i += CVOL_LINES_TILE)
        cvol_lines_tile(out, out_stride, in, in_stride, K, basis, M, i, CVOL_LINES_TILE, lanes);
    for (; CVOL_LINES_TILE > 2 && i + 2 <= M / 2; i += 2)
        cvol_lines_tile(out, out_stride, in, in_stride, K, basis, M, i, 2, lanes);
    for (; i < M / 2; i++)
        cvol_lines_tile(out, out_stride, in, in_stride, K, basis, M, i, 1, lanes);
}

#endif
