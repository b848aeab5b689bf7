/* Convolution, shift, resampling and gradient of whole arrays, against the same computed on all
 * samples in double precision: the result's samples, and that every bound holds for the exact
 * samples. */
#include "test.h"

#include "cvol/algebra.h"
#include "support_operations.h"
#include "transform/whole.h"

static const double PI = 3.14159265358979323846;

/* ---- the same on samples ------------------------------------------------------------------- */

/* The weight of sample j at real x: n samples, periodic. */
static double periodic_tap(double x, size_t j, size_t n)
{
    double sum = 1;
    for (size_t u = 1; 2 * u < n; u++)
        sum += 2 * cos(2 * PI * (double)u * (x - (double)j) / (double)n);
    if (n % 2 == 0)
        sum += cos(PI * x) * cos(PI * (double)j);
    return sum / (double)n;
}

static double *shifted(const double *in, const size_t dims[3], const double offset[3])
{
    double *out = whole_copy(in, dims[0] * dims[1] * dims[2]);
    size_t shape[3] = {dims[0], dims[1], dims[2]};
    for (int a = 0; a < 3; a++) {
        const size_t n = dims[a];
        double *matrix = support_doubles(n * n);
        for (size_t x = 0; x < n; x++)
            for (size_t j = 0; j < n; j++) {
                /* the Nyquist frequency: cos(pi offset) times the value at x */
                double h = periodic_tap((double)x - offset[a], j, n);
                if (n % 2 == 0)
                    h += (cos(PI * offset[a]) * cos(PI * (double)x) * cos(PI * (double)j) -
                          cos(PI * ((double)x - offset[a])) * cos(PI * (double)j)) /
                         (double)n;
                matrix[x * n + j] = h;
            }
        out = whole_apply(out, shape, a, matrix, n);
        free(matrix);
    }
    return out;
}

static double resample_tap(cvol_transform transform, size_t x, size_t j, size_t n, size_t n_new)
{
    const size_t held = n < n_new ? n : n_new;
    const double length = (double)n, ratio = length / (double)n_new;
    double sum = 1;
    if (transform == CVOL_DCT) {
        for (size_t u = 1; u < held; u++)
            sum += 2 * cos(PI * (double)u * ((double)x + 0.5) / (double)n_new) *
                   cos(PI * (double)u * ((double)j + 0.5) / length);
        return sum / length;
    }
    const double at = (double)x * ratio;
    if (n_new >= n)
        return periodic_tap(at, j, n);
    for (size_t u = 1; 2 * u < n_new; u++)
        sum += 2 * cos(2 * PI * (double)u * (at - (double)j) / length);
    if (n_new % 2 == 0)
        sum += 2 * cos(PI * (double)n_new * (at - (double)j) / length);
    return sum / length;
}

static double *resampled(const double *in, const size_t dims[3], const size_t to[3],
                         cvol_transform transform)
{
    double *out = whole_copy(in, dims[0] * dims[1] * dims[2]);
    size_t shape[3] = {dims[0], dims[1], dims[2]};
    for (int a = 0; a < 3; a++) {
        const size_t n = dims[a];
        double *matrix = support_doubles(n * to[a]);
        for (size_t x = 0; x < to[a]; x++)
            for (size_t j = 0; j < n; j++)
                matrix[x * n + j] = n == to[a] ? (double)(x == j)
                                               : resample_tap(transform, x, j, n, to[a]);
        out = whole_apply(out, shape, a, matrix, to[a]);
        free(matrix);
    }
    return out;
}

static double *convolved(const double *a, const double *b, const size_t dims[3])
{
    const size_t N = dims[0] * dims[1] * dims[2];
    double *out = support_doubles(N);
    for (size_t i = 0; i < N; i++)
        for (size_t j = 0; j < N; j++) {
            size_t at = 0, stride = 1;
            for (size_t x = 0, p = i, q = j; x < 3; x++) {
                at += stride * ((p % dims[x] + q % dims[x]) % dims[x]);
                stride *= dims[x];
                p /= dims[x];
                q /= dims[x];
            }
            out[at] += a[i] * b[j];
        }
    return out;
}

