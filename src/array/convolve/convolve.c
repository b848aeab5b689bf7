/* Convolution of arrays with kernels and with each other, and the gradient: checks, bounds, and the
 * choice of the half of the code.
 *
 * The bound of a * b (circular, N samples, orthonormal coefficients A, B; a~ the evaluated one):
 * convolving with a~ multiplies coefficients by sqrt(N) A~[u], so its L2 norm as an operator is
 * sqrt(N) max |A~[u]|. No coefficient is further from the exact one than the samples' L2 distance:
 * |B[u]| <= |B~[u]| + e_b. The identity a * b - a~ * b~ = a~ * (b - b~) + (a - a~) * b gives
 *     |a * b - a~ * b~|_2 <= sqrt(N) (max |A~| e_b + max |B~| e_a + e_a e_b).
 * At one sample it is at most |a~|_2 e_b + |b~|_2 e_a + e_a e_b, by Cauchy and Schwarz; the norm
 * |a~|_2 is at most sqrt(N) max |A~|.
 * Values: by interval arithmetic of N products, and by Cauchy and Schwarz, |(a * b)[x]| <= |a|_2
 * |b|_2.
 *
 * The bound of the gradient's length g: | |v| - |w| | <= |v - w| at each sample, and a central
 * difference has norm 1, so |g - g~|_2 <= sqrt(sum_axis weight^2) e_a, and so at each sample. */
#include <math.h>

#include "array/algebra/operations.h"
#include "array/algebra/result_mask.h"
#include "array/convolve/convolve.h"
#include "array/convolve/kernel.h"
#include "array/evaluate/decoded_terms.h"
#include "array/truncate/account.h"
#include "array/truncate/blocks_keep.h"
#include "array/truncate/producer.h"
#include "array/truncate/truncate.h"
#include "base/context.h"
#include "base/elementary.h"

/* Makes `array` the result; its error bound lacks only the dropped terms. */
static int finish(cvol_context *context, cvol_array **out, cvol_array *array,
                  const cvol_build_result *result, const char *operation)
{
    if (result->max_abs >= 0)
        array->error_bound.max_abs = fmin(array->error_bound.max_abs, result->max_abs);
    cvol_array_account(array, result, 0);
    int code = cvol_array_check_error_bound(context, array, &array->error_bound, operation);
    if (code)
        return code;
    cvol_array_derive_figures(array);
    *out = array;
    return CVOL_OK;
}

/* ---- kernels --------------------------------------------------------------------------------- */

static int check_kernel(cvol_context *context, const cvol_array *a, const cvol_kernel *kernel)
{
    int code = cvol_kernel_check(context, kernel);
    for (int axis = 0; axis < 3 && !code; axis++) {
        const int radius = cvol_kernel_radius(kernel, axis), width = 2 * radius + 1;
        if (axis >= a->rank && radius)
            code = cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "kernel is %d samples wide along %c, but the array has rank %d: make "
                             "the kernel for that rank",
                             width, "xyz"[axis], a -> rank);
        else if (a->block && radius > a->block)
            code = cvol_fail(
                context, CVOL_ERROR_ARGUMENT,
                "kernel is %d samples wide along %c and reaches beyond the next block of %d: use "
                "larger blocks or a whole array (block 0)",
                width, "xyz"[axis], a -> block);
    }
    return code;
}

/* The mask of the result. A background whose edge the kernel smooths away, to less than a step of
 * quantization, needs no mask: it would only take bytes. */
static int filter_mask(cvol_context *context, cvol_array *out, const cvol_array *a,
                       const cvol_kernel *kernel)
{
    const cvol_error_bound *bound = &a->error_bound;
    const double edge = cvol_kernel_outermost(kernel) * (bound->value_max - bound->value_min);
    size_t radius[3];
    for (int axis = 0; axis < 3; axis++)
        radius[axis] = (size_t)cvol_kernel_radius(kernel, axis);
    if (cvol_mask_is_background(a->mask) && edge < cvol_blocks_filter_step(out))
        return CVOL_OK;
    return cvol_result_mask_filter(context, out, a, radius, cvol_kernel_total(kernel));
}

