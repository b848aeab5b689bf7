/* Statistics of arrays from their terms, without evaluating them, and their distance from the exact
 * ones.
 *
 * Let a be the exact samples, a~ the array's samples, |a - a~| <= e (L2 norms over the N samples).
 *     sum        |<1, a - a~>| <= |1| e = sqrt(N) e                       (Cauchy, Schwarz)
 *     mean       that / N = e / sqrt(N)
 *     L2 norm    ||a| - |a~|| <= |a - a~| <= e                            (triangle)
 *     deviation  sd = |P a| / sqrt(N), P the projection that removes the mean, |P| = 1:
 *                |sd - sd~| <= |P (a - a~)| / sqrt(N) <= e / sqrt(N)
 *     inner      <a, b> - <a~, b~> = <a - a~, b~> + <a~, b - b~> + <a - a~, b - b~>:
 *                at most e_a |b~| + |a~| e_b + e_a e_b
 *     distance   ||a - b| - |a~ - b~|| <= |(a - a~) - (b - b~)| <= e_a + e_b
 * Sums are in double precision; their rounding is far below the single precision rounding in e. */
#include <math.h>
#include <string.h>

#include "array/algebra/operations.h"
#include "array/core/array.h"
#include "array/evaluate/decoded_terms.h"

/* Checks that the terms of two arrays define them, in the same shape. */
static int check_pair(cvol_context *context, const cvol_array *a, const cvol_array *b)
{
    int code = cvol_array_need_plain(context, a);
    if (!code)
        code = cvol_array_need_plain(context, b);
    return code ? code : cvol_array_compatible(context, a, b);
}

static int sums_of(cvol_context *context, double *sum, double *squares, const cvol_array *a)
{
    return a->block ? cvol_blocks_sums(context, sum, squares, a)
                    : cvol_whole_sums(context, sum, squares, a);
}

int cvol_array_compute_statistics(cvol_context *context, cvol_array_statistics *out,
                                  const cvol_array *a)
{
    double sum, squares;
    memset(out, 0, sizeof *out);
    int code = cvol_array_need_plain(context, a);
    if (!code)
        code = cvol_array_decoded_terms(context, &a, a);
    if (!code)
        code = sums_of(context, &sum, &squares, a);
    if (code)
        return code;
    const double samples = (double)cvol_grid_samples(&a->grid), error = a->error_bound.l2_error;
    out->sum = sum;
    out->mean = sum / samples;
    out->l2_norm = sqrt(squares);
    /* Whole arrays: the energy of all terms except the mean's; nothing cancels. */
    const double variation = a->block ? squares - sum * out->mean : cvol_whole_variation(a);
    out->variance = fmax(0, variation / samples);
    out->standard_deviation = sqrt(out->variance);
    out->sum_error = sqrt(samples) * error;
    out->mean_error = error / sqrt(samples);
    out->standard_deviation_error = error / sqrt(samples);
    out->l2_norm_error = error;
    return CVOL_OK;
}

int cvol_array_compute_inner_product(cvol_context *context, double *out, const cvol_array *a,
                                     const cvol_array *b)
{
    *out = 0;
    int code = check_pair(context, a, b);
    if (!code)
        code = cvol_array_decoded_terms(context, &a, a);
    if (!code)
        code = cvol_array_decoded_terms(context, &b, b);
    if (code)
        return code;
    return a->block ? cvol_blocks_inner(context, out, a, b) : cvol_whole_inner(context, out, a, b);
}

/* |a - b|^2 = |a|^2 + |b|^2 - 2 <a, b> if that does not cancel. */
static int compare_blocks(cvol_context *context, double *inner, double *distance, double squares,
                          const cvol_array *a, const cvol_array *b)
{
    int code = cvol_blocks_inner(context, inner, a, b);
    if (code)
        return code;
    double apart = squares - 2 * *inner;
    if (apart < 1e-4 * squares)
        code = cvol_blocks_distance(context, &apart, a, b);
    *distance = sqrt(fmax(0, apart));
    return code;
}

int cvol_array_compare(cvol_context *context, cvol_array_comparison *out, const cvol_array *a,
                       const cvol_array *b)
{
    double sum, inner, square_a, square_b;
    memset(out, 0, sizeof *out);
    int code = check_pair(context, a, b);
    if (!code)
        code = cvol_array_decoded_terms(context, &a, a);
    if (!code)
        code = cvol_array_decoded_terms(context, &b, b);
    if (!code)
        code = sums_of(context, &sum, &square_a, a);
    if (!code)
        code = sums_of(context, &sum, &square_b, b);
    if (!code)
        code = a->block ? compare_blocks(context, &inner, &out->distance, square_a + square_b, a, b)
                        : cvol_whole_compare(context, &inner, &out->distance, a, b);
    if (code)
        return code;
    const double norm_a = sqrt(square_a), norm_b = sqrt(square_b);
    const double error_a = a->error_bound.l2_error, error_b = b->error_bound.l2_error;
    out->inner_product = inner;
    if (norm_a > 0 && norm_b > 0)
        out->cosine_similarity = fmax(-1, fmin(1, inner / norm_a / norm_b));
    out->inner_product_error = error_a * norm_b + norm_a * error_b + error_a * error_b;
    out->distance_error = error_a + error_b;
    return CVOL_OK;
}