static double *gradient(const double *in, const size_t dims[3], int rank, const double spacing[3],
                        int mirrored)
{
    const size_t N = dims[0] * dims[1] * dims[2];
    double *out = support_doubles(N);
    cvol_context *context = cvol_context_create();
    for (int a = 0; a < rank; a++) {
        cvol_kernel kernel;
        assert_int_equal(cvol_kernel_derivative(context, &kernel, rank, a), CVOL_OK);
        double *d = whole_filtered(in, dims, &kernel, mirrored);
        for (size_t i = 0; i < N; i++)
            out[i] += d[i] * d[i] / (spacing[a] * spacing[a]);
        free(d);
    }
    cvol_context_free(context);
    for (size_t i = 0; i < N; i++)
        out[i] = sqrt(out[i]);
    return out;
}

/* ---- the others ------------------------------------------------------------------------------ */

static void check_convolution_of_samples(cvol_context *context, random_state *r,
                                         const whole_case *w)
{
    support_whole b = whole_make(context, r, w->transform, w->shape, 5 * w->round + 1);
    double *y = support_whole_samples(b.array);
    double *dense = convolved(w->samples, y, w->shape->dims);
    double *exact = convolved(w->a.exact, b.exact, w->shape->dims);
    cvol_array *result;
    assert_int_equal(cvol_array_convolve(context, &result, w->a.array, b.array, NULL), CVOL_OK);
    whole_check("convolve", w->seed, result, dense, exact,
                support_norm(w->samples, w->count) * support_norm(y, w->count));
    cvol_array_free(result);
    free(y);
    free(dense);
    free(exact);
    support_whole_free(&b);
}

static void convolution_equals_that_of_samples(void **state)
{
    random_state r = {2};
    whole_each(*state, &r, CVOL_DHT, 6, check_convolution_of_samples);
}

static void check_shift(cvol_context *context, random_state *r, const whole_case *w)
{
    double offset[3] = {0, 0, 0};
    for (int axis = 0; axis < w->shape->rank; axis++)
        offset[axis] = w->round % 3 ? 20 * random_signed(r) : (double)random_below(r, 30) - 15;
    double *dense = shifted(w->samples, w->shape->dims, offset);
    double *exact = shifted(w->a.exact, w->shape->dims, offset);
    cvol_array *result, *back;
    assert_int_equal(cvol_array_shift(context, &result, w->a.array, offset), CVOL_OK);
    whole_check("shift", w->seed, result, dense, exact, support_norm(w->samples, w->count));
    for (int axis = 0; axis < 3; axis++)
        offset[axis] = -offset[axis];
    assert_int_equal(cvol_array_shift(context, &back, result, offset), CVOL_OK);
    double *forth = shifted(exact, w->shape->dims, offset);
    whole_check("shift back", w->seed, back, NULL, forth, 0);
    double *again = support_whole_samples(back);
    int even = 0;
    for (int axis = 0; axis < w->shape->rank; axis++)
        even |= w->shape->dims[axis] % 2 == 0;
    if (!even || w->round % 3 == 0) /* no Nyquist frequency, or one shifted by whole samples */
        assert_true(support_distance(again, w->samples, w->count) <=
                    1e-5 * support_norm(w->samples, w->count));
    free(again);
    free(forth);
    free(dense);
    free(exact);
    cvol_array_free(result);
    cvol_array_free(back);
}

static void shifts_evaluate_the_interpolant(void **state)
{
    random_state r = {3};
    whole_each(*state, &r, CVOL_DHT, 6, check_shift);
}

