/* Samples of volumes with the same bits on every processor: the base that the residual is added to.
 *
 * Coefficients are evaluated by integer arithmetic. With F fraction bits (a number per file), C the
 * matrix of the orthonormal DCT of M = 4, 8, 16 or 32 points times 2^20, rounded to integers, and
 * floor(a / 2^20 + 1/2) written round(a):
 *
 *     v[u, v, w] = 2^F q[u, v, w], and along x, then y, then z of each sub-block
 *     v[x, ..]   = round(sum over f of C[f][x] v[f, ..]).
 *
 * Lapped volumes then need the post-filter of transform/lap.h with h = H 2^20 rounded, across the
 * faces along x, then y, then z: d = round(h w), a1 += d0, a2 -= d0, a0 += d1, a3 -= d1. In the end
 *
 *     base = offset + (step 2^-F) v,
 *
 * one multiplication and one addition of doubles; clamped to value_min .. value_max; integer types:
 * floor(base + 1/2); float types: rounded to the type.
 *
 * The sum of a block's |q|, times 2^F, is at most 2^31. Then every v is below 2^32 and every sum
 * below 2^52. Doubles hold these exactly, in any order of addition, with or without fused
 * multiply-add. */
#ifndef CVOL_ARRAY_BLOCK_EXACT_H
#define CVOL_ARRAY_BLOCK_EXACT_H

#include "array/core/array.h"

enum { CVOL_EXACT_MATRIX_BITS = 20, CVOL_EXACT_SUM_BITS = 31, CVOL_EXACT_FRACTION_MAX = 10 };

/* The largest sum of |q| of a block of the array. */
uint64_t cvol_exact_largest_sum(const cvol_array *array);
/* The largest number of fraction bits that this sum allows, up to CVOL_EXACT_FRACTION_MAX; -1: not
 * even 0. */
int cvol_exact_fraction(uint64_t largest_sum);

/* The doubles of scratch that a box needs; 0 on overflow. */
size_t cvol_exact_scratch(const cvol_array *array, const size_t begin[3], const size_t end[3]);
/* Evaluates a box of a volume in DCT blocks of rank 3, x fastest: base as defined above; float
 * types: rounded to the type. The caller has checked the sums of blocks. One thread. The scratch is
 * 64-byte aligned. */
void cvol_exact_box(double *out, double *scratch, const cvol_array *array, int fraction,
                    const size_t begin[3], const size_t end[3]);
/* The same by the definition, on 64-bit integers; 0 if memory is short. */
int cvol_exact_box_reference(double *out, const cvol_array *array, int fraction,
                             const size_t begin[3], const size_t end[3]);

/* C[f][x] of M = 1 << log2, log2 = 2 .. 5, at f M + x; h. For tests and the reference. */
const int32_t *cvol_exact_matrix(int log2);
extern const int32_t cvol_exact_filter[4];

#endif
