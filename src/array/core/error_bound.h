/* The certified bound and the bounds of values, carried through operations (cvol/array.h).
 *
 * A cvol_error_bound describes an array a~ and the exact result a that it stands for:
 *     |a - a~|_2 <= l2_error,   |a~[x]| <= max_abs,   value_min <= a[x] <= value_max
 * Rounding of float32 arithmetic is covered by CVOL_ROUNDING of the norms involved.
 */
#ifndef CVOL_ARRAY_CORE_ERROR_BOUND_H
#define CVOL_ARRAY_CORE_ERROR_BOUND_H

#include "cvol/array.h"

typedef struct cvol_error_bound {
    double l2_error, max_abs, value_min, value_max;
    /* Whole arrays: the part of l2_error at the places that are kept, where it is known apart. */
    double support_error;
    int support_known;
} cvol_error_bound;

/* What single precision transforms and sums may lose, as a share of the L2 norm: the error grows
 * as sqrt(log n) times 2^-24 on average; this leaves room for the worst that tests found. */
#define CVOL_ROUNDING 1e-6

/* max(|value_min|, |value_max|): bounds the exact samples. */
double cvol_error_bound_largest(const cvol_error_bound *error_bound);
/* The best bound of |evaluated|: max_abs, or the exact samples' plus l2_error. */
double cvol_error_bound_tighten(const cvol_error_bound *error_bound);

/* What l2_error is at the places that are kept, at most. */
double cvol_error_bound_support(const cvol_error_bound *error_bound);

cvol_error_bound cvol_error_bound_add(double alpha, const cvol_error_bound *a, double beta,
                                      const cvol_error_bound *b);
cvol_error_bound cvol_error_bound_scale(double alpha, const cvol_error_bound *a, double beta);
/* norm: the operator's L2 norm (max |H|); sum: sum of |taps|, which bounds samples. */
cvol_error_bound cvol_error_bound_convolve(const cvol_error_bound *a, double norm, double sum);
/* The same with narrower values; total: sum of taps, which what all samples have in common is
 * multiplied by. */
cvol_error_bound cvol_error_bound_filter(const cvol_error_bound *a, double norm, double sum,
                                         double total);
cvol_error_bound cvol_error_bound_multiply(const cvol_error_bound *a, const cvol_error_bound *b);

/* Adds what truncation dropped (an L2 norm) and the rounding of what has this norm; a sample has
 * changed by `sample` at most, and by no more than all together. What was dropped is out of the
 * support, rounding is in it. */
void cvol_error_bound_drop(cvol_error_bound *error_bound, double dropped, double norm,
                           double sample);

/* CVOL_ERROR_DATA where a bound is beyond float32, with the operation's name. */
int cvol_error_bound_check(cvol_context *context, const cvol_error_bound *error_bound,
                           const char *operation);

#endif