int cvol_array_convolve_kernel(cvol_context *context, cvol_array **out, const cvol_array *a,
                               const cvol_kernel *kernel, const cvol_keep *keep)
{
    *out = NULL;
    const cvol_keep like = cvol_keep_like_inputs();
    const cvol_keep *rule = keep ? keep : &like;
    cvol_array *array = NULL;
    cvol_build_result result = {.max_abs = -1};
    double norm, sum;
    int code = cvol_array_decoded_terms(context, &a, a);
    if (!code)
        code = check_kernel(context, a, kernel);
    if (!code)
        code = cvol_array_create_like(context, &array, a);
    if (!code)
        code = cvol_keep_check(context, rule, array);
    if (code)
        goto done;
    cvol_rescale_set(array, a->grid.value_scale, a->grid.value_offset * cvol_kernel_total(kernel));
    cvol_kernel_bounds(kernel, &norm, &sum);
    array->error_bound = cvol_error_bound_filter(&a->error_bound, norm, sum,
                                                 cvol_kernel_total(kernel));
    code = cvol_array_check_error_bound(context, array, &array->error_bound, "convolve");
    if (code)
        goto done;
    code = filter_mask(context, array, a, kernel);
    if (code)
        goto done;
    code = a->block ? cvol_blocks_convolve_kernel(context, array, &result, a, kernel, rule)
                    : cvol_whole_convolve_kernel(context, array, &result, a, kernel, rule);
    result.gain = sum;
    if (!code)
        code = finish(context, out, array, &result, "convolve");
done:
    if (code)
        cvol_array_free(array);
    return code;
}

/* ---- array by array -------------------------------------------------------------------------- */

/* Bounds |A E|, with A an array's coefficients and E the error of the other one. At places that
 * both arrays have, E is at most the error on the support; elsewhere at most the whole error. */
static double error_of_product(const cvol_largest *A, const cvol_error_bound *other)
{
    return fmin(cvol_hypot(A->common * cvol_error_bound_support(other), A->alone * other->l2_error),
                fmax(A->common, A->alone) * other->l2_error);
}

static cvol_error_bound convolve_error_bound(const cvol_array *a, const cvol_largest *A,
                                             const cvol_array *b, const cvol_largest *B)
{
    const cvol_error_bound *x = &a->error_bound, *y = &b->error_bound;
    const double N = (double)cvol_grid_samples(&a->grid), root = sqrt(N);
    const double kept_a = sqrt(cvol_spectrum_energy(&a->whole));
    const double kept_b = sqrt(cvol_spectrum_energy(&b->whole));
    const cvol_error_bound product = cvol_error_bound_multiply(x, y); /* for its interval */
    const double exact = (kept_a + x->l2_error) * (kept_b + y->l2_error);
    cvol_error_bound out = {
        .l2_error = root *
                    (error_of_product(A, y) + error_of_product(B, x) + x->l2_error * y->l2_error),
        .point_error = (kept_a * y->l2_error + kept_b * x->l2_error) *
                           (1 + cvol_array_rounding(a)) +
                       x->l2_error * y->l2_error,
        .max_abs = fmin(kept_a * kept_b * (1 + cvol_array_rounding(a)),
                        N * cvol_error_bound_tighten(x) * cvol_error_bound_tighten(y)),
        .value_min = fmax(-exact, N * product.value_min),
        .value_max = fmin(exact, N * product.value_max)};
    return out;
}

/* A convolution of stored samples with an offset does not mean that of their values. */
static int convolve_values(cvol_context *context, cvol_array **out, const cvol_array *a,
                           const cvol_array *b, const cvol_keep *keep)
{
    cvol_array *x = NULL, *y = NULL;
    int code = cvol_array_of_values(context, &x, a);
    if (!code)
        code = cvol_array_of_values(context, &y, b);
    if (!code)
        code = cvol_array_convolve(context, out, x, y, keep);
    cvol_array_free(x);
    cvol_array_free(y);
    return code;
}

