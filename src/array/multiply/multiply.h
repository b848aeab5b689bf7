/* The plans of products (array/algebra/operations.h). */
#ifndef CVOL_ARRAY_MULTIPLY_MULTIPLY_H
#define CVOL_ARRAY_MULTIPLY_MULTIPLY_H

#include "array/multiply/low.h"
#include "array/truncate/account.h"
#include "array/truncate/producer.h"

/* One plan each; they do not resolve LIKE_INPUTS: the caller does. */
int cvol_multiply_direct(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_array *b, const cvol_keep *keep);
/* points[axis]: of cvol_multiply_points, or dims: the plan `full`. */
int cvol_multiply_grid(cvol_context *context, cvol_array *out, cvol_build_result *result,
                       const cvol_array *a, const cvol_array *b, const size_t points[3],
                       const cvol_keep *keep);
/* The plan `low` (low.h): a cut that cvol_low_choose made. */
int cvol_multiply_low(cvol_context *context, cvol_array *out, cvol_build_result *result,
                      const cvol_array *a, const cvol_array *b, const cvol_low_cut *cut,
                      const cvol_keep *keep, size_t points[3]);
/* *verified 0: nothing was computed, and an exact plan must run. The plan stops if it would take
 * more than limit_ms on one thread, which it knows after it examined the supports. */
int cvol_multiply_sparse(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_array *b, const cvol_keep *keep,
                         double limit_ms, int *verified);
int cvol_blocks_multiply(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_array *b, const cvol_keep *keep);

#endif
