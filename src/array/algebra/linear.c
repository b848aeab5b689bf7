/* Public linear operations: checks, the shape of the result and its certified bound. */
#include <float.h>
#include <math.h>

#include "array/algebra/operations.h"
#include "array/algebra/result_mask.h"
#include "array/core/summary.h"
#include "array/evaluate/decoded_terms.h"
#include "array/truncate/account.h"
#include "array/truncate/producer.h"
#include "array/truncate/truncate.h"
#include "base/context.h"

static int check_factor(cvol_context *context, double value, const char *name)
{
    if (isfinite(value))
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s is %g, must be finite", name, value);
}

/* Creates an empty result with this error bound, after all checks. */
static int start(cvol_context *context, cvol_array **array, const cvol_array *like,
                 const cvol_error_bound *error_bound, const cvol_keep *keep, const char *operation)
{
    int code = cvol_array_check_error_bound(context, like, error_bound, operation);
    if (!code)
        code = cvol_keep_check(context, keep, like);
    if (!code)
        code = cvol_array_create_like(context, array, like);
    if (!code)
        (*array)->error_bound = *error_bound;
    return code;
}

/* Passes on the result, or frees it after a failure. */
static int finish(cvol_context *context, cvol_array **out, cvol_array *array,
                  const cvol_build_result *result, const char *operation, int code)
{
    if (!code && !(result->norm <= (double)FLT_MAX))
        code = cvol_fail(context, CVOL_ERROR_DATA,
                         "%s: coefficients beyond what float32 holds (%g); scale the operands down "
                         "first",
                         operation, (double)FLT_MAX);
    if (!code) {
        if (result->max_abs >= 0)
            array->error_bound.max_abs = fmin(array->error_bound.max_abs, result->max_abs);
        cvol_array_account(array, result, 0);
        code = cvol_array_check_error_bound(context, array, &array->error_bound, operation);
    }
    if (code) {
        cvol_array_free(array);
        return code;
    }
    cvol_array_derive_figures(array);
    *out = array;
    return CVOL_OK;
}

static int scale(cvol_context *context, cvol_array **out, double alpha, const cvol_array *a,
                 double beta, const char *operation)
{
    const cvol_keep like = cvol_keep_like_inputs();
    cvol_build_result result = {0};
    cvol_array *array = NULL;
    *out = NULL;
    int code = check_factor(context, alpha, "alpha");
    if (!code)
        code = check_factor(context, beta, "beta");
    if (!code)
        code = cvol_array_decoded_terms(context, &a, a);
    if (code)
        return code;
    const cvol_error_bound error_bound = cvol_error_bound_scale(alpha, &a->error_bound, beta);
    code = start(context, &array, a, &error_bound, &like, operation);
    if (code)
        return code;
    cvol_rescale_set(array, a->grid.value_scale, alpha * a->grid.value_offset);
    const cvol_summary summary = cvol_summary_scale(cvol_array_summary(a), alpha, beta);
    code = cvol_array_set_summary(context, array, &summary);
    if (!code)
        code = cvol_result_mask_scale(context, array, a, alpha, beta);
    if (!code)
        code = a->block ? cvol_blocks_scale(context, array, &result, alpha, a, beta)
                        : cvol_whole_scale(context, array, &result, alpha, a, beta);
    return finish(context, out, array, &result, operation, code);
}

int cvol_array_of_values(cvol_context *context, cvol_array **out, const cvol_array *a)
{
    const int code = scale(context, out, a->grid.value_scale, a, a->grid.value_offset, "rescale");
    if (!code)
        cvol_rescale_set(*out, 1, 0);
    return code;
}

