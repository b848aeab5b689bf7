/* The interpolant of a whole array on a grid of another number of points: folds its spectrum onto
 * the grid, then one inverse transform there. */
#include <stdlib.h>
#include <string.h>

#include "array/core/array.h"
#include "array/evaluate/fold.h"
#include "base/context.h"
#include "base/memory.h"
#include "transform/fft.h"
#include "transform/whole.h"

int cvol_array_evaluate_grid(cvol_context *context, float *out, const cvol_array *array,
                             const size_t points[3])
{
    if (array->block)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "an array in blocks of %d cannot be evaluated on a grid of its own; that "
                         "takes a whole array (block 0), or resample",
                         array->block);
    size_t count = 1, bytes;
    int fits = 1;
    for (int a = 0; a < 3; a++) {
        if (!points[a])
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "points are %zux%zux%zu; they must be at least 1 per axis", points[0],
                             points[1], points[2]);
        fits = fits && cvol_size_multiply(&count, count, points[a]);
    }
    if (!fits || !cvol_size_multiply(&bytes, count, sizeof(float)))
        return cvol_fail(context, CVOL_ERROR_LIMIT, "a grid of %zux%zux%zu points is too large",
                         points[0], points[1], points[2]);
    float *slots = cvol_fft_allocate(count);
    if (!slots)
        return cvol_fail_memory(context, count * sizeof *slots, "a grid");
    memset(slots, 0, count * sizeof *slots);
    int code = cvol_fold(context, slots, points, &array->whole, array->transform, array->grid.dims);
    if (!code)
        code = cvol_report_progress(context, "evaluating", 0.3);
    if (!code)
        code = cvol_whole_inverse(context, array->transform, slots, slots, points);
    if (!code)
        memcpy(out, slots, count * sizeof *out);
    free(slots);
    return code;
}
