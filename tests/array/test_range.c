/* Operations on arrays whose numbers are near the limits of float32: bounds hold, squares neither
 * vanish nor overflow, and values beyond float32 are refused. */
#include "test.h"

#include "cvol/cvol.h"
#include "support_context.h"
#include "support_exact.h"

static const support_shape shapes[] = {
    {{90, 1, 1}, 1, 0, CVOL_DCT},  {{24, 18, 1}, 2, 0, CVOL_DFT}, {{12, 10, 9}, 3, 0, CVOL_DHT},
    {{90, 1, 1}, 1, 16, CVOL_DCT}, {{24, 18, 1}, 2, 8, CVOL_DHT}, {{20, 17, 9}, 3, 16, CVOL_DCT}};
enum { SHAPES = sizeof shapes / sizeof *shapes };

static size_t count_of(const support_shape *s)
{
    return s->dims[0] * s->dims[1] * s->dims[2];
}

/* All terms of samples of about this size; exact: their values. */
static cvol_array *make(double *exact, const support_shape *s, double size)
{
    const cvol_grid grid = cvol_grid_make(s->dims[0], s->dims[1], s->dims[2], CVOL_FLOAT32);
    const cvol_keep keep = cvol_keep_all();
    const size_t *n = s->dims, count = count_of(s);
    float *samples = malloc(count * sizeof *samples);
    cvol_array *array;
    assert_non_null(samples);
    for (size_t i = 0; i < count; i++) {
        samples[i] = (float)(size * (1.5 + sin(0.4 * (double)(i % n[0])) +
                                     cos(0.3 * (double)(i / n[0] % n[1]) + (double)(i % 5))));
        exact[i] = (double)samples[i];
    }
    assert_int_equal(cvol_array_compress(context, &array, samples, &grid, s->rank, s->transform,
                                         s->block, &keep),
                     CVOL_OK);
    free(samples);
    return array;
}

/* The bound holds, and the array's error is at most `share` of its norm. */
static void check(const cvol_array *array, const double *exact, const support_shape *s,
                  double share)
{
    const size_t zero[3] = {0, 0, 0}, count = count_of(s);
    float *samples = malloc(count * sizeof *samples);
    double error = 0, norm = 0, largest = 0;
    cvol_array_info info;
    assert_non_null(samples);
    assert_int_equal(cvol_array_evaluate_real(context, samples, array, zero, s->dims), CVOL_OK);
    cvol_array_get_info(&info, array);
    for (size_t i = 0; i < count; i++) {
        error = hypot(error, (double)samples[i] - exact[i]);
        norm = hypot(norm, exact[i]);
        largest = fmax(largest, fabs((double)samples[i]));
    }
    free(samples);
    if (!(error <= info.l2_error) || !(error <= share * norm))
        print_message("%s block %d: error %g, bound %g, norm %g\n",
                      cvol_transform_name(s->transform), s->block, error, info.l2_error, norm);
    assert_true(error <= info.l2_error);
    assert_true(error <= share * norm);
    assert_true(largest <= info.max_abs * (1 + 1e-6));
}

static void gradients_of_any_size(void **state)
{
    (void)state;
    static const double sizes[] = {1e-30, 1e-22, 1e-19, 1, 1e16};
    for (int i = 0; i < SHAPES; i++)
        for (int k = 0; k < 5; k++) {
            const support_shape *s = &shapes[i];
            const cvol_keep all = cvol_keep_all();
            double *exact = malloc(count_of(s) * sizeof *exact);
            cvol_array *a, *b, *g;
            assert_non_null(exact);
            a = make(exact, s, sizes[k]);
            assert_int_equal(cvol_array_scale(context, &b, k == 4 ? 1e8 : 1, a, 0), CVOL_OK);
            for (size_t j = 0; j < count_of(s) && k == 4; j++)
                exact[j] *= 1e8;
            assert_int_equal(cvol_array_gradient(context, &g, b, &all), CVOL_OK);
            support_gradient(exact, s, cvol_array_grid(b)->spacing);
            check(g, exact, s, 1e-4);
            cvol_array_free(a);
            cvol_array_free(b);
            cvol_array_free(g);
            free(exact);
        }
}

