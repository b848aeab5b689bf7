/* Converts an array with a separate background: evaluates the samples and transforms them again.
 *
 * For plain blocks, truncation loses up to half of the array's error bound. The bound grows by
 * half. The error itself grows by about an eighth, since the two errors rarely add up. */
#include <stdlib.h>

#include "array/core/array.h"
#include "array/core/summary.h"
#include "base/context.h"
#include "base/memory.h"
#include "cvol/algebra.h"

/* Evaluates the samples and transforms them. Drops terms that together are half of the error bound
 * of the samples. */
static int transform_again(cvol_context *context, cvol_array **out, float *samples,
                           const cvol_array *array)
{
    const size_t zero[3] = {0, 0, 0};
    const cvol_keep keep = cvol_keep_l2(array->error_bound.l2_error / 2);
    cvol_grid grid = array->grid;
    grid.type = CVOL_FLOAT32;
    int code = cvol_array_evaluate_real(context, samples, array, zero, grid.dims);
    if (!code)
        code = cvol_array_compress(context, out, samples, &grid, array->rank, array->transform,
                                   array->block, &keep);
    return code;
}

int cvol_array_flatten(cvol_context *context, cvol_array **out, const cvol_array *array)
{
    const size_t count = cvol_grid_samples(&array->grid);
    *out = NULL;
    if (!cvol_mask_is_background(array->mask))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "the array has no separate background");
    float *samples = cvol_allocate(count, sizeof *samples);
    if (!samples)
        return cvol_fail_memory(context, count * sizeof *samples, "the samples");
    const int code = transform_again(context, out, samples, array);
    free(samples);
    if (code)
        return code;
    cvol_error_bound *error_bound = &(*out)->error_bound;
    (*out)->grid.type = array->grid.type;
    cvol_error_bound_widen(error_bound, array->error_bound.l2_error,
                           cvol_error_bound_point(&array->error_bound));
    error_bound->value_min = array->error_bound.value_min;
    error_bound->value_max = array->error_bound.value_max;
    cvol_array_derive_figures(*out);
    return cvol_array_set_summary(context, *out, cvol_array_summary(array));
}
