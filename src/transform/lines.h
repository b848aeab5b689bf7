/* The inverse DCT along one axis of a block, for whole vectors of neighbours at once.
 *
 * Evaluated at M points that lie symmetrically about the block's centre (M = B: its samples; fewer:
 * a coarser grid of the same span), from the frequencies 0 .. K - 1 alone:
 *     out[i] = sum_{v < K} basis[v M + i] in[v]
 * The basis' symmetry basis[v][M - 1 - i] = (-1)^v basis[v][i] halves the work: the sums over
 * even and over odd v give out[i] by their sum and out[M - 1 - i] by their difference.
 *
 * To be included by kernel files only: each compiles it for its instruction set.
 */
#ifndef CVOL_TRANSFORM_LINES_H
#define CVOL_TRANSFORM_LINES_H

#include "base/vector.h"

/* Outputs computed together: as many as the registers hold. */
#ifdef __AVX512F__
#define CVOL_LINES_TILE 4
#else
#define CVOL_LINES_TILE 2
#endif

/* `tile` outputs from i0 on and their mirror images: `start` and the sums. Vectors of in lie
 * in_stride floats apart. Of `lines` lines (1 or 2), `apart` floats apart: what is read of the
 * basis does for both. */
CVOL_INLINE void cvol_lines_sums(cvol_vf near[][CVOL_LINES_TILE], cvol_vf far[][CVOL_LINES_TILE],
                                 int lines, long apart, cvol_vf start, const float *in,
                                 long in_stride, int K, const float *basis, int M, int i0, int tile)
{
    cvol_vf even[2][CVOL_LINES_TILE], odd[2][CVOL_LINES_TILE], a[2], b[2];
    for (int n = 0; n < lines; n++)
        for (int t = 0; t < tile; t++) {
            even[n][t] = start;
            odd[n][t] = (cvol_vf){0};
        }
    int v = 0;
    for (; v + 1 < K; v += 2) {
        const float *at = in + v * in_stride, *of = basis + v * M + i0;
        for (int n = 0; n < lines; n++) {
            a[n] = cvol_load(at + n * apart);
            b[n] = cvol_load(at + in_stride + n * apart);
        }
        for (int t = 0; t < tile; t++)
            for (int n = 0; n < lines; n++) {
                even[n][t] += of[t] * a[n];
                odd[n][t] += of[M + t] * b[n];
            }
    }
    for (int n = 0; n < lines && v < K; n++) {
        a[n] = cvol_load(in + v * in_stride + n * apart);
        for (int t = 0; t < tile; t++)
            even[n][t] += basis[v * M + i0 + t] * a[n];
    }
    for (int n = 0; n < lines; n++)
        for (int t = 0; t < tile; t++) {
            near[n][t] = even[n][t] + odd[n][t];
            far[n][t] = even[n][t] - odd[n][t];
        }
}

/* The same, stored: vectors of out lie out_stride floats apart, `lanes` of each are stored. */
CVOL_INLINE void cvol_lines_tile(float *out, long out_stride, const float *in, long in_stride,
                                 int K, const float *basis, int M, int i0, int tile, int lanes)
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
CVOL_INLINE void cvol_lines_inverse(float *out, long out_stride, const float *in, long in_stride,
                                    int K, const float *basis, int M, int lanes)
{
    int i = 0;
    for (; i + CVOL_LINES_TILE <= M / 2; i += CVOL_LINES_TILE)
        cvol_lines_tile(out, out_stride, in, in_stride, K, basis, M, i, CVOL_LINES_TILE, lanes);
    for (; i < M / 2; i++)
        cvol_lines_tile(out, out_stride, in, in_stride, K, basis, M, i, 1, lanes);
}

#endif
