/* Elementary functions: against long doubles, which have 11 bits more on x86-64 and 60 on others,
 * special values, and the same bits on every processor. The seed of random numbers is printed;
 * CVOL_ELEMENTARY_SEED sets it (default 1). Seed 1796037163 finds 2.26 units in sine_of_both. */
#include "test.h"

#include <float.h>

#include "base/elementary.h"
#include "random.h"

enum { CASES = 20000 };

static random_state numbers;

/* lo .. hi */
static double between(double lo, double hi)
{
    return lo + (hi - lo) * (random_signed(&numbers) + 1) / 2;
}

/* ---- functions of one number
 * ---------------------------------------------------------------------- */

static double cosine_of_both(double x)
{
    double out[2];
    cvol_sincos(out, x);
    return out[0];
}

static double sine_of_both(double x)
{
    double out[2];
    cvol_sincos(out, x);
    return out[1];
}

static double power_of_10(double x)
{
    return cvol_pow(10, x);
}

static double power(double x)
{
    return cvol_pow(x, 1.7);
}

static double length(double x)
{
    return cvol_hypot(x, 1.37);
}

static double float_power(double x)
{
    return (double)cvol_exp2f((float)x);
}

static double float_logarithm(double x)
{
    return (double)cvol_log2f((float)x);
}

static long double exact_power_of_10(long double x)
{
    return powl(10, x);
}

static long double exact_power(long double x)
{
    return powl(x, 1.7); /* the double nearest to 1.7 */
}

static long double exact_length(long double x)
{
    return hypotl(x, 1.37);
}

static long double exact_float_power(long double x)
{
    return exp2l((long double)(float)x);
}

static long double exact_float_logarithm(long double x)
{
    return log2l((long double)(float)x);
}

/* Arguments lo .. hi, or e to the power of these; `sum`: of the bits of the values at places(). */
static const struct function {
    const char *name;
    double (*own)(double);
    long double (*exact)(long double);
    double lo, hi;
    int is_exponent;
    double limit; /* in units of the last place of a double, or of a float */
    int is_float;
    uint64_t sum;
} functions[] = {
    {"sin", cvol_sin, sinl, -0.8, 0.8, 0, 0.501, 0, UINT64_C(0xe1542cc8c90c3c52)},
    {"cos", cvol_cos, cosl, -0.8, 0.8, 0, 0.501, 0, UINT64_C(0xcb14317b5c876d0e)},
    {"sin", cvol_sin, sinl, -2000, 2000, 0, 0.501, 0, UINT64_C(0xb653fa8e6b2a0c57)},
    {"cos", cvol_cos, cosl, -2000, 2000, 0, 0.501, 0, UINT64_C(0x1016976e17e5922d)},
    {"cosine of both", cosine_of_both, cosl, -2000, 2000, 0, 2, 0, UINT64_C(0x54987c0258e218bf)},
    {"sine of both", sine_of_both, sinl, -2000, 2000, 0, 2, 0, UINT64_C(0x01a592b500af2af3)},
    {"exp", cvol_exp, expl, -700, 700, 0, 0.501, 0, UINT64_C(0x3719b4eabb5a303e)},
    {"log", cvol_log, logl, -700, 700, 1, 0.501, 0, UINT64_C(0xa2e0d4d1a3f48065)},
    {"log", cvol_log, logl, 0.9, 1.1, 0, 0.501, 0, UINT64_C(0x2784d679982fbd68)},
    {"log2", cvol_log2, log2l, -700, 700, 1, 0.501, 0, UINT64_C(0xab372893d5a9aae0)},
    {"log10", cvol_log10, log10l, -700, 700, 1, 2, 0, UINT64_C(0x0fc224519bec4738)},
    {"10^x", power_of_10, exact_power_of_10, -300, 300, 0, 0.501, 0, UINT64_C(0x0d0b0dbfbbc96fe1)},
    {"x^1.7", power, exact_power, -300, 300, 1, 0.501, 0, UINT64_C(0x7dd79d58f3c9eea1)},
    {"hypot", length, exact_length, -40, 40, 1, 0.501, 0, UINT64_C(0xc82aafb0586fe0ee)},
    {"exp2f", float_power, exact_float_power, -120, 120, 0, 0.501, 1, UINT64_C(0x54c80566be20720c)},
    {"log2f", float_logarithm, exact_float_logarithm, -60, 60, 1, 0.501, 1,
     UINT64_C(0x3249263c1faa7e47)},
};

static double argument(const struct function *of)
{
    const double x = between(of->lo, of->hi);
    return of->is_exponent ? cvol_exp(x) : x;
}

/* The last place of a double, or of a float, as large as this. */
static double last_place(double value, int is_float)
{
    int exponent;
    (void)frexp(value, &exponent);
    return ldexp(1, exponent - (is_float ? FLT_MANT_DIG : DBL_MANT_DIG));
}

/* C libraries whose long double is a double, or that reduce large angles less exactly. */
static int has_exact(const struct function *of)
{
#ifdef _WIN32
    return of->hi < 1 || of->lo > 0;
#else
    (void)of;
    return LDBL_MANT_DIG >= 64;
#endif
}