int cvol_array_convolve(cvol_context *context, cvol_array **out, const cvol_array *a,
                        const cvol_array *b, const cvol_keep *keep)
{
    *out = NULL;
    const cvol_keep like = cvol_keep_like_inputs();
    const cvol_keep *rule = keep ? keep : &like;
    int code = cvol_array_compatible(context, a, b);
    if (code)
        return code;
    if (a->block)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "convolve: arrays in blocks of %d are convolved with kernels only; two "
                         "arrays need to be whole (block 0), under dht or dft",
                         a->block);
    if (a->transform == CVOL_DCT)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "convolve: under dct arrays are mirrored about their ends, and the "
                         "convolution of two such arrays is about their samples, which dct cannot "
                         "hold; compress both with dht or dft");
    if (fabs(a->grid.value_offset) > 0 || fabs(b->grid.value_offset) > 0)
        return convolve_values(context, out, a, b, keep);
    cvol_array *array = NULL;
    cvol_build_result result = {.max_abs = -1};
    code = cvol_array_create_like(context, &array, a);
    if (!code)
        cvol_rescale_set(array, a->grid.value_scale * b->grid.value_scale, 0);
    if (!code)
        code = cvol_keep_check(context, rule, array);
    if (code)
        goto done;
    cvol_largest A, B;
    code = cvol_whole_largest_coefficients(context, &A, a, b);
    if (!code)
        code = cvol_whole_largest_coefficients(context, &B, b, a);
    if (code)
        goto done;
    array->error_bound = convolve_error_bound(a, &A, b, &B);
    code = cvol_array_check_error_bound(context, array, &array->error_bound, "convolve");
    if (!code)
        code = cvol_whole_convolve(context, array, &result, a, b, rule);
    if (!code)
        code = finish(context, out, array, &result, "convolve");
done:
    if (code)
        cvol_array_free(array);
    return code;
}

/* ---- gradient -------------------------------------------------------------------------------- */

int cvol_array_gradient(cvol_context *context, cvol_array **out, const cvol_array *a,
                        const cvol_keep *keep)
{
    *out = NULL;
    const cvol_keep like = cvol_keep_like_inputs();
    const cvol_keep *rule = keep ? keep : &like;
    cvol_array *array = NULL;
    cvol_build_result result = {.max_abs = -1};
    static const size_t around[3] = {1, 1, 1};
    double weight[3] = {0, 0, 0}, squares = 0;
    for (int axis = 0; axis < a->rank; axis++) {
        weight[axis] = 1 / a->grid.spacing[axis];
        squares += weight[axis] * weight[axis];
    }
    int code = cvol_array_decoded_terms(context, &a, a);
    if (!code)
        code = cvol_array_create_like(context, &array, a);
    if (!code)
        code = cvol_keep_check(context, rule, array);
    if (code)
        goto done;
    cvol_rescale_set(array, fabs(a->grid.value_scale), 0);
    const double norm = sqrt(squares);
    array->error_bound = (cvol_error_bound){
        .l2_error = norm * a->error_bound.l2_error,
        .point_error = norm * cvol_error_bound_point(&a->error_bound),
        .max_abs = norm * cvol_error_bound_tighten(&a->error_bound),
        .value_min = 0,
        .value_max = norm * (a->error_bound.value_max - a->error_bound.value_min) / 2};
    code = cvol_array_check_error_bound(context, array, &array->error_bound, "gradient");
    if (code)
        goto done;
    code = cvol_result_mask_filter(context, array, a, around, 0);
    if (code)
        goto done;
    code = a->block ? cvol_blocks_gradient(context, array, &result, a, weight, rule)
                    : cvol_whole_gradient(context, array, &result, a, weight, rule);
    result.gain = norm;
    if (!code)
        code = finish(context, out, array, &result, "gradient");
done:
    if (code)
        cvol_array_free(array);
    return code;
}
