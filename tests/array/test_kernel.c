/* Small filters: taps, responses, certified bounds against brute force, and refusals. */
#include "test.h"

#include "array/convolve/kernel.h"
#include "cvol/algebra.h"
#include "random.h"
#include "support.h"

static const double PI = 3.14159265358979323846;

/* All taps of a kernel, (2 R + 1)^3 from -R on, x fastest; R is the largest radius. */
enum { WIDEST = 4, WIDTH = 2 * WIDEST + 1 };

static double tap(const cvol_kernel_line *line, int i)
{
    const int at = i < 0 ? -i : i;
    if (at > line->radius)
        return 0;
    return i < 0 && line->antisymmetric ? -line->taps[at] : line->taps[at];
}

static double tap3(const cvol_kernel *kernel, int i, int j, int l)
{
    double sum = 0;
    for (int t = 0; t < kernel->parts; t++)
        sum += kernel->weight[t] * tap(&kernel->line[t][0], i) * tap(&kernel->line[t][1], j) *
               tap(&kernel->line[t][2], l);
    return sum;
}

/* |H| of all taps at a frequency. */
static double magnitude(const cvol_kernel *kernel, const double omega[3])
{
    double re = 0, im = 0;
    for (int l = -WIDEST; l <= WIDEST; l++)
        for (int j = -WIDEST; j <= WIDEST; j++)
            for (int i = -WIDEST; i <= WIDEST; i++) {
                const double h = tap3(kernel, i, j, l);
                const double phase = omega[0] * i + omega[1] * j + omega[2] * l;
                re += h * cos(phase);
                im -= h * sin(phase);
            }
    return hypot(re, im);
}

static cvol_kernel random_kernel(random_state *r, int rank)
{
    cvol_kernel kernel;
    memset(&kernel, 0, sizeof kernel);
    kernel.parts = 1 + (int)random_below(r, CVOL_KERNEL_PARTS);
    for (int t = 0; t < kernel.parts; t++) {
        kernel.weight[t] = 3 * random_signed(r);
        for (int a = 0; a < 3; a++) {
            cvol_kernel_line *line = &kernel.line[t][a];
            line->taps[0] = 1;
            if (a >= rank)
                continue;
            line->radius = (int)random_below(r, WIDEST + 1);
            line->antisymmetric = line->radius && random_below(r, 3) == 0;
            for (int i = 0; i <= line->radius; i++)
                line->taps[i] = line->antisymmetric && !i ? 0 : random_signed(r);
        }
    }
    return kernel;
}

static void responses_are_the_sums(void **state)
{
    (void)state;
    random_state r = {1};
    for (int round = 0; round < 200; round++) {
        const uint64_t seed = r.state;
        const cvol_kernel kernel = random_kernel(&r, 1);
        const cvol_kernel_line *line = &kernel.line[0][0];
        const double omega = 4 * random_signed(&r);
        double re = 0, im = 0;
        for (int i = -line->radius; i <= line->radius; i++) {
            re += tap(line, i) * cos(omega * i);
            im -= tap(line, i) * sin(omega * i);
        }
        const double h = cvol_kernel_response(line, omega);
        if (fabs(h - (line->antisymmetric ? im : re)) > 1e-12 ||
            fabs(line->antisymmetric ? re : im) > 1e-12)
            fail_msg("seed %llu: H(%g) is %g, not %g + %g i", (unsigned long long)seed, omega, h,
                     re, im);
    }
}

static void bounds_hold(void **state)
{
    (void)state;
    random_state r = {2};
    for (int round = 0; round < 60; round++) {
        const uint64_t seed = r.state;
        const int rank = 1 + round % 3;
        const cvol_kernel kernel = random_kernel(&r, rank);
        double norm, sum, most = 0, taps = 0;
        cvol_kernel_bounds(&kernel, &norm, &sum);
        const int points = rank == 1 ? 2000 : rank == 2 ? 40 : 9;
        for (int w = 0; w < (rank > 2 ? points : 1); w++)
            for (int v = 0; v < (rank > 1 ? points : 1); v++)
                for (int u = 0; u < points; u++) {
                    const double step = 2 * PI / points;
                    most = fmax(most,
                                magnitude(&kernel, (double[3]){u * step, v * step, w * step}));
                }
        for (int l = -WIDEST; l <= WIDEST; l++)
            for (int j = -WIDEST; j <= WIDEST; j++)
                for (int i = -WIDEST; i <= WIDEST; i++)
                    taps += fabs(tap3(&kernel, i, j, l));
        if (!(most <= norm) || !(taps <= sum) || !(norm <= sum))
            fail_msg("seed %llu: |H| %.9g bound %.9g, sum %.9g bound %.9g",
                     (unsigned long long)seed, most, norm, taps, sum);
        if (rank == 1 && kernel.parts == 1) /* then it is tight, too */
            assert_true(norm <= 1.01 * most);
    }
}

