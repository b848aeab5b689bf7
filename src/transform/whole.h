/* The transforms of whole arrays, orthonormal, any length, rank 1 to 3 (dims beyond it are 1).
 *
 * All three are stored as one real orthonormal vector of N = nx ny nz *slots*, in the samples'
 * index order, so norms, inner products and truncation are the same for all:
 *
 *     DCT  slot[u, v, w] = A[u, v, w]
 *     DHT  slot[u, v, w] = A[u, v, w] = Re F - Im F
 *     DFT  slot[p] = sqrt 2 Re F[p],  slot[-p] = sqrt 2 Im F[p]     for the first p of a pair (p,
 * -p) slot[p] = F[p]                                           where p = -p
 *
 * F is the orthonormal DFT, -p = ((nx - u) % nx, ...) the mirror place. p is the first of its pair
 * if 2 u < n on the first axis (x, y, z) on which u is not its own mirror.
 * So under DHT slot[p] = (a - b) / sqrt 2 and slot[-p] = (a + b) / sqrt 2 where a and b are the
 * DFT's.
 */
#ifndef CVOL_TRANSFORM_WHOLE_H
#define CVOL_TRANSFORM_WHOLE_H

#include "cvol/array.h"

/* out may be in; else in stays unchanged. Both as cvol_fft_allocate gives them. DHT and DFT take a
 * buffer of 4 N bytes. Errors: MEMORY, LIMIT. */
int cvol_whole_forward(cvol_context *context, cvol_transform transform, float *slots,
                       float *samples, const size_t dims[3]);
int cvol_whole_inverse(cvol_context *context, cvol_transform transform, float *samples,
                       float *slots, const size_t dims[3]);

/* The direct sums in double precision, O(N^2): the reference. out and in may not overlap. */
void cvol_whole_forward_reference(cvol_transform transform, double *slots, const double *samples,
                                  const size_t dims[3]);
void cvol_whole_inverse_reference(cvol_transform transform, double *samples, const double *slots,
                                  const size_t dims[3]);

/* Converts between slots (DFT or DHT) and the half complex array of cvol_fft, times `scale`. The
 * two may not overlap. */
void cvol_slots_from_half(cvol_transform transform, float *slots, const float *half,
                          const size_t dims[3], float scale);
void cvol_half_from_slots(cvol_transform transform, float *half, const float *slots,
                          const size_t dims[3], float scale);

/* ---- places ---------------------------------------------------------------------------------- */

static inline size_t cvol_mirror_index(size_t u, size_t n)
{
    return u ? n - u : 0;
}

/* +1: the first of its pair; -1: the second; 0: its own mirror. */
static inline int cvol_place_order(const size_t place[3], const size_t dims[3])
{
    for (int a = 0; a < 3; a++)
        if (place[a] && 2 * place[a] != dims[a])
            return 2 * place[a] < dims[a] ? 1 : -1;
    return 0;
}

/* |signed frequency| of an index. */
static inline size_t cvol_frequency(size_t u, size_t n)
{
    return 2 * u <= n ? u : n - u;
}

#endif
