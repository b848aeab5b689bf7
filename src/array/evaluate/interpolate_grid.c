/* From values on a grid of points to the array that passes through them: one transform there, and
 * its spectrum padded with zeros to the finer grid (array/evaluate/fold.h). */
#include <stdlib.h>
#include <string.h>

#include "array/evaluate/fold.h"
#include "array/evaluate/interpolated.h"
#include "array/truncate/candidates.h"
#include "array/truncate/truncate.h"
#include "base/context.h"
#include "transform/fft.h"
#include "transform/whole.h"

/* All N slots of a shape as the low box of a spectrum, which borrows them. */
static cvol_spectrum borrow_slots(float *slots, cvol_transform transform, const size_t dims[3])
{
    cvol_spectrum out = {.low_values = slots, .low_count = 1};
    for (int a = 0; a < 3; a++) {
        out.low[a] = transform == CVOL_DCT ? dims[a] : dims[a] / 2 + 1;
        out.box[a] = dims[a];
        out.low_count *= dims[a];
    }
    return out;
}

static int check_points(cvol_context *context, const size_t points[3], const cvol_grid *grid)
{
    for (int a = 0; a < 3; a++)
        if (!points[a] || points[a] > grid->dims[a])
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "%zu points on axis %c, must be 1 .. %zu, its samples", points[a],
                             "xyz"[a], grid -> dims[a]);
    return CVOL_OK;
}

int cvol_array_interpolate_grid(cvol_context *context, cvol_array **out, const float *values,
                                const size_t points[3], const cvol_grid *grid, int rank,
                                cvol_transform transform, const cvol_keep *keep)
{
    const cvol_keep all = cvol_keep_all();
    const size_t *dims = grid->dims;
    cvol_array *array;
    float *slots = NULL, *box = NULL;
    *out = NULL;
    keep = keep ? keep : &all;
    int code = cvol_array_create_as(context, &array, grid, rank, transform, 0);
    if (code)
        return code;
    code = check_points(context, points, grid);
    if (!code)
        code = cvol_keep_check(context, keep, array);
    if (code)
        goto done;
    const size_t count = points[0] * points[1] * points[2];
    code = cvol_interpolated_check_values(context, values, count);
    if (code)
        goto done;

    cvol_candidates candidates = {0};
    size_t stored = 1;
    for (int a = 0; a < 3; a++) {
        candidates.low[a] = transform == CVOL_DCT ? points[a] : points[a] / 2 + 1;
        candidates.box[a] = candidates.low[a];
        if (transform != CVOL_DCT) /* with both ends of points / 2, if the grid has them */
            candidates.box[a] = 2 * candidates.low[a] - 1 < dims[a] ? 2 * candidates.low[a] - 1
                                                                    : dims[a];
        stored *= candidates.box[a];
    }
    slots = cvol_fft_allocate(count);
    box = cvol_fft_allocate(stored);
    if (!slots || !box) {
        code = cvol_fail_memory(context, (count + stored) * sizeof *box, "a spectrum");
        goto done;
    }
    memcpy(slots, values, count * sizeof *slots);
    memset(box, 0, stored * sizeof *box);
    code = cvol_whole_forward(context, transform, slots, slots, points);
    if (!code)
        code = cvol_report_progress(context, "interpolating", 0.5);
    const cvol_spectrum spectrum = borrow_slots(slots, transform, points);
    if (!code)
        code = cvol_fold_into_box(context, box, candidates.low, candidates.box, dims, &spectrum,
                                  transform, points);
    candidates.slots = box;
    double dropped = 0;
    if (!code)
        code = cvol_truncate(context, array, &dropped, &candidates, keep);
    if (!code)
        code = cvol_interpolated_finish(context, array, dropped);
done:
    free(slots);
    free(box);
    if (code)
        cvol_array_free(array);
    else
        *out = array;
    return code;
}
