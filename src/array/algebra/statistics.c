/* Statistics of arrays from their terms, without evaluating them, and their distance from the exact
 * ones. Arrays with a mask are evaluated (masked_sums.h): N then counts the samples with a value;
 * background samples are exact, but for those of results.
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

#include "array/algebra/masked_sums.h"
#include "array/algebra/operations.h"
#include "array/core/array.h"
#include "array/evaluate/decoded_terms.h"

/* *variation: the sum of (a - mean)^2, without what is equal in all samples: it would cancel. */
static int sums_of(cvol_context *context, double *sum, double *squares, double *variation,
                   const cvol_array *a)
{
    if (a->block)
        return cvol_blocks_sums(context, sum, squares, variation, a);
    *variation = cvol_whole_variation(a);
    return cvol_whole_sums(context, sum, squares, a);
}

/* Statistics from sums over `samples` samples, of which `coded` are not exact; `variation`: the sum
 * of (a - mean)^2. */
static cvol_array_statistics statistics_of(double samples, double coded, double sum, double squares,
                                           double variation, double error)
{
    if (samples <= 0) /* none has a value */
        return (cvol_array_statistics){0};
    cvol_array_statistics s = {.sum = sum,
                               .mean = sum / samples,
                               .variance = fmax(0, variation / samples),
                               .l2_norm = sqrt(squares),
                               .sum_error = sqrt(coded) * error,
                               .mean_error = sqrt(coded) * error / samples,
                               .standard_deviation_error = error / sqrt(samples),
                               .l2_norm_error = error};
    s.standard_deviation = sqrt(s.variance);
    return s;
}

static int masked_statistics(cvol_context *context, cvol_array_statistics *out, const cvol_array *a)
{
    cvol_masked_sums sums;
    const int code = cvol_masked_sums_compute(context, &sums, a, NULL);
    if (code)
        return code;
    *out = statistics_of(sums.samples, sums.samples - sums.exact[0], sums.sum[0], sums.squares[0],
                         sums.variation[0], sums.error[0]);
    if (sums.samples > 0) {
        /* |sqrt(v + r) - sqrt(v)| <= sqrt(r), and <= r / sqrt(v) */
        const double rounding = sums.rounding[0] / sums.samples, sd = out->standard_deviation;
        out->standard_deviation_error += rounding < sd * sd ? rounding / sd : sqrt(rounding);
    }
    return CVOL_OK;
}

int cvol_array_compute_statistics(cvol_context *context, cvol_array_statistics *out,
                                  const cvol_array *a)
{
    double sum, squares, variation;
    memset(out, 0, sizeof *out);
    if (a->mask)
        return masked_statistics(context, out, a);
    int code = cvol_array_decoded_terms(context, &a, a);
    if (!code)
        code = sums_of(context, &sum, &squares, &variation, a);
    if (code)
        return code;
    const double samples = (double)cvol_grid_samples(&a->grid);
    *out = statistics_of(samples, samples, sum, squares, variation, a->error_bound.l2_error);
    return CVOL_OK;
}

int cvol_array_compute_inner_product(cvol_context *context, double *out, const cvol_array *a,
                                     const cvol_array *b)
{
    *out = 0;
    int code = cvol_array_compatible(context, a, b);
    if (!code && (a->mask || b->mask)) {
        cvol_masked_sums sums;
        code = cvol_masked_sums_compute(context, &sums, a, b);
        *out = code ? 0 : sums.inner;
        return code;
    }
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

static cvol_array_comparison comparison_of(double inner, double distance, const double squares[2],
                                           const double errors[2])
{
    const double norm_a = sqrt(squares[0]), norm_b = sqrt(squares[1]);
    cvol_array_comparison c = {.inner_product = inner,
                               .distance = distance,
                               .inner_product_error = errors[0] * norm_b + norm_a * errors[1] +
                                                      errors[0] * errors[1],
                               .distance_error = errors[0] + errors[1]};
    if (norm_a > 0 && norm_b > 0)
        c.cosine_similarity = fmax(-1, fmin(1, inner / norm_a / norm_b));
    return c;
}

static int compare_masked(cvol_context *context, cvol_array_comparison *out, const cvol_array *a,
                          const cvol_array *b)
{
    cvol_masked_sums sums;
    const int code = cvol_masked_sums_compute(context, &sums, a, b);
    if (!code)
        *out = comparison_of(sums.inner, sqrt(sums.apart), sums.squares, sums.error);
    return code;
}

int cvol_array_compare(cvol_context *context, cvol_array_comparison *out, const cvol_array *a,
                       const cvol_array *b)
{
    double sum, variation, inner, distance, squares[2];
    memset(out, 0, sizeof *out);
    int code = cvol_array_compatible(context, a, b);
    if (!code && (a->mask || b->mask))
        return compare_masked(context, out, a, b);
    if (!code)
        code = cvol_array_decoded_terms(context, &a, a);
    if (!code)
        code = cvol_array_decoded_terms(context, &b, b);
    if (!code)
        code = sums_of(context, &sum, &squares[0], &variation, a);
    if (!code)
        code = sums_of(context, &sum, &squares[1], &variation, b);
    if (!code)
        code = a->block ? compare_blocks(context, &inner, &distance, squares[0] + squares[1], a, b)
                        : cvol_whole_compare(context, &inner, &distance, a, b);
    if (code)
        return code;
    const double errors[2] = {a->error_bound.l2_error, b->error_bound.l2_error};
    *out = comparison_of(inner, distance, squares, errors);
    return CVOL_OK;
}
