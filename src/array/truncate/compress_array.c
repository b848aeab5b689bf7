/* Compresses samples to an array of any rank, transform and block, by truncation.
 *
 * The bound: dropped terms, by Parseval, and CVOL_ROUNDING of the norm. The error of a sample is at
 * most the L2 norm of all errors, which bounds the evaluated samples. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/summary.h"
#include "array/truncate/account.h"
#include "array/truncate/compress_array.h"
#include "array/truncate/producer.h"
#include "array/truncate/truncate.h"
#include "base/context.h"
#include "base/memory.h"

/* Finds the samples' range; the squares of all samples must fit into float32. */
static int find_range(cvol_context *context, cvol_error_bound *error_bound, const void *samples,
                      const cvol_grid *grid)
{
    *error_bound = (cvol_error_bound){0};
    int code = cvol_scan_samples(context, &error_bound->value_min, &error_bound->value_max, samples,
                                 grid);
    if (code)
        return code;
    error_bound->max_abs = cvol_error_bound_largest(error_bound);
    const double most = sqrt((double)FLT_MAX / (double)cvol_grid_samples(grid));
    if (error_bound->max_abs > most)
        return cvol_fail(context, CVOL_ERROR_DATA,
                         "samples reach from %g to %g: squares of %zu samples beyond %g overflow "
                         "single precision; scale them down first",
                         error_bound->value_min, error_bound->value_max, cvol_grid_samples(grid),
                         most);
    return CVOL_OK;
}

static int summarise(cvol_context *context, cvol_array *array, const void *samples)
{
    cvol_summary summary;
    const int code = cvol_summarise_samples(context, &summary, samples, &array->grid, NULL);
    return code ? code : cvol_array_set_summary(context, array, &summary);
}

int cvol_array_compress(cvol_context *context, cvol_array **out, const void *samples,
                        const cvol_grid *grid, int rank, cvol_transform transform, int block,
                        const cvol_keep *keep)
{
    cvol_build_result result;
    *out = NULL;
    if (keep->rule == CVOL_KEEP_LIKE_INPUTS)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "compressing has no inputs for keep rule LIKE_INPUTS: choose another one");
    cvol_array *array;
    int code = cvol_array_create_as(context, &array, grid, rank, transform, block);
    if (code)
        return code;
    code = cvol_keep_check(context, keep, array);
    if (!code)
        code = find_range(context, &array->error_bound, samples, grid);
    if (!code && cvol_array_is_volume(array))
        code = summarise(context, array, samples);
    if (!code)
        code = block ? cvol_blocks_compress(context, array, &result, samples, keep)
                     : cvol_whole_compress(context, array, &result, samples, keep);
    if (code) {
        cvol_array_free(array);
        return code;
    }
    array->error_bound.support_known = !block; /* dropped terms lie elsewhere */
    cvol_array_account(array, &result, 0);
    cvol_array_derive_figures(array);
    *out = array;
    return CVOL_OK;
}

int cvol_array_compress_padded(cvol_context *context, cvol_array **out, const void *samples,
                               const cvol_grid *grid, int rank, cvol_transform transform,
                               const cvol_keep *keep)
{
    *out = NULL;
    if (rank < 1 || rank > 3)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "rank is %d, must be 1, 2 or 3", rank);
    int code = cvol_grid_check(context, grid, "array");
    if (code)
        return code;
    cvol_grid padded = *grid;
    for (int a = 0; a < rank; a++)
        padded.dims[a] *= 2;
    code = cvol_grid_check(context, &padded, "padded array");
    if (code)
        return code;
    const size_t size = cvol_type_size(grid->type), *dims = grid->dims;
    uint8_t *copy = cvol_allocate_zero(cvol_grid_samples(&padded), size);
    if (!copy)
        return cvol_fail_memory(context, cvol_grid_bytes(&padded), "padded samples");
    for (size_t z = 0; z < dims[2]; z++)
        for (size_t y = 0; y < dims[1]; y++)
            memcpy(copy + size * padded.dims[0] * (y + padded.dims[1] * z),
                   (const uint8_t *)samples + size * dims[0] * (y + dims[1] * z), size * dims[0]);
    code = cvol_array_compress(context, out, copy, &padded, rank, transform, 0, keep);
    free(copy);
    return code;
}