/* Stored samples that mean values in different ways cannot be added. */
static int add_values(cvol_context *context, cvol_array **out, double alpha, const cvol_array *a,
                      double beta, const cvol_array *b, const cvol_keep *keep)
{
    cvol_array *x = NULL, *y = NULL;
    int code = cvol_array_of_values(context, &x, a);
    if (!code)
        code = cvol_array_of_values(context, &y, b);
    if (!code)
        code = cvol_array_add(context, out, alpha, x, beta, y, keep);
    cvol_array_free(x);
    cvol_array_free(y);
    return code;
}

int cvol_array_add(cvol_context *context, cvol_array **out, double alpha, const cvol_array *a,
                   double beta, const cvol_array *b, const cvol_keep *keep)
{
    const cvol_keep like = cvol_keep_like_inputs();
    cvol_build_result result = {0};
    cvol_array *array = NULL;
    *out = NULL;
    keep = keep ? keep : &like;
    int code = check_factor(context, alpha, "alpha");
    if (!code)
        code = check_factor(context, beta, "beta");
    if (!code)
        code = cvol_array_compatible(context, a, b);
    if (!code && !cvol_rescale_is_same(a, b))
        return add_values(context, out, alpha, a, beta, b, keep);
    if (!code)
        code = cvol_array_decoded_terms(context, &a, a);
    if (!code)
        code = cvol_array_decoded_terms(context, &b, b);
    if (code)
        return code;
    if (a == b && a->block && keep->rule == CVOL_KEEP_LIKE_INPUTS) /* loses nothing */
        return scale(context, out, alpha + beta, a, 0, "add");
    const cvol_error_bound error_bound = cvol_error_bound_add(alpha, &a->error_bound, beta,
                                                              &b->error_bound);
    code = start(context, &array, a, &error_bound, keep, "add");
    if (code)
        return code;
    cvol_rescale_set(array, a->grid.value_scale,
                     alpha * a->grid.value_offset + beta * b->grid.value_offset);
    code = a->block ? cvol_blocks_add(context, array, &result, alpha, a, beta, b, keep)
                    : cvol_whole_add(context, array, &result, alpha, a, beta, b, keep);
    return finish(context, out, array, &result, "add", code);
}

int cvol_array_scale(cvol_context *context, cvol_array **out, double alpha, const cvol_array *a,
                     double beta)
{
    return scale(context, out, alpha, a, beta, "scale");
}

int cvol_array_negate(cvol_context *context, cvol_array **out, const cvol_array *a)
{
    return scale(context, out, -1, a, 0, "negate");
}

int cvol_array_one_minus(cvol_context *context, cvol_array **out, const cvol_array *a)
{
    return scale(context, out, -1, a, 1, "one minus");
}

/* Returns 1 if the low box of `out` has places that `a` did not keep. */
static int low_box_grew(const cvol_array *out, const cvol_array *a)
{
    const cvol_spectrum *x = &out->whole, *y = &a->whole;
    int grew = 0;
    for (int i = 0; i < 3 && x->low_count; i++)
        grew |= !y->low_count || x->low[i] > y->low[i];
    return grew;
}

int cvol_array_truncate(cvol_context *context, cvol_array **out, const cvol_array *a,
                        const cvol_keep *keep)
{
    const cvol_keep like = cvol_keep_like_inputs();
    cvol_build_result result = {0};
    cvol_array *array = NULL;
    *out = NULL;
    keep = keep ? keep : &like;
    int code = cvol_array_decoded_terms(context, &a, a);
    if (!code)
        code = start(context, &array, a, &a->error_bound, keep, "truncate");
    if (code)
        return code;
    cvol_rescale_set(array, a->grid.value_scale, a->grid.value_offset);
    code = cvol_array_set_summary(context, array, cvol_array_summary(a));
    if (!code)
        code = cvol_result_mask_scale(context, array, a, 1, 0);
    if (!code)
        code = a->block ? cvol_blocks_truncate(context, array, &result, a, keep)
                        : cvol_whole_truncate(context, array, &result, a, keep);
    if (low_box_grew(array, a))
        array->error_bound.support_known = 0;
    return finish(context, out, array, &result, "truncate", code);
}
