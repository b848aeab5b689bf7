/* Elementary functions (base/elementary.h): an exact or nearly exact reduction of the argument, and
 * a series whose first terms are sums of two doubles. */
#include "base/elementary.h"

#include <float.h>
#include <math.h>

#include "base/double_double.h"

static const cvol_dd LN2 = {0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56};
static const cvol_dd LN10 = {0x1.26bb1bbb55516p+1, -0x1.f48ad494ea3e9p-53};
static const cvol_dd LOG2_E = {0x1.71547652b82fep+0, 0x1.777d0ffda0d24p-56};
static const double LOG10_E = 0x1.bcb7b1526e50ep-2;

/* c[0] + x (c[1] + x (... + x c[count - 1])) */
static double polynomial(double x, const double *c, int count)
{
    double sum = c[count - 1];
    for (int i = count - 2; i >= 0; i--)
        sum = c[i] + x * sum;
    return sum;
}

/* c[0] + x (c[1] + x (... + x (c[count - 1] + x rest))) */
static cvol_dd series(cvol_dd x, const cvol_dd *c, int count, double rest)
{
    cvol_dd sum = {rest, 0};
    for (int i = count - 1; i >= 0; i--)
        sum = cvol_dd_add(c[i], cvol_dd_multiply(x, sum));
    return sum;
}

/* ---- sine and cosine ------------------------------------------------------------------------- */

#define TWO_OVER_PI 0x1.45f306dc9c883p-1
/* pi / 2 is the sum of two numbers of 33 bits, whose multiples are exact, and of a double. */
#define HALF_PI_1 0x1.921fb544p+0
#define HALF_PI_2 0x1.0b4611a6p-34
#define HALF_PI_3 0x1.3198a2e037073p-69

/* *rest = x - q pi / 2, at most about pi / 4; returns q mod 4. */
static int take_quarters(cvol_dd *rest, double x)
{
    static const cvol_dd last = {HALF_PI_3, 0x1.129024e088a68p-123};
    const double q = rint(x * TWO_OVER_PI);
    const cvol_dd near = cvol_dd_sum(x - q * HALF_PI_1, -q * HALF_PI_2);
    const cvol_dd rest_of = cvol_dd_multiply((cvol_dd){-q, 0}, last);
    *rest = cvol_dd_add(near, rest_of);
    return (int)(q - 4 * floor(q / 4));
}

/* |x| <= 0.8: x + x^3 (-1/3! + x^2/5! - ...) */
static double sine_near_0(cvol_dd x)
{
    static const cvol_dd first[3] = {{-0x1.5555555555555p-3, -0x1.5555555555555p-57},
                                     {0x1.1111111111111p-7, 0x1.1111111111111p-63},
                                     {-0x1.a01a01a01a01ap-13, -0x1.a01a01a01a01ap-73}};
    static const double more[] = {1.0 / 362880,         -1.0 / 39916800,
                                  1.0 / 6227020800,     -1.0 / 1307674368000,
                                  1.0 / 355687428096e3, -1.0 / 121645100408832e3};
    const cvol_dd square = cvol_dd_multiply(x, x), cube = cvol_dd_multiply(square, x);
    const cvol_dd sum = series(square, first, 3, polynomial(square.high, more, 6));
    const cvol_dd sine = cvol_dd_add(x, cvol_dd_multiply(cube, sum));
    return sine.high;
}

/* |x| <= 0.8: 1 + x^2 (-1/2! + x^2/4! - ...) */
static double cosine_near_0(cvol_dd x)
{
    static const cvol_dd first[4] = {{1, 0},
                                     {-0.5, 0},
                                     {0x1.5555555555555p-5, 0x1.5555555555555p-59},
                                     {-0x1.6c16c16c16c17p-10, 0x1.f49f49f49f49fp-65}};
    static const double more[] = {
        1.0 / 40320,         -1.0 / 3628800,         1.0 / 479001600,         -1.0 / 87178291200,
        1.0 / 20922789888e3, -1.0 / 6402373705728e3, 1.0 / 2432902008176640e3};
    const cvol_dd square = cvol_dd_multiply(x, x);
    return series(square, first, 4, polynomial(square.high, more, 7)).high;
}

/* sin(x + quarters pi / 2) */
static double sine_from(double x, int quarters)
{
    cvol_dd rest;
    if (!isfinite(x))
        return x - x;
    quarters += take_quarters(&rest, x);
    const double value = quarters % 2 ? cosine_near_0(rest) : sine_near_0(rest);
    return quarters / 2 % 2 ? -value : value;
}