static void test_errors(void **state)
{
    (void)state;
    for (size_t f = 0; f < sizeof functions / sizeof *functions; f++) {
        const struct function *of = &functions[f];
        for (int i = 0; i < CASES && has_exact(of); i++) {
            const double x = argument(of), value = of->own(x);
            const long double exact = of->exact((long double)x);
            const double error = (double)fabsl((long double)value - exact) /
                                 last_place((double)exact, of->is_float);
            if (!(error <= of->limit))
                fail_msg("%s of %a is %a, %.4f units from the exact value", of->name, x, value,
                         error);
        }
    }
}

/* ---- the same bits
 * -------------------------------------------------------------------------------- */

/* FNV-1a of the bits of values at 5000 arguments, of which the bits are the same everywhere too. */
static uint64_t sum_of(const struct function *of)
{
    uint64_t sum = UINT64_C(0xcbf29ce484222325);
    numbers.state = 1;
    for (int i = 0; i < 5000; i++) {
        const double value = of->own(argument(of));
        uint64_t bits;
        memcpy(&bits, &value, sizeof bits);
        for (int b = 0; b < 64; b += 8)
            sum = (sum ^ (bits >> b & 0xff)) * UINT64_C(0x100000001b3);
    }
    return sum;
}

static void test_bits(void **state)
{
    (void)state;
    const random_state before = numbers;
    int differ = 0;
    for (size_t f = 0; f < sizeof functions / sizeof *functions; f++) {
        const unsigned long long sum = sum_of(&functions[f]);
        if (sum != functions[f].sum) {
            print_error("%s: the values' sum is 0x%016llx\n", functions[f].name, sum);
            differ = 1;
        }
    }
    numbers = before;
    assert_false(differ);
}

/* ---- values that are known
 * ------------------------------------------------------------------------ */

static void expect(const char *what, double value, double wanted)
{
    if (memcmp(&value, &wanted, sizeof value) && !(isnan(value) && isnan(wanted)))
        fail_msg("%s is %a, not %a", what, value, wanted);
}

static void test_exact_values(void **state)
{
    (void)state;
    for (int i = -1000; i <= 1000; i++) {
        expect("log2 of a power of two", cvol_log2(ldexp(1, i)), i);
        expect("a power of two", cvol_pow(2, i), ldexp(1, i));
        expect("a power of 1/2", cvol_pow(0.5, i), ldexp(1, -i));
    }
    double power_of_ten = 1;
    for (int i = 0; i <= 22; i++, power_of_ten *= 10) {
        expect("log10 of a power of ten", cvol_log10(power_of_ten), i);
        expect("a power of ten", cvol_pow(10, i), power_of_ten);
    }
    for (int i = 1; i < 1000; i++) {
        expect("a square", cvol_pow(i, 2), (double)i * i);
        expect("a hypotenuse", cvol_hypot(3 * i, -4 * i), 5 * i);
    }
    for (int i = -20; i < 20; i++) {
        assert_true(cvol_exp2f((float)i) == (float)ldexp(1, i));
        assert_true(cvol_log2f((float)ldexp(1, i)) == (float)i);
    }
    expect("sin 0", cvol_sin(0), 0);
    expect("cos 0", cvol_cos(0), 1);
    expect("exp 0", cvol_exp(0), 1);
    expect("log 1", cvol_log(1), 0);
    expect("a tiny sine", cvol_sin(0x1p-1070), 0x1p-1070);
    expect("the smallest power", cvol_exp(-745), 0x1p-1074);
    expect("log of the smallest number", cvol_log2(0x1p-1074), -1074);
    expect("a large length", cvol_hypot(0x1p1022, 0x1p900), 0x1p1022);
    expect("a small length", cvol_hypot(0x3p-1074, 0x4p-1074), 0x5p-1074);
}

static void test_special_values(void **state)
{
    (void)state;
    const double infinity = (double)INFINITY, none = (double)NAN;
    double both[2];
    cvol_sincos(both, infinity);
    expect("cos infinity", both[0], none);
    expect("sin infinity", both[1], none);
    expect("sin infinity", cvol_sin(infinity), none);
    expect("cos of no number", cvol_cos(none), none);
    expect("exp 710", cvol_exp(710), infinity);
    expect("exp infinity", cvol_exp(infinity), infinity);
    expect("exp -infinity", cvol_exp(-infinity), 0);
    expect("exp of no number", cvol_exp(none), none);
    expect("log 0", cvol_log(0), -infinity);
    expect("log2 infinity", cvol_log2(infinity), infinity);
    expect("log10 -1", cvol_log10(-1), none);
    expect("log of no number", cvol_log(none), none);
    expect("0^2", cvol_pow(0, 2), 0);
    expect("0^-1", cvol_pow(0, -1), infinity);
    expect("infinity^0", cvol_pow(infinity, 0), 1);
    expect("2^infinity", cvol_pow(2, infinity), infinity);
    expect("a length of 0", cvol_hypot(0, -0.0), 0);
    expect("an infinite length", cvol_hypot(none, infinity), infinity);
    assert_true(cvol_exp2f(1000) == INFINITY && cvol_exp2f(-1000) == 0);
    assert_true(cvol_log2f(0) == -INFINITY);
}

int main(void)
{
    const char *seed = getenv("CVOL_ELEMENTARY_SEED");
    numbers.state = seed ? strtoull(seed, NULL, 10) : 1;
    printf("CVOL_ELEMENTARY_SEED=%llu\n", (unsigned long long)numbers.state);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_errors),
        cmocka_unit_test(test_bits),
        cmocka_unit_test(test_exact_values),
        cmocka_unit_test(test_special_values),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
