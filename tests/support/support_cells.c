#include "test.h"

#include "support_cells.h"

#include "cvol/algebra.h"

int cell_add(cvol_context *context, cvol_array **result, const cvol_array *a, const cvol_array *b)
{
    const cvol_keep all = cvol_keep_all();
    int code = cvol_array_add(context, result, 1.5, a, -0.5, b, &all);
    assert_true(code || (*result)->lapped == (a->lapped && b->lapped));
    return code;
}

int cell_multiply(cvol_context *context, cvol_array **result, const cvol_array *a,
                  const cvol_array *b)
{
    const cvol_keep all = cvol_keep_all();
    int code = cvol_array_multiply(context, result, a, b, &all, CVOL_PLAN_AUTO, NULL);
    assert_true(code || (*result)->lapped == (a->lapped && b->lapped));
    return code;
}

int cell_scale(cvol_context *context, cvol_array **result, const cvol_array *a, const cvol_array *b)
{
    (void)b;
    int code = cvol_array_scale(context, result, -2, a, 3);
    assert_true(code || (*result)->lapped == a->lapped);
    return code;
}

int cell_one_minus(cvol_context *context, cvol_array **result, const cvol_array *a,
                   const cvol_array *b)
{
    (void)b;
    return cvol_array_one_minus(context, result, a);
}

int cell_truncate_all(cvol_context *context, cvol_array **result, const cvol_array *a,
                      const cvol_array *b)
{
    const cvol_keep all = cvol_keep_all();
    (void)b;
    int code = cvol_array_truncate(context, result, a, &all);
    assert_true(code || (*result)->lapped == a->lapped);
    return code;
}

int cell_filter(cvol_context *context, cvol_array **result, const cvol_array *a,
                const cvol_array *b)
{
    const cvol_keep all = cvol_keep_all();
    cvol_kernel kernel;
    (void)b;
    int code = cvol_kernel_gaussian(context, &kernel, 3, 1);
    if (!code)
        code = cvol_array_convolve_kernel(context, result, a, &kernel, &all);
    assert_true(code || (*result)->lapped == a->lapped);
    return code;
}

int cell_gradient(cvol_context *context, cvol_array **result, const cvol_array *a,
                  const cvol_array *b)
{
    const cvol_keep all = cvol_keep_all();
    (void)b;
    return cvol_array_gradient(context, result, a, &all);
}
