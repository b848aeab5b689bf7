/* Bounds through operations: interval arithmetic, and norms. */
#include "array/core/error_bound.h"

#include <float.h>
#include <math.h>

#include "base/context.h"

double cvol_ledger_largest(const cvol_ledger *ledger)
{
    return fmax(fabs(ledger->value_min), fabs(ledger->value_max));
}

double cvol_ledger_tighten(const cvol_ledger *ledger)
{
    return fmin(ledger->max_abs, cvol_ledger_largest(ledger) + ledger->l2_error);
}

double cvol_ledger_support(const cvol_ledger *ledger)
{
    return ledger->support_known ? fmin(ledger->support_error, ledger->l2_error) : ledger->l2_error;
}

/* The interval alpha [a] + beta. */
static void scale_values(double out[2], double alpha, const cvol_ledger *a, double beta)
{
    const double first = alpha * a->value_min + beta, second = alpha * a->value_max + beta;
    out[0] = fmin(first, second);
    out[1] = fmax(first, second);
}

cvol_ledger cvol_ledger_add(double alpha, const cvol_ledger *a, double beta, const cvol_ledger *b)
{
    double x[2], y[2];
    scale_values(x, alpha, a, 0);
    scale_values(y, beta, b, 0);
    return (cvol_ledger){.l2_error = fabs(alpha) * a->l2_error + fabs(beta) * b->l2_error,
                         .max_abs = fabs(alpha) * cvol_ledger_tighten(a) +
                                    fabs(beta) * cvol_ledger_tighten(b),
                         .value_min = x[0] + y[0],
                         .value_max = x[1] + y[1]};
}

cvol_ledger cvol_ledger_scale(double alpha, const cvol_ledger *a, double beta)
{
    double x[2];
    scale_values(x, alpha, a, beta);
    return (cvol_ledger){.l2_error = fabs(alpha) * a->l2_error,
                         .max_abs = fabs(alpha) * cvol_ledger_tighten(a) + fabs(beta),
                         .value_min = x[0],
                         .value_max = x[1],
                         .support_error = fabs(alpha) * a->support_error,
                         .support_known = a->support_known && !(fabs(beta) > 0)};
}

cvol_ledger cvol_ledger_convolve(const cvol_ledger *a, double norm, double sum)
{
    const double largest = sum * cvol_ledger_largest(a);
    return (cvol_ledger){.l2_error = norm * a->l2_error,
                         .max_abs = sum * cvol_ledger_tighten(a),
                         .value_min = -largest,
                         .value_max = largest};
}

cvol_ledger cvol_ledger_filter(const cvol_ledger *a, double norm, double sum, double total)
{
    /* a[x] = middle + r with |r| <= half; h * a = total middle + h * r */
    const double middle = (a->value_min + a->value_max) / 2;
    const double half = (a->value_max - a->value_min) / 2;
    cvol_ledger out = cvol_ledger_convolve(a, norm, sum);
    /* Both ends may be much smaller than what they are the difference of. */
    const double rounding = 4 * DBL_EPSILON * (fabs(total * middle) + sum * half);
    out.value_min = total * middle - sum * half - rounding;
    out.value_max = total * middle + sum * half + rounding;
    return out;
}

cvol_ledger cvol_ledger_multiply(const cvol_ledger *a, const cvol_ledger *b)
{
    const double corners[4] = {a->value_min * b->value_min, a->value_min * b->value_max,
                               a->value_max * b->value_min, a->value_max * b->value_max};
    const double a_exact = cvol_ledger_largest(a), b_exact = cvol_ledger_largest(b);
    const double a_kept = cvol_ledger_tighten(a), b_kept = cvol_ledger_tighten(b);
    /* a b - a~ b~ = a (b - b~) + b~ (a - a~) = a~ (b - b~) + b (a - a~) */
    cvol_ledger out = {.l2_error = fmin(a_exact * b->l2_error + b_kept * a->l2_error,
                                        a_kept * b->l2_error + b_exact * a->l2_error),
                       .max_abs = a_kept * b_kept,
                       .value_min = corners[0],
                       .value_max = corners[0]};
    for (int i = 1; i < 4; i++) {
        out.value_min = fmin(out.value_min, corners[i]);
        out.value_max = fmax(out.value_max, corners[i]);
    }
    return out;
}

void cvol_ledger_drop(cvol_ledger *ledger, double dropped, double norm, double sample)
{
    const double lost = dropped + CVOL_ROUNDING * norm;
    ledger->l2_error += lost;
    ledger->support_error += CVOL_ROUNDING * norm;
    ledger->max_abs += fmin(lost, sample);
}

int cvol_ledger_check(cvol_context *context, const cvol_ledger *ledger, const char *operation)
{
    const double largest = fmax(cvol_ledger_largest(ledger), ledger->max_abs);
    if (largest <= (double)FLT_MAX && ledger->l2_error <= (double)FLT_MAX)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_DATA,
                     "%s: values may reach %g, beyond what float32 holds (%g); scale the operands "
                     "down first",
                     operation, largest, (double)FLT_MAX);
}
