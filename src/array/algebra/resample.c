/* Half or twice the samples: the new grid, the bound, and the choice of the half of the code.
 *
 * Positions of the new samples, in old ones. Whole arrays under DFT and DHT: at 2 x and at x / 2;
 * the first sample stays in place. Whole arrays under DCT and arrays in blocks: at 2 x + 1/2 and at
 * x / 2 - 1/4, because samples are the middles of cells that are joined or halved; the origin moves
 * by that. An axis of length 1 is not halved.
 *
 * Norms per axis. Twice: sqrt 2 (band-limited: Parseval; linear at -1/4 and +1/4: the weights of
 * each old sample sum to 2, and squares are convex). Half, band-limited: sqrt(1/2), but 1 if the
 * new Nyquist term is a sum of two. Means of two: sqrt(1/2), but 1 if a last odd sample stays. The
 * sum of |taps| (array/evaluate/dirichlet.h) bounds the effect of band-limiting on values. */
#include <math.h>

#include "array/algebra/operations.h"
#include "array/algebra/result_mask.h"
#include "array/core/array.h"
#include "array/evaluate/decoded_terms.h"
#include "array/evaluate/dirichlet.h"
#include "array/truncate/account.h"
#include "array/truncate/producer.h"
#include "array/truncate/truncate.h"
#include "base/context.h"

/* The grid of the result, or ARGUMENT. */
static int new_grid(cvol_context *context, cvol_grid *out, const cvol_array *a, int factor)
{
    const int centred = a->block || a->transform == CVOL_DCT;
    *out = a->grid;
    for (int axis = 0; axis < a->rank; axis++) {
        const size_t n = a->grid.dims[axis];
        double move = 0;
        if (factor == 2) {
            if (n > SIZE_MAX / 2)
                return cvol_fail(context, CVOL_ERROR_LIMIT, "resample: dims[%d] is %zu, too large",
                                 axis, n);
            out->dims[axis] = 2 * n;
            out->spacing[axis] /= 2;
            move = -0.25;
        } else if (n > 1) {
            if (!a->block && n % 2)
                return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                                 "resample: dims[%d] is %zu; whole arrays are halved where dims "
                                 "are even or 1",
                                 axis, n);
            out->dims[axis] = (n + 1) / 2;
            out->spacing[axis] *= 2;
            move = 0.5;
        }
        for (int i = 0; i < 3 && centred; i++)
            out->origin[i] += move * a->grid.spacing[axis] * a->grid.direction[axis][i];
    }
    out->type = CVOL_FLOAT32;
    return CVOL_OK;
}

/* The norm and the sum of |taps| along one axis. */
static void axis_bounds(double *norm, double *sum, const cvol_array *a, size_t n, size_t n_new)
{
    const int mirrored = a->transform == CVOL_DCT, even = n % 2 == 0, new_even = n_new % 2 == 0;
    *norm = *sum = 1;
    if (n_new == n)
        return;
    if (n_new > n) {
        *norm = sqrt(2);
        if (!a->block)
            *sum = mirrored ? cvol_dirichlet_sum(2 * n, 2 * n - 1, 0.25, 0, 0)
                            : cvol_dirichlet_sum(n, even ? n - 1 : n, 0.5, even, (double)n / 2);
        *sum = fmax(*sum, 1); /* DFT, DHT: every other sample stays */
    } else if (a->block) {
        *norm = even ? sqrt(0.5) : 1;
    } else if (mirrored) {
        *norm = sqrt(0.5);
        *sum = cvol_dirichlet_sum(2 * n, 2 * n_new - 1, 0.5, 0, 0);
    } else {
        *norm = new_even ? 1 : sqrt(0.5);
        *sum = cvol_dirichlet_sum(n, new_even ? n_new - 1 : n_new, 0, new_even ? 2 : 0,
                                  (double)n_new / 2);
    }
}

int cvol_array_resample(cvol_context *context, cvol_array **out, const cvol_array *a, int factor,
                        const cvol_keep *keep)
{
    *out = NULL;
    const cvol_keep like = cvol_keep_like_inputs();
    const cvol_keep *rule = keep ? keep : &like;
    if (factor != 2 && factor != -2)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "resample: factor is %d, must be 2 (twice as many samples along each "
                         "axis) or -2 (half)",
                         factor);
    cvol_grid grid;
    cvol_array *array = NULL;
    cvol_build_result result = {.max_abs = -1};
    double norm = 1, sum = 1;
    int code = cvol_array_decoded_terms(context, &a, a);
    if (!code)
        code = new_grid(context, &grid, a, factor);
    if (!code)
        code = cvol_array_create_as(context, &array, &grid, a->rank, a->transform, a->block);
    if (!code)
        code = cvol_keep_check(context, rule, array);
    if (code)
        goto done;
    for (int axis = 0; axis < a->rank; axis++) {
        double axis_norm, axis_sum;
        axis_bounds(&axis_norm, &axis_sum, a, a->grid.dims[axis], grid.dims[axis]);
        norm *= axis_norm;
        sum *= axis_sum;
    }
    cvol_rescale_set(array, a->grid.value_scale, a->grid.value_offset);
    array->error_bound = cvol_error_bound_filter(&a->error_bound, norm, sum, 1);
    code = cvol_array_check_error_bound(context, array, &array->error_bound, "resample");
    if (code)
        goto done;
    code = cvol_result_mask_resample(context, array, a);
    if (code)
        goto done;
    code = a->block ? cvol_blocks_resample(context, array, &result, a, rule)
                    : cvol_whole_resample(context, array, &result, a, rule);
    if (code)
        goto done;
    if (result.max_abs >= 0)
        array->error_bound.max_abs = fmin(array->error_bound.max_abs, result.max_abs);
    cvol_array_account(array, &result, 0);
    code = cvol_array_check_error_bound(context, array, &array->error_bound, "resample");
    if (code)
        goto done;
    cvol_array_derive_figures(array);
    *out = array;
done:
    if (code)
        cvol_array_free(array);
    return code;
}
