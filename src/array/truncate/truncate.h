/* Selects the terms of a whole array by a cvol_keep. */
#ifndef CVOL_ARRAY_TRUNCATE_TRUNCATE_H
#define CVOL_ARRAY_TRUNCATE_TRUNCATE_H

#include "array/core/array.h"
#include "array/truncate/candidates.h"

/* Fills array->whole (which must be empty) with the candidates that `keep` (any rule except
 * LIKE_INPUTS and STEP) selects; *dropped is the exact L2 norm of the others. Under DFT both slots
 * of a pair are kept or dropped together, by the pair's magnitude. Errors: ARGUMENT, TARGET,
 * MEMORY. */
int cvol_truncate(cvol_context *context, cvol_array *array, double *dropped,
                  const cvol_candidates *candidates, const cvol_keep *keep);

/* Checks a keep against an array's shape: k within the axes, s at most N, finite positive values,
 * rules that apply. Errors: ARGUMENT. */
int cvol_keep_check(cvol_context *context, const cvol_keep *keep, const cvol_array *shape);

#endif
