/* The common part of arrays made from values at points (interpolate_*.c). */
#ifndef CVOL_ARRAY_EVALUATE_INTERPOLATED_H
#define CVOL_ARRAY_EVALUATE_INTERPOLATED_H

#include "array/core/array.h"

/* Refuses values that are not finite: DATA. */
int cvol_interpolated_check_values(cvol_context *context, const float *values, size_t count);

/* Sets the error bound and the figures of a whole array whose terms are set. The exact array has
 * all terms; `dropped` is the L2 norm of those left out. Its samples are bounded by evaluating all
 * of them; above 2^24 samples, by the sum of the terms' magnitudes. Errors: MEMORY, DATA. */
int cvol_interpolated_finish(cvol_context *context, cvol_array *array, double dropped);

/* Sets sparse terms at rising places in an array without terms. Errors: MEMORY. */
int cvol_interpolated_set(cvol_context *context, cvol_array *array, const uint32_t *places,
                          const double *values, size_t count);

/* column[j]: the function of slot `place` of an array of rank 1 at x = start + j step. */
void cvol_interpolated_column(double *column, cvol_transform transform, size_t n, size_t place,
                              double start, double step, size_t count);

#endif