double cvol_sin(double x)
{
    return fabs(x) < 0x1p-30 ? x : sine_from(x, 0); /* a tiny x underflows in products */
}

double cvol_cos(double x)
{
    return sine_from(x, 1);
}

/* Of a double, for both series; the constants' errors are below the rounding of the sums. */
void cvol_sincos(double out[2], double x)
{
    static const double sines[] = {1,
                                   -1.0 / 6,
                                   1.0 / 120,
                                   -1.0 / 5040,
                                   1.0 / 362880,
                                   -1.0 / 39916800,
                                   1.0 / 6227020800,
                                   -1.0 / 1307674368000};
    static const double cosines[] = {
        -0.5,           1.0 / 24,        -1.0 / 720,         1.0 / 40320,
        -1.0 / 3628800, 1.0 / 479001600, -1.0 / 87178291200, 1.0 / 20922789888e3};
    if (!isfinite(x)) {
        out[0] = out[1] = x - x;
        return;
    }
    double rest = x;
    int quarter = 0;
    if (fabs(x) > 0.78) { /* up to pi / 4 nothing is reduced */
        const double q = rint(x * TWO_OVER_PI);
        rest = (x - q * HALF_PI_1 - q * HALF_PI_2) - q * HALF_PI_3;
        quarter = (int)(q - 4 * floor(q / 4));
    }
    const double square = rest * rest, s = rest * polynomial(square, sines, 8);
    const double c = 1 + square * polynomial(square, cosines, 8);
    const double re[4] = {c, -s, -c, s}, im[4] = {s, c, -s, -c};
    out[0] = re[quarter];
    out[1] = im[quarter];
}

/* ---- exponential functions
 * ------------------------------------------------------------------------ */

/* e^x 2^-*exponent in [0.7, 1.42], |x| < 2000. 32 bits of ln 2 have exact multiples. */
static cvol_dd exponential(int *exponent, cvol_dd x)
{
    static const cvol_dd last = {0x1.a39ef35793c76p-33, 0x1.cc01f97b57a08p-87};
    static const cvol_dd first[5] = {{1, 0},
                                     {1, 0},
                                     {0.5, 0},
                                     {0x1.5555555555555p-3, 0x1.5555555555555p-57},
                                     {0x1.5555555555555p-5, 0x1.5555555555555p-59}};
    static const double more[] = {1.0 / 120,    1.0 / 720,     1.0 / 5040,    1.0 / 40320,
                                  1.0 / 362880, 1.0 / 3628800, 1.0 / 39916800};
    const double turns = rint(x.high * LOG2_E.high);
    const cvol_dd near = cvol_dd_sum(x.high - turns * 0x1.62e42feep-1, x.low);
    cvol_dd rest = cvol_dd_add(near, cvol_dd_multiply((cvol_dd){-turns, 0}, last));
    rest = cvol_dd_scale(rest, 1.0 / 16);
    cvol_dd power = series(rest, first, 5, polynomial(rest.high, more, 7));
    for (int i = 0; i < 4; i++)
        power = cvol_dd_multiply(power, power);
    *exponent = (int)turns;
    return power;
}

static double exponential_of(cvol_dd x)
{
    int exponent;
    if (!(fabs(x.high) < 2000)) /* outside of the range, or not a number */
        return x.high > 0 ? (double)INFINITY : x.high < 0 ? 0 : x.high;
    const cvol_dd power = exponential(&exponent, x);
    return ldexp(power.high, exponent);
}

double cvol_exp(double x)
{
    return exponential_of((cvol_dd){x, 0});
}

/* ---- logarithms
 * ----------------------------------------------------------------------------------- */

/* ln x - *exponent ln 2, x finite and positive: with m = x 2^-exponent in [2^-1/2, 2^1/2],
 * s = (m - 1) / (m + 1) and t = s^2, ln m = 2 s (1 + t / 3 + t^2 / 5 + ...), t < 0.03 */
static cvol_dd logarithm(int *exponent, double x)
{
    static const cvol_dd first[5] = {{1, 0},
                                     {0x1.5555555555555p-2, 0x1.5555555555555p-56},
                                     {0x1.999999999999ap-3, -0x1.999999999999ap-57},
                                     {0x1.2492492492492p-3, 0x1.2492492492492p-57},
                                     {0x1.c71c71c71c71cp-4, 0x1.c71c71c71c71cp-58}};
    static const double more[] = {1.0 / 11, 1.0 / 13, 1.0 / 15, 1.0 / 17, 1.0 / 19,
                                  1.0 / 21, 1.0 / 23, 1.0 / 25, 1.0 / 27, 1.0 / 29};
    double m = frexp(x, exponent);
    if (m < 0x1.6a09e667f3bcdp-1) {
        m *= 2;
        --*exponent;
    }
    const cvol_dd s = cvol_dd_divide(cvol_dd_sum(m, -1), cvol_dd_sum(m, 1));
    const cvol_dd t = cvol_dd_multiply(s, s);
    const cvol_dd sum = series(t, first, 5, polynomial(t.high, more, 10));
    return cvol_dd_scale(cvol_dd_multiply(s, sum), 2);
}