static void known_kernels(void **state)
{
    cvol_context *context = *state;
    cvol_kernel k;
    double norm, sum;
    for (int rank = 1; rank <= 3; rank++) {
        assert_int_equal(cvol_kernel_gaussian(context, &k, rank, 1.7), CVOL_OK);
        assert_int_equal(cvol_kernel_radius(&k, rank - 1), 7);
        assert_int_equal(cvol_kernel_check(context, &k), CVOL_OK);
        cvol_kernel_bounds(&k, &norm, &sum);
        assert_true(fabs(norm - 1) < 1e-12 && fabs(sum - 1) < 1e-12);

        assert_int_equal(cvol_kernel_box(context, &k, rank, 5), CVOL_OK);
        cvol_kernel_bounds(&k, &norm, &sum);
        assert_true(fabs(norm - 1) < 1e-12 && fabs(sum - 1) < 1e-12);

        assert_int_equal(cvol_kernel_laplacian(context, &k, rank), CVOL_OK);
        cvol_kernel_bounds(&k, &norm, &sum);
        assert_true(fabs(norm - 4 * rank) < 1e-11 && fabs(sum - 4 * rank) < 1e-11);

        assert_int_equal(cvol_kernel_derivative(context, &k, rank, rank - 1), CVOL_OK);
        cvol_kernel_bounds(&k, &norm, &sum);
        assert_true(fabs(norm - 1) < 1e-12 && fabs(sum - 1) < 1e-12);
        assert_true(tap(&k.line[0][rank - 1], -1) == 0.5); /* takes a[x + 1] */

        /* (1 + a) - a G with 0 < G <= 1 except for ripples: at most 1 + a, while the sum gives 1 +
         * 2 a */
        assert_int_equal(cvol_kernel_unsharp(context, &k, rank, 2, 0.5), CVOL_OK);
        cvol_kernel_bounds(&k, &norm, &sum);
        assert_true(norm > 1.49 && norm < 1.51 && fabs(sum - 2) < 1e-12);
    }
    assert_int_equal(cvol_kernel_gaussian(context, &k, 3, 7.75), CVOL_OK);
    assert_int_equal(cvol_kernel_radius(&k, 0), CVOL_KERNEL_RADIUS);
}

static void distinct_taps_have_distinct_kernels(void **state)
{
    cvol_context *context = *state;
    cvol_kernel k;
    const double even[5] = {0.1, 0.3, 0.2, 0.1 + 0.2, 0.1}, odd[3] = {-1, 0, 1};
    const double neither[3] = {1, 2, 3}, wrong[3] = {1, (double)NAN, 1};
    assert_int_equal(cvol_kernel_taps(context, &k, 2, even, 2), CVOL_OK);
    assert_false(k.line[0][0].antisymmetric);
    assert_true(tap(&k.line[0][1], 2) == 0.1 && k.line[0][2].radius == 0);
    assert_int_equal(cvol_kernel_taps(context, &k, 1, odd, 1), CVOL_OK);
    assert_true(k.line[0][0].antisymmetric);
    assert_true(tap(&k.line[0][0], -1) == -1);
    assert_int_equal(cvol_kernel_taps(context, &k, 1, neither, 1), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "neither symmetric nor antisymmetric"));
    assert_int_equal(cvol_kernel_taps(context, &k, 1, wrong, 1), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "tap 1"));
    assert_int_equal(cvol_kernel_taps(context, &k, 1, odd, 32), CVOL_ERROR_ARGUMENT);
}

