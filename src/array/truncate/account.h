/* What an operation enters into the error bound of its result. */
#ifndef CVOL_ARRAY_TRUNCATE_ACCOUNT_H
#define CVOL_ARRAY_TRUNCATE_ACCOUNT_H

#include "array/core/array.h"
#include "array/truncate/producer.h"

/* Enters what a half reports into the result's error bound: what was dropped, and the rounding of
 * its terms, of its offset, and of factors of this norm. */
void cvol_array_account(cvol_array *array, const cvol_build_result *result, double factors);
/* What transforms of this array may lose, as a share of the L2 norm: CVOL_ROUNDING, and more for
 * whole arrays whose lengths have large prime factors. */
double cvol_array_rounding(const cvol_array *array);
/* CVOL_ERROR_DATA where a result of this shape and error bound is beyond what float32 computes
 * with. */
int cvol_array_check_error_bound(cvol_context *context, const cvol_array *array,
                                 const cvol_error_bound *error_bound, const char *operation);

#endif
