/* Bounds of the errors of decoded samples, as cvol_array_evaluate_doubles returns them. */
#ifndef CVOL_ARRAY_EVALUATE_SAMPLE_ERRORS_H
#define CVOL_ARRAY_EVALUATE_SAMPLE_ERRORS_H

#include "array/core/array.h"

/* *all: of the L2 norm over all samples. *each: of every sample. */
void cvol_array_sample_errors(double *all, double *each, const cvol_array *array);

/* 1 if the separate background is that of the original samples. Operations and other types round
 * it. */
int cvol_array_has_exact_background(const cvol_array *array);

/* Bounds the error of every sample as its type stores it: integers are rounded and clamped after
 * their evaluation. */
double cvol_array_stored_error(const cvol_array *array);

#endif
