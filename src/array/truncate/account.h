/* Adds the losses of an operation to the error bound of its result. */
#ifndef CVOL_ARRAY_TRUNCATE_ACCOUNT_H
#define CVOL_ARRAY_TRUNCATE_ACCOUNT_H

#include "array/core/array.h"
#include "array/truncate/producer.h"

/* Adds the losses that one half reports to the result's error bound: dropped terms, and the
 * rounding of its terms, of its offset, and of factors of this norm. */
void cvol_array_account(cvol_array *array, const cvol_build_result *result, double factors);
/* The loss of transforms of this array, as a share of the L2 norm: CVOL_ROUNDING, and more for
 * whole arrays whose lengths have large prime factors. */
double cvol_array_rounding(const cvol_array *array);
/* The rounding of one evaluated sample of an array in blocks, by error_bound.max_abs. */
double cvol_array_sample_rounding(const cvol_array *array);
/* The L2 norm that L2 and PSNR allow to drop from an array; infinity under the other rules. */
double cvol_array_allowed(const cvol_array *array, const cvol_keep *keep);
/* CVOL_ERROR_DATA if a result of this shape and error bound exceeds the range of float32
 * arithmetic. */
int cvol_array_check_error_bound(cvol_context *context, const cvol_array *array,
                                 const cvol_error_bound *error_bound, const char *operation);

#endif
