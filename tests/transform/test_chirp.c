/* The chirp z-transform against its direct sum, and its adjoint against it. */
#include "test.h"

#include "base/context.h"
#include "random.h"
#include "support_context.h"
#include "transform/chirp.h"
#include "transform/fft.h"
#include "transform/phase.h"

#define PI 3.14159265358979323846

/* The phase in turns, as exact as a long double allows. */
static double phase(const cvol_chirp_shape *shape, size_t j, size_t u)
{
    long double place = fmodl((long double)shape->start + (long double)j * (long double)shape->step,
                              (long double)shape->n);
    long double t = place * ((long double)shape->first + (long double)u) / (long double)shape->n;
    return (double)(t - roundl(t));
}

/* The largest relative error of both directions, |.|_2. */
static double error_of(const cvol_chirp_shape *shape, uint64_t seed)
{
    random_state r = {.state = seed};
    double error = 0;
    for (int adjoint = 0; adjoint < 2; adjoint++) {
        const size_t inputs = adjoint ? shape->points : shape->frequencies;
        const size_t outputs = adjoint ? shape->frequencies : shape->points;
        cvol_chirp *chirp;
        assert_int_equal(cvol_chirp_create(context, &chirp, shape, adjoint), CVOL_OK);
        float *in = cvol_fft_allocate(2 * 3 * inputs), *out = cvol_fft_allocate(2 * 2 * outputs);
        float *work = cvol_fft_allocate(cvol_chirp_work(chirp));
        for (size_t i = 0; i < 2 * 3 * inputs; i++)
            in[i] = (float)random_signed(&r);
        assert_int_equal(cvol_chirp_apply(context, chirp, out, 2, in, 3, work), CVOL_OK);
        double off = 0, of = 0;
        for (size_t o = 0; o < outputs; o++) {
            double re = 0, im = 0;
            for (size_t i = 0; i < inputs; i++) {
                const double t = 2 * PI * (adjoint ? -phase(shape, i, o) : phase(shape, o, i));
                const double a = (double)in[6 * i], b = (double)in[6 * i + 1];
                re += a * cos(t) - b * sin(t);
                im += a * sin(t) + b * cos(t);
            }
            off += pow((double)out[4 * o] - re, 2) + pow((double)out[4 * o + 1] - im, 2);
            of += re * re + im * im;
        }
        error = fmax(error, sqrt(off / of));
        free(in);
        free(out);
        free(work);
        cvol_chirp_free(chirp);
    }
    return error;
}

static void test_equals_direct_sums(void **state)
{
    (void)state;
    random_state r = {.state = 3};
    double worst = 0;
    for (uint64_t seed = 1; seed <= 120; seed++) {
        const double n = 1 + (double)random_below(&r, 300);
        const cvol_chirp_shape shape = {.first = (int64_t)random_below(&r, 40) - 20,
                                        .frequencies = 1 + random_below(&r, 90),
                                        .start = n * random_signed(&r),
                                        .step = 3 * random_signed(&r),
                                        .points = 1 + random_below(&r, 120),
                                        .n = n};
        const double error = error_of(&shape, seed);
        worst = fmax(worst, error);
        if (error > 1e-5)
            fail_msg("seed %d: off by %g", (int)seed, error);
    }
    print_message("chirp: largest relative error %.2g\n", worst);
}

/* Long periods, high frequencies, far points. */
static void test_phases_stay_exact(void **state)
{
    (void)state;
    const cvol_chirp_shape far = {.first = INT64_C(1) << 31,
                                  .frequencies = 50,
                                  .start = 12345.25,
                                  .step = 1048577.5,
                                  .points = 60,
                                  .n = 4294967296.0};
    assert_true(error_of(&far, 1) < 1e-5);
    const cvol_chirp_shape odd = {.first = -2000000011,
                                  .frequencies = 40,
                                  .start = -3.1e6,
                                  .step = 0.3,
                                  .points = 1500,
                                  .n = 4000000021.0};
    assert_true(error_of(&odd, 2) < 1e-5);
    const cvol_chirp_shape negative = {
        .first = -700, .frequencies = 1401, .start = 0.5, .step = -0.37, .points = 700, .n = 1400};
    assert_true(error_of(&negative, 3) < 1e-5);
}

/* Start 0 and step 1 on the whole period is the inverse DFT: an impulse becomes a wave. */
static void test_one_frequency(void **state)
{
    (void)state;
    const cvol_chirp_shape shape = {
        .first = 5, .frequencies = 1, .start = 0, .step = 0.25, .points = 64, .n = 16};
    assert_true(error_of(&shape, 4) < 1e-6);
}

#ifdef __SIZEOF_INT128__
__extension__ typedef unsigned __int128 wide;

static wide wide_of(cvol_phase p)
{
    return (wide)p.high << 64 | p.low;
}

/* floor(2^128 a / n) of integers, a < n */
static wide quotient(uint64_t a, uint64_t n)
{
    const wide high = ((wide)a << 64) / n, rest = ((wide)a << 64) % n;
    return high << 64 | (rest << 64) / n;
}

static void test_phases_equal_wide_integers(void **state)
{
    (void)state;
    random_state r = {.state = 5};
    for (int i = 0; i < 100000; i++) {
        const cvol_phase a = {random_u64(&r), i % 3 ? random_u64(&r) : 0};
        const cvol_phase b = {random_u64(&r), random_u64(&r)};
        const int64_t times = (int64_t)(random_u64(&r) >> random_below(&r, 64));
        const cvol_phase signed_number = {times < 0 ? UINT64_MAX : 0, (uint64_t)times};
        const uint64_t n = 2 + (random_u64(&r) >> (11 + random_below(&r, 52)));
        const uint64_t of = random_u64(&r) >> (11 + random_below(&r, 53));
        assert_true(wide_of(cvol_phase_negate(a)) == -wide_of(a));
        assert_true(wide_of(cvol_phase_add(a, b)) == wide_of(a) + wide_of(b));
        assert_true(wide_of(cvol_phase_multiply(a, times)) == wide_of(a) * wide_of(signed_number));
        assert_true(wide_of(cvol_phase_of((double)of, (double)n)) == quotient(of % n, n));
        assert_true(wide_of(cvol_phase_of(-(double)of, (double)n)) == -quotient(of % n, n));
    }
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_equals_direct_sums),
        cmocka_unit_test(test_phases_stay_exact),
        cmocka_unit_test(test_one_frequency),
#ifdef __SIZEOF_INT128__
        cmocka_unit_test(test_phases_equal_wide_integers),
#endif
    };
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
