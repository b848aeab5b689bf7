/* Lapped volumes for tests: made, and evaluated as a whole, by their definition. */
#ifndef CVOL_TESTS_SUPPORT_LAPPED_H
#define CVOL_TESTS_SUPPORT_LAPPED_H

#include "array/core/array.h"

/* Samples (of float32) pre-filtered, transformed in cells of 16^3, split at random if `is_split`,
 * and quantized by this step. The error bound is measured; offset: of the array. */
cvol_array *support_lapped(cvol_context *context, const float *samples, const size_t dims[3],
                           double offset, double step, int is_split, uint64_t seed);

/* The evaluated volume without the offset: all blocks, post-filtered as a whole if it is lapped. */
void support_lapped_samples(float *out, const cvol_array *array);

#endif