static void bound_includes_underflow(void **state)
{
    (void)state;
    const cvol_keep all = cvol_keep_all();
    for (int i = 0; i < SHAPES; i++)
        for (int size = -38; size <= -16; size += 2) {
            const support_shape *s = &shapes[i];
            const size_t count = count_of(s);
            double *x = malloc(2 * count * sizeof *x), *y = x + count;
            assert_non_null(x);
            cvol_array *a = make(x, s, pow(10, size)), *b = make(y, s, 3e-21), *c;
            check(a, x, s, 1e30);
            assert_int_equal(cvol_array_multiply(context, &c, a, b, &all, CVOL_PLAN_AUTO, NULL),
                             CVOL_OK);
            for (size_t j = 0; j < count; j++)
                y[j] *= x[j];
            check(c, y, s, 1e30);
            cvol_array_free(c);
            assert_int_equal(cvol_array_add(context, &c, 1e-9, a, -2e-9, a, &all), CVOL_OK);
            for (size_t j = 0; j < count; j++)
                y[j] = -1e-9 * x[j];
            check(c, y, s, 1e30);
            cvol_array_free(c);
            assert_int_equal(cvol_array_scale(context, &c, 1e-22, a, 0), CVOL_OK);
            for (size_t j = 0; j < count; j++)
                y[j] = 1e-22 * x[j];
            check(c, y, s, 1e30);
            cvol_array_free(a);
            cvol_array_free(b);
            cvol_array_free(c);
            free(x);
        }
}

static void overflow_is_refused(void **state)
{
    (void)state;
    for (int i = 0; i < SHAPES; i++) {
        const support_shape *s = &shapes[i];
        double *x = malloc(count_of(s) * sizeof *x);
        assert_non_null(x);
        cvol_array *a = make(x, s, 1e10), *b;
        int refused = 0;
        for (double size = 18; size < 30; size += size < 25.5 ? 1 : 0.03) {
            const double factor = pow(10, size);
            const int code = cvol_array_scale(context, &b, factor, a, 0);
            if (code) {
                assert_int_equal(code, CVOL_ERROR_DATA);
                assert_non_null(strstr(cvol_context_message(context), "beyond what"));
                refused++;
                continue;
            }
            assert_int_equal(refused, 0);
            double *y = malloc(count_of(s) * sizeof *y);
            assert_non_null(y);
            for (size_t j = 0; j < count_of(s); j++)
                y[j] = x[j] * factor;
            check(b, y, s, 1e-5);
            free(y);
            cvol_array_free(b);
        }
        assert_true(refused > 3);
        cvol_array_free(a);
        free(x);
    }
}

/* Sums of many terms lose more than fast transforms do. A jump at 129 is about the worst. */
static void bound_grows_for_large_primes(void **state)
{
    (void)state;
    static const size_t lengths[] = {97, 127, 131, 139, 151, 163, 167, 326, 652, 834, 2641, 359};
    for (int i = 0; i < 12; i++)
        for (int transform = CVOL_DCT; transform <= CVOL_DHT; transform++) {
            const support_shape s = {{lengths[i], 1, 1}, 1, 0, (cvol_transform)transform};
            const cvol_grid grid = cvol_grid_make(lengths[i], 1, 1, CVOL_FLOAT32);
            const cvol_keep all = cvol_keep_all();
            float *samples = malloc(lengths[i] * sizeof *samples);
            double *exact = malloc(lengths[i] * sizeof *exact);
            assert_true(samples && exact);
            for (int mean = 0; mean < 2; mean++) {
                cvol_array *array;
                for (size_t x = 0; x < lengths[i]; x++) {
                    samples[x] = mean ? -80.6271591f : x < 129 ? -2 : -0.49f;
                    exact[x] = (double)samples[x];
                }
                assert_int_equal(
                    cvol_array_compress(context, &array, samples, &grid, 1, s.transform, 0, &all),
                    CVOL_OK);
                check(array, exact, &s, 1e-5);
                cvol_array_free(array);
            }
            free(samples);
            free(exact);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gradients_of_any_size),
        cmocka_unit_test(bound_includes_underflow),
        cmocka_unit_test(overflow_is_refused),
        cmocka_unit_test(bound_grows_for_large_primes),
    };
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