static void check_resampling(cvol_context *context, random_state *r, const whole_case *w)
{
    (void)r;
    size_t twice[3], half[3];
    int odd = 0;
    for (int axis = 0; axis < 3; axis++) {
        const size_t n = w->shape->dims[axis];
        twice[axis] = axis < w->shape->rank ? 2 * n : 1;
        half[axis] = n > 1 ? n / 2 : 1;
        odd |= n > 1 && n % 2;
    }
    cvol_array *result, *back;
    assert_int_equal(cvol_array_resample(context, &result, w->a.array, 2, NULL), CVOL_OK);
    double *dense = resampled(w->samples, w->shape->dims, twice, w->transform);
    double *exact = resampled(w->a.exact, w->shape->dims, twice, w->transform);
    whole_check("twice", w->seed, result, dense, exact, 0);
    free(dense);
    free(exact);
    assert_int_equal(cvol_array_resample(context, &back, result, -2, NULL), CVOL_OK);
    double *again = support_whole_samples(back);
    assert_memory_equal(back->grid.dims, w->shape->dims, sizeof back->grid.dims);
    assert_true(support_distance(again, w->samples, w->count) <=
                1e-5 * support_norm(w->samples, w->count));
    for (int axis = 0; axis < 3; axis++) {
        assert_true(fabs(back->grid.spacing[axis] - w->a.array->grid.spacing[axis]) < 1e-12);
        assert_true(fabs(back->grid.origin[axis] - w->a.array->grid.origin[axis]) < 1e-12);
    }
    free(again);
    cvol_array_free(back);
    cvol_array_free(result);

    const int code = cvol_array_resample(context, &result, w->a.array, -2, NULL);
    if (odd) {
        assert_int_equal(code, CVOL_ERROR_ARGUMENT);
    } else {
        assert_int_equal(code, CVOL_OK);
        dense = resampled(w->samples, w->shape->dims, half, w->transform);
        exact = resampled(w->a.exact, w->shape->dims, half, w->transform);
        whole_check("half", w->seed, result, dense, exact, support_norm(w->samples, w->count));
        free(dense);
        free(exact);
        cvol_array_free(result);
    }
}

static void resampling_keeps_the_interpolant(void **state)
{
    random_state r = {4};
    whole_each(*state, &r, CVOL_DCT, 12, check_resampling);
}

static void check_gradient(cvol_context *context, random_state *r, const whole_case *w)
{
    (void)r;
    double *spacing = w->a.array->grid.spacing;
    for (int axis = 0; axis < 3; axis++)
        spacing[axis] = 0.5 + axis;
    double *dense = gradient(w->samples, w->shape->dims, w->shape->rank, spacing,
                             w->transform == CVOL_DCT);
    double *exact = gradient(w->a.exact, w->shape->dims, w->shape->rank, spacing,
                             w->transform == CVOL_DCT);
    cvol_array *result;
    const cvol_keep all = cvol_keep_all();
    assert_int_equal(cvol_array_gradient(context, &result, w->a.array, &all), CVOL_OK);
    whole_check("gradient", w->seed, result, dense, exact, 0);
    cvol_array_free(result);
    assert_int_equal(cvol_array_gradient(context, &result, w->a.array, NULL), CVOL_OK);
    whole_check("gradient, like its input", w->seed, result, NULL, exact, 0);
    assert_true(result->whole.low_count == w->a.array->whole.low_count);
    cvol_array_free(result);
    free(dense);
    free(exact);
}

static void gradients_equal_those_of_samples(void **state)
{
    random_state r = {6};
    whole_each(*state, &r, CVOL_DCT, 6, check_gradient);
}

/* A linear convolution by padding with zeros, through the compressor. */
static void padded_arrays_convolve_linearly(void **state)
{
    cvol_context *context = *state;
    random_state r = {7};
    for (int t = CVOL_DHT; t <= CVOL_DFT; t++) {
        const cvol_grid grid = cvol_grid_make(5, 4, 1, CVOL_FLOAT32);
        float x[20], y[20];
        double exact[80] = {0};
        for (int i = 0; i < 20; i++) {
            x[i] = (float)random_signed(&r);
            y[i] = (float)random_signed(&r);
        }
        for (size_t i = 0; i < 20; i++)
            for (size_t j = 0; j < 20; j++)
                exact[i % 5 + j % 5 + 10 * (i / 5 + j / 5)] += (double)x[i] * (double)y[j];
        cvol_array *a, *b, *result;
        const cvol_keep all = cvol_keep_all();
        assert_int_equal(
            cvol_array_compress_padded(context, &a, x, &grid, 2, (cvol_transform)t, &all), CVOL_OK);
        assert_int_equal(
            cvol_array_compress_padded(context, &b, y, &grid, 2, (cvol_transform)t, &all), CVOL_OK);
        assert_int_equal(cvol_array_convolve(context, &result, a, b, NULL), CVOL_OK);
        assert_true(result->grid.dims[0] == 10 && result->grid.dims[1] == 8);
        whole_check("linear", 7, result, exact, exact, 0);
        cvol_array_free(a);
        cvol_array_free(b);
        cvol_array_free(result);
    }
}

/* ---- refusals -------------------------------------------------------------------------------- */

