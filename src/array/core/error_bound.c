/* Bounds through operations: interval arithmetic, and norms. */
#include "array/core/error_bound.h"

#include <float.h>
#include <math.h>

#include "base/context.h"

double cvol_error_bound_point(const cvol_error_bound *error_bound)
{
    const double point = error_bound->point_error;
    return point > 0 && point < error_bound->l2_error ? point : error_bound->l2_error;
}

void cvol_error_bound_widen(cvol_error_bound *error_bound, double l2, double point)
{
    error_bound->point_error = cvol_error_bound_point(error_bound) + fmin(l2, point);
    error_bound->l2_error += l2;
}

/* Above this sum, the squares that underflow do not count. */
#define SQUARES_LEAST 1e-280

/* A square that underflows loses at most the least normal number. */
double cvol_norm_of_squares(double squares, double largest, double samples)
{
    if (squares >= SQUARES_LEAST && squares <= DBL_MAX)
        return sqrt(squares);
    return largest > 0 ? fmin(sqrt(squares + samples * DBL_MIN), largest * sqrt(samples)) : 0;
}

double cvol_error_bound_largest(const cvol_error_bound *error_bound)
{
    return fmax(fabs(error_bound->value_min), fabs(error_bound->value_max));
}

double cvol_error_bound_tighten(const cvol_error_bound *error_bound)
{
    return fmin(error_bound->max_abs,
                cvol_error_bound_largest(error_bound) + error_bound->l2_error);
}

double cvol_error_bound_support(const cvol_error_bound *error_bound)
{
    return error_bound->support_known ? fmin(error_bound->support_error, error_bound->l2_error)
                                      : error_bound->l2_error;
}

/* The interval alpha [a] + beta. */
static void scale_values(double out[2], double alpha, const cvol_error_bound *a, double beta)
{
    const double first = alpha * a->value_min + beta, second = alpha * a->value_max + beta;
    out[0] = fmin(first, second);
    out[1] = fmax(first, second);
}

cvol_error_bound cvol_error_bound_add(double alpha, const cvol_error_bound *a, double beta,
                                      const cvol_error_bound *b)
{
    double x[2], y[2];
    scale_values(x, alpha, a, 0);
    scale_values(y, beta, b, 0);
    return (cvol_error_bound){.l2_error = fabs(alpha) * a->l2_error + fabs(beta) * b->l2_error,
                              .point_error = fabs(alpha) * cvol_error_bound_point(a) +
                                             fabs(beta) * cvol_error_bound_point(b),
                              .default_loss = fabs(alpha) * a->default_loss +
                                              fabs(beta) * b->default_loss,
                              .max_abs = fabs(alpha) * cvol_error_bound_tighten(a) +
                                         fabs(beta) * cvol_error_bound_tighten(b),
                              .value_min = x[0] + y[0],
                              .value_max = x[1] + y[1]};
}

cvol_error_bound cvol_error_bound_scale(double alpha, const cvol_error_bound *a, double beta)
{
    double x[2];
    scale_values(x, alpha, a, beta);
    return (cvol_error_bound){.l2_error = fabs(alpha) * a->l2_error,
                              .point_error = fabs(alpha) * cvol_error_bound_point(a),
                              .default_loss = fabs(alpha) * a->default_loss,
                              .max_abs = fabs(alpha) * cvol_error_bound_tighten(a) + fabs(beta),
                              .value_min = x[0],
                              .value_max = x[1],
                              .support_error = fabs(alpha) * a->support_error,
                              .support_known = a->support_known && !(fabs(beta) > 0)};
}

cvol_error_bound cvol_error_bound_convolve(const cvol_error_bound *a, double norm, double sum)
{
    const double largest = sum * cvol_error_bound_largest(a);
    return (cvol_error_bound){.l2_error = norm * a->l2_error,
                              .point_error = sum * cvol_error_bound_point(a),
                              .default_loss = norm * a->default_loss,
                              .max_abs = sum * cvol_error_bound_tighten(a),
                              .value_min = -largest,
                              .value_max = largest};
}

cvol_error_bound cvol_error_bound_filter(const cvol_error_bound *a, double norm, double sum,
                                         double total)
{
    /* a[x] = middle + r with |r| <= half; h * a = total middle + h * r */
    const double middle = (a->value_min + a->value_max) / 2;
    const double half = (a->value_max - a->value_min) / 2;
    cvol_error_bound out = cvol_error_bound_convolve(a, norm, sum);
    /* Both ends may be much smaller than the terms of their difference. */
    const double rounding = 4 * DBL_EPSILON * (fabs(total * middle) + sum * half);
    out.value_min = total * middle - sum * half - rounding;
    out.value_max = total * middle + sum * half + rounding;
    return out;
}

/* The part of an operand's error that the default truncation added. */
static double default_share(const cvol_error_bound *a)
{
    return a->l2_error > 0 ? a->default_loss / a->l2_error : 0;
}

cvol_error_bound cvol_error_bound_multiply(const cvol_error_bound *a, const cvol_error_bound *b)
{
    const double corners[4] = {a->value_min * b->value_min, a->value_min * b->value_max,
                               a->value_max * b->value_min, a->value_max * b->value_max};
    const double a_exact = cvol_error_bound_largest(a), b_exact = cvol_error_bound_largest(b);
    const double a_kept = cvol_error_bound_tighten(a), b_kept = cvol_error_bound_tighten(b);
    const double a_point = cvol_error_bound_point(a), b_point = cvol_error_bound_point(b);
    /* a b - a~ b~ = a (b - b~) + b~ (a - a~) = a~ (b - b~) + b (a - a~) */
    cvol_error_bound out = {.l2_error = fmin(a_exact * b->l2_error + b_kept * a->l2_error,
                                             a_kept * b->l2_error + b_exact * a->l2_error),
                            .point_error = fmin(a_exact * b_point + b_kept * a_point,
                                                a_kept * b_point + b_exact * a_point),
                            .max_abs = a_kept * b_kept,
                            .value_min = corners[0],
                            .value_max = corners[0]};
    out.default_loss = fmax(default_share(a), default_share(b)) * out.l2_error;
    for (int i = 1; i < 4; i++) {
        out.value_min = fmin(out.value_min, corners[i]);
        out.value_max = fmax(out.value_max, corners[i]);
    }
    return out;
}

void cvol_error_bound_drop(cvol_error_bound *error_bound, double dropped, double norm,
                           double sample)
{
    const double lost = dropped + CVOL_ROUNDING * norm;
    cvol_error_bound_widen(error_bound, lost, sample);
    error_bound->support_error += CVOL_ROUNDING * norm;
    error_bound->max_abs += fmin(lost, sample);
}

int cvol_error_bound_check(cvol_context *context, const cvol_error_bound *error_bound,
                           const char *operation)
{
    const double largest = fmax(cvol_error_bound_largest(error_bound), error_bound->max_abs);
    if (largest <= (double)FLT_MAX && error_bound->l2_error <= (double)FLT_MAX)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_DATA,
                     "%s: values may reach %g, beyond what float32 holds (%g); scale the operands "
                     "down first",
                     operation, largest, (double)FLT_MAX);
}
