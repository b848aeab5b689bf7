/* Sums of two doubles, the second at most half a unit of the first's last place: about 106 bits.
 * Every operation is a plain one of IEEE 754, so that results are the same on all processors:
 * compilers must not contract products and sums (cmake/flags.cmake).
 *
 * T. J. Dekker, "A floating-point technique for extending the available precision", Numerische
 * Mathematik 18, 1971. */
#ifndef CVOL_BASE_DOUBLE_DOUBLE_H
#define CVOL_BASE_DOUBLE_DOUBLE_H

#if defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ == 2
#error "x87 computes with other rounding than files need: compile with -msse2 -mfpmath=sse"
#endif

typedef struct cvol_dd {
    double high, low;
} cvol_dd;

/* |a| >= |b|, or a is 0. */
static inline cvol_dd cvol_dd_normal(double a, double b)
{
    const double sum = a + b;
    return (cvol_dd){sum, b - (sum - a)};
}

static inline cvol_dd cvol_dd_sum(double a, double b)
{
    const double sum = a + b, of_b = sum - a;
    return (cvol_dd){sum, (a - (sum - of_b)) + (b - of_b)};
}

/* |a| and |b| below 2^996, the product's error not below 2^-1074. */
static inline cvol_dd cvol_dd_product(double a, double b)
{
    const double split = 0x1p27 + 1, as = split * a, bs = split * b;
    const double ah = as - (as - a), al = a - ah, bh = bs - (bs - b), bl = b - bh;
    const double product = a * b;
    return (cvol_dd){product, al * bl - (((product - ah * bh) - al * bh) - ah * bl)};
}

static inline cvol_dd cvol_dd_add(cvol_dd a, cvol_dd b)
{
    const cvol_dd sum = cvol_dd_sum(a.high, b.high);
    return cvol_dd_normal(sum.high, sum.low + (a.low + b.low));
}

static inline cvol_dd cvol_dd_multiply(cvol_dd a, cvol_dd b)
{
    const cvol_dd product = cvol_dd_product(a.high, b.high);
    return cvol_dd_normal(product.high, product.low + (a.high * b.low + a.low * b.high));
}

/* Exact. */
static inline cvol_dd cvol_dd_scale(cvol_dd a, double power_of_two)
{
    return (cvol_dd){a.high * power_of_two, a.low * power_of_two};
}

static inline cvol_dd cvol_dd_divide(cvol_dd a, cvol_dd b)
{
    const double quotient = a.high / b.high;
    const cvol_dd back = cvol_dd_product(quotient, b.high);
    const double rest = ((a.high - back.high) - back.low) + (a.low - quotient * b.low);
    return cvol_dd_normal(quotient, rest / b.high);
}

#endif