/* Logarithms of 0, infinity, negative numbers and what is no number. */
static double logarithm_beyond(double x)
{
    return x > 0 ? x : x < 0 || isnan(x) ? (double)NAN : -(double)INFINITY;
}

static int has_logarithm(double x)
{
    return x > 0 && x <= DBL_MAX;
}

static cvol_dd natural_logarithm(double x)
{
    int exponent;
    const cvol_dd part = logarithm(&exponent, x);
    return cvol_dd_add(cvol_dd_multiply((cvol_dd){exponent, 0}, LN2), part);
}

double cvol_log(double x)
{
    return has_logarithm(x) ? natural_logarithm(x).high : logarithm_beyond(x);
}

double cvol_log2(double x)
{
    int exponent;
    if (!has_logarithm(x))
        return logarithm_beyond(x);
    const cvol_dd part = cvol_dd_multiply(logarithm(&exponent, x), LOG2_E);
    return cvol_dd_add((cvol_dd){exponent, 0}, part).high;
}

/* Rounds like fdlibm and the C libraries that have it from there: files have PSNRs. The logarithm
 * of 2 is a sum of a number with exact multiples, and of a double. */
double cvol_log10(double x)
{
    int exponent;
    if (!has_logarithm(x))
        return logarithm_beyond(x);
    double m = frexp(x, &exponent);
    if (exponent > 0) {
        m *= 2;
        exponent--;
    }
    const double rest = exponent * 0x1.9fef311f12b36p-42 + LOG10_E * cvol_log(m);
    return rest + exponent * 0x1.34413509f6p-2;
}

double cvol_pow(double x, double y)
{
    if (y == 0 || x == 1)
        return 1;
    if (!has_logarithm(x) || !isfinite(y))
        return pow(x, y); /* a special value */
    const cvol_dd logarithm_of_x = x == 10 ? LN10 : natural_logarithm(x);
    return exponential_of(cvol_dd_multiply(logarithm_of_x, (cvol_dd){y, 0}));
}

/* ---- lengths
 * -------------------------------------------------------------------------------------- */

double cvol_hypot(double a, double b)
{
    const double most = fmax(fabs(a), fabs(b));
    int exponent;
    if (!isfinite(a) || !isfinite(b) || most == 0)
        return hypot(a, b); /* a special value */
    (void)frexp(most, &exponent);
    a = ldexp(a, -exponent);
    b = ldexp(b, -exponent);
    const cvol_dd square = cvol_dd_add(cvol_dd_product(a, a), cvol_dd_product(b, b));
    const double root = sqrt(square.high);
    const cvol_dd back = cvol_dd_product(root, root);
    const double rest = ((square.high - back.high) - back.low) + square.low;
    return ldexp(root + rest / (2 * root), exponent);
}

/* ---- floats
 * --------------------------------------------------------------------------------------- */

float cvol_exp2f(float x)
{
    static const double powers[] = {1,           1.0,          1.0 / 2,      1.0 / 6,
                                    1.0 / 24,    1.0 / 120,    1.0 / 720,    1.0 / 5040,
                                    1.0 / 40320, 1.0 / 362880, 1.0 / 3628800};
    const double value = (double)x;
    if (!(fabs(value) < 200))
        return value > 0 ? INFINITY : value < 0 ? 0 : x;
    const double turns = rint(value);
    const double power = polynomial((value - turns) * LN2.high, powers, 11);
    return (float)ldexp(power, (int)turns);
}

float cvol_log2f(float x)
{
    static const double shares[] = {1,        1.0 / 3,  1.0 / 5,  1.0 / 7,  1.0 / 9, 1.0 / 11,
                                    1.0 / 13, 1.0 / 15, 1.0 / 17, 1.0 / 19, 1.0 / 21};
    int exponent;
    if (!has_logarithm((double)x))
        return (float)logarithm_beyond((double)x);
    double m = frexp((double)x, &exponent);
    if (m < 0x1.6a09e667f3bcdp-1) {
        m *= 2;
        exponent--;
    }
    const double s = (m - 1) / (m + 1);
    return (float)(exponent + 2 * LOG2_E.high * s * polynomial(s * s, shares, 11));
}
