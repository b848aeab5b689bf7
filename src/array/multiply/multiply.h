/* The plans of products (array/algebra/operations.h). */
#ifndef CVOL_ARRAY_MULTIPLY_MULTIPLY_H
#define CVOL_ARRAY_MULTIPLY_MULTIPLY_H

#include "array/truncate/account.h"
#include "array/truncate/producer.h"

/* One plan each; they resolve nothing: the caller has chosen. */
int cvol_multiply_direct(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_array *b, const cvol_keep *keep);
/* points[axis]: those of cvol_multiply_points, or dims: the plan `full`. */
int cvol_multiply_grid(cvol_context *context, cvol_array *out, cvol_build_result *result,
                       const cvol_array *a, const cvol_array *b, const size_t points[3],
                       const cvol_keep *keep);
/* *verified 0: nothing was made, an exact plan has to. It is not carried out if it would take more
 * than limit_ms on one thread, which is known once the supports have been looked at. */
int cvol_multiply_sparse(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_array *b, const cvol_keep *keep,
                         double limit_ms, int *verified);
int cvol_blocks_multiply(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_array *b, const cvol_keep *keep);

#endif
