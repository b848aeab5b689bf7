/* The certified bound and the bounds of values, propagated through operations (cvol/array.h).
 *
 * A cvol_error_bound describes an array a~ and the exact result a:
 *     |a - a~|_2 <= l2_error,   |a[x] - a~[x]| <= point_error,   |a~[x]| <= max_abs,
 *     value_min <= a[x] <= value_max
 * CVOL_ROUNDING of the norms involved covers the rounding of float32 arithmetic. */
#ifndef CVOL_ARRAY_CORE_ERROR_BOUND_H
#define CVOL_ARRAY_CORE_ERROR_BOUND_H

#include "cvol/array.h"

typedef struct cvol_error_bound {
    double l2_error, max_abs, value_min, value_max;
    double point_error;  /* 0: not known; read it with cvol_error_bound_point */
    double default_loss; /* the part of l2_error that the default truncation of operations added */
    /* Whole arrays: the part of l2_error at the kept places, if it is known separately. */
    double support_error;
    int support_known;
} cvol_error_bound;

/* The loss of single precision transforms and sums, as a share of the L2 norm. The error grows as
 * sqrt(log n) times 2^-24 on average; this has a margin for the worst case that tests found. */
#define CVOL_ROUNDING 1e-6

/* The loss of single precision at one sample of a block, as a share of the largest magnitude of its
 * samples. A tenth of it is typical. */
#define CVOL_SAMPLE_ROUNDING 1e-5

/* Bounds |a[x] - a~[x]| at every sample: point_error, or l2_error if that is smaller or the other
 * one is not known. So code that knows no bound of samples leaves point_error 0. */
double cvol_error_bound_point(const cvol_error_bound *error_bound);
/* Adds a further error of this L2 norm, which is at most `point` at every sample. */
void cvol_error_bound_widen(cvol_error_bound *error_bound, double l2, double point);

/* The L2 norm of samples with this sum of squares, of which `largest` is the largest magnitude; a
 * bound of it if squares underflow (magnitudes below 1e-154) or overflow (above 1e154). */
double cvol_norm_of_squares(double squares, double largest, double samples);

/* max(|value_min|, |value_max|): bounds the exact samples. */
double cvol_error_bound_largest(const cvol_error_bound *error_bound);
/* The best bound of |evaluated|: max_abs, or the bound of the exact samples plus l2_error. */
double cvol_error_bound_tighten(const cvol_error_bound *error_bound);

/* The largest possible l2_error at the kept places. */
double cvol_error_bound_support(const cvol_error_bound *error_bound);

cvol_error_bound cvol_error_bound_add(double alpha, const cvol_error_bound *a, double beta,
                                      const cvol_error_bound *b);
cvol_error_bound cvol_error_bound_scale(double alpha, const cvol_error_bound *a, double beta);
/* norm: the operator's L2 norm (max |H|); sum: sum of |taps|, which bounds samples and their
 * errors. */
cvol_error_bound cvol_error_bound_convolve(const cvol_error_bound *a, double norm, double sum);
/* The same with narrower values; total: sum of taps, the factor of a constant. */
cvol_error_bound cvol_error_bound_filter(const cvol_error_bound *a, double norm, double sum,
                                         double total);
cvol_error_bound cvol_error_bound_multiply(const cvol_error_bound *a, const cvol_error_bound *b);

/* Adds dropped terms (an L2 norm) and the rounding of terms with this norm. A sample has changed by
 * `sample` at most, rounding included, and by no more than the sum of both. Dropped terms are
 * outside the support, rounding is in it. */
void cvol_error_bound_drop(cvol_error_bound *error_bound, double dropped, double norm,
                           double sample);

/* CVOL_ERROR_DATA if a bound exceeds float32, with the operation's name. */
int cvol_error_bound_check(cvol_context *context, const cvol_error_bound *error_bound,
                           const char *operation);

#endif