static void parsing(void **state)
{
    cvol_context *context = *state;
    cvol_kernel k, like;
    assert_int_equal(cvol_kernel_parse(context, &k, 3, "gaussian:2"), CVOL_OK);
    assert_int_equal(cvol_kernel_gaussian(context, &like, 3, 2), CVOL_OK);
    assert_memory_equal(&k, &like, sizeof k);
    assert_int_equal(cvol_kernel_parse(context, &k, 2, "box:7"), CVOL_OK);
    assert_int_equal(cvol_kernel_box(context, &like, 2, 7), CVOL_OK);
    assert_memory_equal(&k, &like, sizeof k);
    assert_int_equal(cvol_kernel_parse(context, &k, 1, "laplacian"), CVOL_OK);
    assert_int_equal(cvol_kernel_parse(context, &k, 3, "unsharp:1.5"), CVOL_OK);
    assert_true(k.weight[0] == 2);
    assert_int_equal(cvol_kernel_parse(context, &k, 3, "unsharp:1.5,0.25"), CVOL_OK);
    assert_true(k.weight[0] == 1.25 && k.weight[1] == -0.25);
    assert_int_equal(cvol_kernel_parse(context, &k, 3, "derivative:y"), CVOL_OK);
    assert_true(k.line[0][1].antisymmetric);

    static const struct {
        int rank;
        const char *text, *says;
    } bad[] = {
        {3, "foo:2", "kernel 'foo:2' is unknown; there are gaussian:SIGMA"},
        {3, "", "unknown"},
        {3, "laplacian:2", "unknown"},
        {3, "gauss:2", "unknown"},
        {3, "gaussian", "sigma '' is not a number"},
        {3, "gaussian:x", "sigma 'x' is not a number"},
        {3, "gaussian:2x", "sigma '2x' is not a number"},
        {3, "gaussian:nan", "is not a number"},
        {3, "gaussian:0", "sigma is 0"},
        {3, "gaussian:-1", "sigma is -1"},
        {3, "gaussian:8", "at most 7.75"},
        {3, "box:4", "width is 4"},
        {3, "box:2.5", "width is 2.5"},
        {3, "box:65", "width is 65"},
        {3, "box:1e300", "whole number"},
        {3, "unsharp:1,", "amount '' is not a number"},
        {3, "unsharp:1,2,3", "amount '2,3' is not a number"},
        {3, "derivative:", "axis '' is not x, y or z"},
        {3, "derivative:xy", "axis 'xy' is not x, y or z"},
        {2, "derivative:z", "an array of rank 2 has no axis z"},
        {4, "laplacian", "rank is 4"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_int_equal(cvol_kernel_parse(context, &k, bad[i].rank, bad[i].text),
                         CVOL_ERROR_ARGUMENT);
        if (!strstr(cvol_context_message(context), bad[i].says))
            fail_msg("'%s': %s", bad[i].text, cvol_context_message(context));
    }
}

static void parsing_in_a_locale_with_comma(void **state)
{
    cvol_kernel k, like;
    char *before = support_locale_with_comma();
    assert_int_equal(cvol_kernel_parse(*state, &k, 3, "gaussian:1.5"), CVOL_OK);
    assert_int_equal(cvol_kernel_gaussian(*state, &like, 3, 1.5), CVOL_OK);
    assert_memory_equal(&k, &like, sizeof k);
    support_locale_restore(before);
}

static void broken_kernels_are_refused(void **state)
{
    cvol_context *context = *state;
    cvol_kernel good, k;
    assert_int_equal(cvol_kernel_derivative(context, &good, 3, 0), CVOL_OK);
    assert_int_equal(cvol_kernel_check(context, &good), CVOL_OK);
    k = good;
    k.parts = 5;
    assert_int_equal(cvol_kernel_check(context, &k), CVOL_ERROR_ARGUMENT);
    k = good;
    k.parts = 0;
    assert_int_equal(cvol_kernel_check(context, &k), CVOL_ERROR_ARGUMENT);
    k = good;
    k.line[0][2].radius = 32;
    assert_int_equal(cvol_kernel_check(context, &k), CVOL_ERROR_ARGUMENT);
    k = good;
    k.weight[0] = (double)INFINITY;
    assert_int_equal(cvol_kernel_check(context, &k), CVOL_ERROR_ARGUMENT);
    k = good;
    k.line[0][0].taps[1] = (double)NAN;
    assert_int_equal(cvol_kernel_check(context, &k), CVOL_ERROR_ARGUMENT);
    k = good;
    k.line[0][0].taps[0] = 1;
    assert_int_equal(cvol_kernel_check(context, &k), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "antisymmetric"));
}

static int set_up(void **state)
{
    *state = cvol_context_create();
    return *state ? 0 : -1;
}

static int tear_down(void **state)
{
    cvol_context_free(*state);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(responses_are_the_sums),
        cmocka_unit_test(bounds_hold),
        cmocka_unit_test(known_kernels),
        cmocka_unit_test(distinct_taps_have_distinct_kernels),
        cmocka_unit_test(parsing),
        cmocka_unit_test(parsing_in_a_locale_with_comma),
        cmocka_unit_test(broken_kernels_are_refused),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