static void refused(cvol_context *context, int code, int expected, const char *says)
{
    assert_int_equal(code, expected);
    if (!strstr(cvol_context_message(context), says))
        fail_msg("'%s' does not say '%s'", cvol_context_message(context), says);
}

static void sentences(void **state)
{
    cvol_context *context = *state;
    random_state r = {8};
    const struct whole_shape six = {2, {6, 6, 1}}, five = {2, {5, 6, 1}};
    support_whole dct = whole_make(context, &r, CVOL_DCT, &six, 0);
    support_whole dft = whole_make(context, &r, CVOL_DFT, &six, 0);
    support_whole dht = whole_make(context, &r, CVOL_DHT, &six, 0);
    support_whole odd = whole_make(context, &r, CVOL_DFT, &five, 0);
    cvol_array *out, *blocks;
    cvol_kernel k;
    const cvol_grid grid = cvol_grid_make(20, 20, 1, CVOL_FLOAT32);
    assert_int_equal(cvol_array_create_as(context, &blocks, &grid, 2, CVOL_DFT, 16), CVOL_OK);

    refused(context, cvol_array_convolve(context, &out, dct.array, dct.array, NULL),
            CVOL_ERROR_UNSUPPORTED, "dht or dft");
    assert_null(out);
    refused(context, cvol_array_convolve(context, &out, dft.array, odd.array, NULL),
            CVOL_ERROR_ARGUMENT, "6x6x1");
    refused(context, cvol_array_convolve(context, &out, dft.array, dht.array, NULL),
            CVOL_ERROR_ARGUMENT, "transform is dft");
    refused(context, cvol_array_convolve(context, &out, blocks, blocks, NULL),
            CVOL_ERROR_UNSUPPORTED, "whole");
    assert_int_equal(cvol_kernel_gaussian(context, &k, 2, 4.1), CVOL_OK);
    refused(context, cvol_array_convolve_kernel(context, &out, blocks, &k, NULL),
            CVOL_ERROR_ARGUMENT, "35 samples wide along x and reaches beyond the next block of 16");
    assert_null(out);
    assert_int_equal(cvol_kernel_gaussian(context, &k, 3, 1), CVOL_OK);
    refused(context, cvol_array_convolve_kernel(context, &out, dft.array, &k, NULL),
            CVOL_ERROR_ARGUMENT, "rank 2");
    k.parts = 0;
    refused(context, cvol_array_convolve_kernel(context, &out, dft.array, &k, NULL),
            CVOL_ERROR_ARGUMENT, "0 parts");

    const double offset[3] = {1, 0, 0}, endless[3] = {(double)INFINITY, 0, 0}, z[3] = {0, 0, 1};
    refused(context, cvol_array_shift(context, &out, dct.array, offset), CVOL_ERROR_UNSUPPORTED,
            "dht and dft");
    refused(context, cvol_array_shift(context, &out, blocks, offset), CVOL_ERROR_UNSUPPORTED,
            "block 16");
    refused(context, cvol_array_shift(context, &out, dft.array, endless), CVOL_ERROR_ARGUMENT,
            "along x is inf");
    refused(context, cvol_array_shift(context, &out, dft.array, z), CVOL_ERROR_ARGUMENT, "rank 2");
    refused(context, cvol_array_resample(context, &out, dft.array, 3, NULL), CVOL_ERROR_ARGUMENT,
            "factor is 3");
    refused(context, cvol_array_resample(context, &out, odd.array, -2, NULL), CVOL_ERROR_ARGUMENT,
            "dims[0] is 5");

    assert_int_equal(cvol_kernel_gaussian(context, &k, 2, 1), CVOL_OK);
    k.weight[0] = 1e300;
    refused(context, cvol_array_convolve_kernel(context, &out, dft.array, &k, NULL),
            CVOL_ERROR_DATA, "float32");
    cvol_array_free(blocks);
    support_whole_free(&dct);
    support_whole_free(&dft);
    support_whole_free(&dht);
    support_whole_free(&odd);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(convolution_equals_that_of_samples),
        cmocka_unit_test(shifts_evaluate_the_interpolant),
        cmocka_unit_test(resampling_keeps_the_interpolant),
        cmocka_unit_test(gradients_equal_those_of_samples),
        cmocka_unit_test(padded_arrays_convolve_linearly),
        cmocka_unit_test(sentences),
    };
    return cmocka_run_group_tests(tests, whole_set_up, whole_tear_down);
}
