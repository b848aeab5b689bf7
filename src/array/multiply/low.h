/* The plan `low`: the product of the operands' low frequencies on a small grid, within a bound.
 *
 * Real data compressed to k low and s scattered terms has a few weak terms at high frequencies,
 * which force the plans `grid` and `full` to evaluate all samples. This plan leaves out the terms
 * of both operands beyond a box of E frequencies per axis, and multiplies the rest on the grid that
 * holds sums of 2 E. */
#ifndef CVOL_ARRAY_MULTIPLY_LOW_H
#define CVOL_ARRAY_MULTIPLY_LOW_H

#include "array/core/array.h"
#include "array/multiply/cost.h"

/* What the plan may leave out. */
typedef struct cvol_low_limits {
    double lost;      /* bounds |a b - a' b'|_2 */
    double beyond[2]; /* bounds |a - a'|_2 and |b - b'|_2 */
} cvol_low_limits;

/* A choice of the box. */
typedef struct cvol_low_cut {
    size_t extent[2][3]; /* the highest frequencies of a' and b' */
    size_t kept[3];      /* terms of the product from this frequency on are dropped, if not 0 */
    double lost;         /* bounds |a b - a' b'|_2; a', b': what remains of a and b */
    double beyond[2];    /* |a - a'|_2, |b - b'|_2 */
} cvol_low_cut;

/* The limits for a result whose bound is that of the exact product. allowed: the L2 norm that the
 * caller allows to drop; negative: the default of operations. Returns 0 if the plan does not apply:
 * `allowed` is infinite. */
int cvol_low_limits_of(cvol_low_limits *out, const cvol_array *product, double allowed,
                       const cvol_array *a, const cvol_array *b);

/* Chooses the cheapest box within the limits: at worst all frequencies. extent: of a and b,
 * see cvol_spectrum_extent. Cost: O(n_a + n_b). Errors:
 * MEMORY. */
int cvol_low_choose(cvol_context *context, cvol_low_cut *out, const cvol_array *a,
                    const cvol_array *b, size_t extent[2][3], const cvol_low_limits *limits);

/* The low box of the product's terms that may be kept; 0: all may. */
void cvol_low_candidates(size_t most[3], const cvol_low_cut *cut, const cvol_keep *keep);

/* The terms of `whole` up to `extent`, as a low box. Errors: MEMORY. */
int cvol_low_spectrum(cvol_context *context, cvol_spectrum *out, const cvol_array *array,
                      const size_t extent[3]);

#endif
