/* Filters, convolution, shift, resampling and gradient of whole arrays, against the same computed
 * on all samples in double precision: the result's samples, and that every bound holds for the
 * exact samples. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "array/operations.h"
#include "cvol/algebra.h"
#include "random.h"
#include "support_whole.h"
#include "transform/whole.h"

static const double PI = 3.14159265358979323846;

static const struct shape {
    int rank;
    size_t dims[3];
} shapes[] = {
    {1, {1, 1, 1}},  {1, {2, 1, 1}},  {1, {3, 1, 1}}, {1, {4, 1, 1}}, {1, {7, 1, 1}},
    {1, {16, 1, 1}}, {1, {31, 1, 1}}, {2, {5, 1, 1}}, {2, {1, 6, 1}}, {2, {6, 9, 1}},
    {2, {8, 8, 1}},  {2, {2, 13, 1}}, {3, {4, 5, 3}}, {3, {6, 4, 2}}, {3, {7, 1, 5}},
    {3, {8, 6, 4}},  {3, {2, 2, 2}},
};
#define SHAPES (sizeof shapes / sizeof shapes[0])

static double worst; /* relative error of a result's samples, over all tests */

/* What of the array is kept, by the round. */
static support_whole make(cvol_context *context, random_state *r, cvol_transform transform,
                          const struct shape *shape, int round)
{
    static const struct {
        size_t low;
        double share;
    } kinds[] = {{1000, 0}, {0, 1}, {2, 0.3}, {0, 0.3}, {3, 0}, {0, 0}};
    const size_t k = kinds[round % 6].low;
    const size_t low[3] = {k, k, k};
    return support_whole_make(context, r, transform, shape->rank, shape->dims, low,
                              kinds[round % 6].share, round % 2 ? 20 : 0.5);
}

/* Holds a result against `dense`, the operation on the array's samples (NULL: not compared), and
 * against `exact`, the operation on the exact ones. scale: a norm that rounding is a share of. */
static void check(const char *what, uint64_t seed, const cvol_array *result, const double *dense,
                  const double *exact, double scale)
{
    const size_t N = cvol_grid_samples(&result->grid);
    double *samples = support_whole_samples(result);
    if (dense) {
        const double error = support_distance(samples, dense, N);
        const double norm = fmax(scale, support_norm(dense, N));
        if (!(error <= 1e-5 * norm))
            fail_msg("%s, seed %llu: off by %g of %g", what, (unsigned long long)seed, error, norm);
        worst = norm > 0 ? fmax(worst, error / norm) : worst;
    }
    cvol_array_info info;
    cvol_array_get_info(result, &info);
    const double error = support_distance(samples, exact, N);
    if (!(error <= info.l2_error + 1e-12))
        fail_msg("%s, seed %llu: L2 error %.9g, bound %.9g", what, (unsigned long long)seed, error,
                 info.l2_error);
    const double room = 1e-9 * (1 + fabs(info.value_min) + fabs(info.value_max));
    for (size_t i = 0; i < N; i++)
        if (!(fabs(samples[i]) <= info.max_abs + room) || !(exact[i] >= info.value_min - room) ||
            !(exact[i] <= info.value_max + room))
            fail_msg("%s, seed %llu: sample %g, exact %g; bounds %g; %g .. %g", what,
                     (unsigned long long)seed, samples[i], exact[i], info.max_abs, info.value_min,
                     info.value_max);
    free(samples);
}

/* ---- the same on samples
 * ------------------------------------------------------------------------- */

static size_t extended(ptrdiff_t x, size_t n, int mirrored)
{
    const ptrdiff_t length = (ptrdiff_t)n, period = mirrored ? 2 * length : length;
    x = (x % period + period) % period;
    return (size_t)(x < length ? x : period - 1 - x);
}

static double tap(const cvol_kernel_line *line, int i)
{
    const int at = i < 0 ? -i : i;
    return i < 0 && line->antisymmetric ? -line->taps[at] : line->taps[at];
}

/* Applies matrix[new n][n] along an axis; frees `in`. */
static double *apply(double *in, size_t dims[3], int axis, const double *matrix, size_t n_new)
{
    const size_t n = dims[axis];
    const size_t stride = axis == 0 ? 1 : axis == 1 ? dims[0] : dims[0] * dims[1];
    const size_t outer = dims[0] * dims[1] * dims[2] / n / stride;
    double *out = support_doubles(outer * stride * n_new);
    for (size_t l = 0; l < outer; l++)
        for (size_t x = 0; x < n_new; x++)
            for (size_t j = 0; j < n; j++)
                for (size_t i = 0; i < stride; i++)
                    out[i + stride * (x + n_new * l)] += matrix[x * n + j] *
                                                         in[i + stride * (j + n * l)];
    dims[axis] = n_new;
    free(in);
    return out;
}

static double *copy(const double *in, size_t count)
{
    double *out = support_doubles(count);
    memcpy(out, in, count * sizeof *out);
    return out;
}

static double *filtered(const double *in, const size_t dims[3], const cvol_kernel *kernel,
                        int mirrored)
{
    const size_t N = dims[0] * dims[1] * dims[2];
    double *sum = support_doubles(N);
    for (int t = 0; t < kernel->parts; t++) {
        double *part = copy(in, N);
        size_t shape[3] = {dims[0], dims[1], dims[2]};
        for (int a = 0; a < 3; a++) {
            const cvol_kernel_line *line = &kernel->line[t][a];
            const size_t n = dims[a];
            double *matrix = support_doubles(n * n);
            for (size_t x = 0; x < n; x++)
                for (int i = -line->radius; i <= line->radius; i++)
                    matrix[x * n + extended((ptrdiff_t)x - i, n, mirrored)] += tap(line, i);
            part = apply(part, shape, a, matrix, n);
            free(matrix);
        }
        for (size_t i = 0; i < N; i++)
            sum[i] += kernel->weight[t] * part[i];
        free(part);
    }
    return sum;
}

/* What real x sees of sample j: n samples, periodic. */
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
    double *out = copy(in, dims[0] * dims[1] * dims[2]);
    size_t shape[3] = {dims[0], dims[1], dims[2]};
    for (int a = 0; a < 3; a++) {
        const size_t n = dims[a];
        double *matrix = support_doubles(n * n);
        for (size_t x = 0; x < n; x++)
            for (size_t j = 0; j < n; j++) {
                /* the Nyquist frequency: cos(pi offset) times what stood at x */
                double h = periodic_tap((double)x - offset[a], j, n);
                if (n % 2 == 0)
                    h += (cos(PI * offset[a]) * cos(PI * (double)x) * cos(PI * (double)j) -
                          cos(PI * ((double)x - offset[a])) * cos(PI * (double)j)) /
                         (double)n;
                matrix[x * n + j] = h;
            }
        out = apply(out, shape, a, matrix, n);
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
    double *out = copy(in, dims[0] * dims[1] * dims[2]);
    size_t shape[3] = {dims[0], dims[1], dims[2]};
    for (int a = 0; a < 3; a++) {
        const size_t n = dims[a];
        double *matrix = support_doubles(n * to[a]);
        for (size_t x = 0; x < to[a]; x++)
            for (size_t j = 0; j < n; j++)
                matrix[x * n + j] = n == to[a] ? (double)(x == j)
                                               : resample_tap(transform, x, j, n, to[a]);
        out = apply(out, shape, a, matrix, to[a]);
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
        double *d = filtered(in, dims, &kernel, mirrored);
        for (size_t i = 0; i < N; i++)
            out[i] += d[i] * d[i] / (spacing[a] * spacing[a]);
        free(d);
    }
    cvol_context_destroy(context);
    for (size_t i = 0; i < N; i++)
        out[i] = sqrt(out[i]);
    return out;
}

/* ---- kernels
 * --------------------------------------------------------------------------------------- */

static cvol_kernel random_kernel(random_state *r, int rank)
{
    cvol_kernel kernel;
    memset(&kernel, 0, sizeof kernel);
    kernel.parts = 1 + (int)random_below(r, CVOL_KERNEL_PARTS);
    for (int t = 0; t < kernel.parts; t++) {
        kernel.weight[t] = random_signed(r);
        for (int a = 0; a < 3; a++) {
            cvol_kernel_line *line = &kernel.line[t][a];
            line->taps[0] = 1;
            if (a >= rank)
                continue;
            line->radius = (int)random_below(r, 4);
            line->antisymmetric = line->radius && random_below(r, 2) == 0;
            for (int i = 0; i <= line->radius; i++)
                line->taps[i] = line->antisymmetric && !i ? 0 : random_signed(r);
        }
    }
    return kernel;
}

static cvol_kernel some_kernel(cvol_context *context, random_state *r, int rank, int which)
{
    static const char *const names[] = {"gaussian:2",    "box:3",        "laplacian",
                                        "unsharp:1,0.7", "derivative:x", "gaussian:7.5"};
    cvol_kernel kernel;
    if (which < 6)
        assert_int_equal(cvol_kernel_parse(context, &kernel, rank, names[which]), CVOL_OK);
    else if (which == 6)
        assert_int_equal(cvol_kernel_derivative(context, &kernel, rank, rank - 1), CVOL_OK);
    else
        kernel = random_kernel(r, rank);
    return kernel;
}

static void kernels_filter_as_on_samples(void **state)
{
    cvol_context *context = *state;
    random_state r = {1};
    for (size_t s = 0; s < SHAPES; s++)
        for (int t = CVOL_DCT; t <= CVOL_DFT; t++)
            for (int round = 0; round < 12; round++) {
                const uint64_t seed = r.state;
                const struct shape *shape = &shapes[s];
                const size_t N = shape->dims[0] * shape->dims[1] * shape->dims[2];
                support_whole a = make(context, &r, (cvol_transform)t, shape, round);
                const cvol_kernel k = some_kernel(context, &r, shape->rank, (round + (int)s) % 10);
                double *samples = support_whole_samples(a.array);
                double *dense = filtered(samples, shape->dims, &k, t == CVOL_DCT);
                double *exact = filtered(a.exact, shape->dims, &k, t == CVOL_DCT);
                cvol_array *result;
                const cvol_keep all = cvol_keep_all();
                assert_int_equal(cvol_array_convolve_kernel(context, &result, a.array, &k, &all),
                                 CVOL_OK);
                double norm, sum;
                cvol_kernel_bounds(&k, &norm, &sum);
                check("kernel", seed, result, dense, exact, norm * support_norm(samples, N));
                cvol_array_free(result);
                /* like its inputs: no more terms than there were, but for partners; any loss
                 * counted */
                assert_int_equal(cvol_array_convolve_kernel(context, &result, a.array, &k, NULL),
                                 CVOL_OK);
                check("kernel, like its input", seed, result, NULL, exact, 0);
                assert_true(result->whole.sparse_count <= 2 * a.array->whole.sparse_count);
                cvol_array_free(result);
                free(samples);
                free(dense);
                free(exact);
                support_whole_free(&a);
            }
}

/* A mirrored ramp's derivative: 1 inside, 1/2 at both ends, where the last sample is repeated. */
static void derivative_of_mirrored_ramp(void **state)
{
    cvol_context *context = *state;
    const size_t dims[3] = {9, 1, 1}, low[3] = {9, 1, 1};
    random_state r = {5};
    support_whole a = support_whole_make(context, &r, CVOL_DCT, 1, dims, low, 0, 0);
    double ramp[9], slots[9];
    for (int i = 0; i < 9; i++)
        ramp[i] = i;
    cvol_whole_forward_reference(CVOL_DCT, slots, ramp, dims);
    for (int i = 0; i < 9; i++)
        a.array->whole.low_values[i] = (float)slots[i];
    a.array->ledger = (cvol_ledger){.l2_error = 1e-5, .max_abs = 8, .value_min = 0, .value_max = 8};
    cvol_kernel k;
    cvol_array *result;
    assert_int_equal(cvol_kernel_derivative(context, &k, 1, 0), CVOL_OK);
    assert_int_equal(cvol_array_convolve_kernel(context, &result, a.array, &k, NULL), CVOL_OK);
    double *d = support_whole_samples(result);
    for (int i = 0; i < 9; i++)
        assert_true(fabs(d[i] - (i == 0 || i == 8 ? 0.5 : 1)) < 1e-5);
    free(d);
    cvol_array_free(result);
    support_whole_free(&a);
}

/* Kept terms and counted losses under every rule: no error beyond the bound, no better choice. */
static void truncated_results(void **state)
{
    cvol_context *context = *state;
    random_state r = {11};
    const struct shape shape = {3, {8, 6, 5}};
    const size_t N = 240, low[3] = {8, 6, 5};
    for (int t = CVOL_DCT; t <= CVOL_DFT; t++) {
        const cvol_keep keeps[] = {
            cvol_keep_terms(2, 20),   cvol_keep_terms(0, 31), cvol_keep_rho(0.3),  cvol_keep_l2(2),
            cvol_keep_threshold(0.2), cvol_keep_psnr(12),     cvol_keep_ratio(1.5)};
        for (size_t i = 0; i < sizeof keeps / sizeof keeps[0]; i++) {
            const uint64_t seed = r.state;
            support_whole a = support_whole_make(context, &r, (cvol_transform)t, shape.rank,
                                                 shape.dims, low, 0, 1);
            const cvol_kernel k = some_kernel(context, &r, 3, 6 + (int)(i % 2));
            double *samples = support_whole_samples(a.array);
            double *dense = filtered(samples, shape.dims, &k, t == CVOL_DCT);
            double *exact = filtered(a.exact, shape.dims, &k, t == CVOL_DCT);
            cvol_array *result;
            const int code = cvol_array_convolve_kernel(context, &result, a.array, &k, &keeps[i]);
            if (code)
                fail_msg("keep %d, seed %llu: %s", (int)keeps[i].rule, (unsigned long long)seed,
                         cvol_context_message(context));
            check("kernel, truncated", seed, result, NULL, exact, 0);
            /* what was kept is what was there: |dense|^2 = |kept|^2 + |dropped|^2 */
            double *kept = support_whole_samples(result);
            const double all = support_norm(dense, N), one = support_norm(kept, N);
            const double other = support_distance(dense, kept, N);
            assert_true(fabs(all - hypot(one, other)) <= 1e-5 * all);
            if (keeps[i].rule == CVOL_KEEP_L2)
                assert_true(other <= 2 * (1 + 1e-5));
            free(kept);
            free(samples);
            free(dense);
            free(exact);
            cvol_array_free(result);
            support_whole_free(&a);
        }
    }
}

/* ---- the others
 * -------------------------------------------------------------------------------------- */

static void arrays_convolve_as_on_samples(void **state)
{
    cvol_context *context = *state;
    random_state r = {2};
    for (size_t s = 0; s < SHAPES; s++)
        for (int t = CVOL_DHT; t <= CVOL_DFT; t++)
            for (int round = 0; round < 6; round++) {
                const uint64_t seed = r.state;
                const struct shape *shape = &shapes[s];
                const size_t N = shape->dims[0] * shape->dims[1] * shape->dims[2];
                support_whole a = make(context, &r, (cvol_transform)t, shape, round);
                support_whole b = make(context, &r, (cvol_transform)t, shape, 5 * round + 1);
                double *x = support_whole_samples(a.array), *y = support_whole_samples(b.array);
                double *dense = convolved(x, y, shape->dims);
                double *exact = convolved(a.exact, b.exact, shape->dims);
                cvol_array *result;
                assert_int_equal(cvol_array_convolve(context, &result, a.array, b.array, NULL),
                                 CVOL_OK);
                check("convolve", seed, result, dense, exact,
                      support_norm(x, N) * support_norm(y, N));
                cvol_array_free(result);
                free(x);
                free(y);
                free(dense);
                free(exact);
                support_whole_free(&a);
                support_whole_free(&b);
            }
}

static void shifts_read_the_polynomial(void **state)
{
    cvol_context *context = *state;
    random_state r = {3};
    for (size_t s = 0; s < SHAPES; s++)
        for (int t = CVOL_DHT; t <= CVOL_DFT; t++)
            for (int round = 0; round < 6; round++) {
                const uint64_t seed = r.state;
                const struct shape *shape = &shapes[s];
                const size_t N = shape->dims[0] * shape->dims[1] * shape->dims[2];
                support_whole a = make(context, &r, (cvol_transform)t, shape, round);
                double offset[3] = {0, 0, 0};
                for (int axis = 0; axis < shape->rank; axis++)
                    offset[axis] = round % 3 ? 20 * random_signed(&r)
                                             : (double)random_below(&r, 30) - 15;
                double *samples = support_whole_samples(a.array);
                double *dense = shifted(samples, shape->dims, offset);
                double *exact = shifted(a.exact, shape->dims, offset);
                cvol_array *result, *back;
                assert_int_equal(cvol_array_shift(context, &result, a.array, offset), CVOL_OK);
                check("shift", seed, result, dense, exact, support_norm(samples, N));
                for (int axis = 0; axis < 3; axis++)
                    offset[axis] = -offset[axis];
                assert_int_equal(cvol_array_shift(context, &back, result, offset), CVOL_OK);
                double *forth = shifted(exact, shape->dims, offset);
                check("shift back", seed, back, NULL, forth, 0);
                double *again = support_whole_samples(back);
                int even = 0;
                for (int axis = 0; axis < shape->rank; axis++)
                    even |= shape->dims[axis] % 2 == 0;
                if (!even ||
                    round % 3 == 0) /* no Nyquist frequency, or one turned by whole samples */
                    assert_true(support_distance(again, samples, N) <=
                                1e-5 * support_norm(samples, N));
                free(again);
                free(forth);
                free(samples);
                free(dense);
                free(exact);
                cvol_array_free(result);
                cvol_array_free(back);
                support_whole_free(&a);
            }
}

static void resampling_is_the_same_function(void **state)
{
    cvol_context *context = *state;
    random_state r = {4};
    for (size_t s = 0; s < SHAPES; s++)
        for (int t = CVOL_DCT; t <= CVOL_DFT; t++)
            for (int round = 0; round < 12; round++) {
                const uint64_t seed = r.state;
                const struct shape *shape = &shapes[s];
                const size_t N = shape->dims[0] * shape->dims[1] * shape->dims[2];
                support_whole a = make(context, &r, (cvol_transform)t, shape, round);
                double *samples = support_whole_samples(a.array);
                size_t twice[3], half[3];
                int odd = 0;
                for (int axis = 0; axis < 3; axis++) {
                    const size_t n = shape->dims[axis];
                    twice[axis] = axis < shape->rank ? 2 * n : 1;
                    half[axis] = n > 1 ? n / 2 : 1;
                    odd |= n > 1 && n % 2;
                }
                cvol_array *result, *back;
                assert_int_equal(cvol_array_resample(context, &result, a.array, 2, NULL), CVOL_OK);
                double *dense = resampled(samples, shape->dims, twice, (cvol_transform)t);
                double *exact = resampled(a.exact, shape->dims, twice, (cvol_transform)t);
                check("twice", seed, result, dense, exact, 0);
                free(dense);
                free(exact);
                assert_int_equal(cvol_array_resample(context, &back, result, -2, NULL), CVOL_OK);
                double *again = support_whole_samples(back);
                assert_memory_equal(back->grid.dims, shape->dims, sizeof back->grid.dims);
                assert_true(support_distance(again, samples, N) <= 1e-5 * support_norm(samples, N));
                for (int axis = 0; axis < 3; axis++) {
                    assert_true(fabs(back->grid.spacing[axis] - a.array->grid.spacing[axis]) <
                                1e-12);
                    assert_true(fabs(back->grid.origin[axis] - a.array->grid.origin[axis]) < 1e-12);
                }
                free(again);
                cvol_array_free(back);
                cvol_array_free(result);

                const int code = cvol_array_resample(context, &result, a.array, -2, NULL);
                if (odd) {
                    assert_int_equal(code, CVOL_ERROR_ARGUMENT);
                } else {
                    assert_int_equal(code, CVOL_OK);
                    dense = resampled(samples, shape->dims, half, (cvol_transform)t);
                    exact = resampled(a.exact, shape->dims, half, (cvol_transform)t);
                    check("half", seed, result, dense, exact, support_norm(samples, N));
                    free(dense);
                    free(exact);
                    cvol_array_free(result);
                }
                free(samples);
                support_whole_free(&a);
            }
}

static void gradients_are_those_of_samples(void **state)
{
    cvol_context *context = *state;
    random_state r = {6};
    for (size_t s = 0; s < SHAPES; s++)
        for (int t = CVOL_DCT; t <= CVOL_DFT; t++)
            for (int round = 0; round < 6; round++) {
                const uint64_t seed = r.state;
                const struct shape *shape = &shapes[s];
                const size_t N = shape->dims[0] * shape->dims[1] * shape->dims[2];
                support_whole a = make(context, &r, (cvol_transform)t, shape, round);
                double *spacing = a.array->grid.spacing;
                for (int axis = 0; axis < 3; axis++)
                    spacing[axis] = 0.5 + axis;
                double *samples = support_whole_samples(a.array);
                double *dense = gradient(samples, shape->dims, shape->rank, spacing, t == CVOL_DCT);
                double *exact = gradient(a.exact, shape->dims, shape->rank, spacing, t == CVOL_DCT);
                cvol_array *result;
                const cvol_keep all = cvol_keep_all();
                assert_int_equal(cvol_array_gradient(context, &result, a.array, &all), CVOL_OK);
                check("gradient", seed, result, dense, exact, 0);
                cvol_array_free(result);
                assert_int_equal(cvol_array_gradient(context, &result, a.array, NULL), CVOL_OK);
                check("gradient, like its input", seed, result, NULL, exact, 0);
                assert_true(result->whole.low_count == a.array->whole.low_count);
                (void)N;
                cvol_array_free(result);
                free(samples);
                free(dense);
                free(exact);
                support_whole_free(&a);
            }
}

/* A linear convolution by way of zeros, through the compressor. */
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
        check("linear", 7, result, exact, exact, 0);
        cvol_array_free(a);
        cvol_array_free(b);
        cvol_array_free(result);
    }
}

/* ---- what is refused
 * ------------------------------------------------------------------------------- */

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
    const struct shape six = {2, {6, 6, 1}}, five = {2, {5, 6, 1}};
    support_whole dct = make(context, &r, CVOL_DCT, &six, 0);
    support_whole dft = make(context, &r, CVOL_DFT, &six, 0);
    support_whole dht = make(context, &r, CVOL_DHT, &six, 0);
    support_whole odd = make(context, &r, CVOL_DFT, &five, 0);
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

static void same_bits_for_any_threads(void **state)
{
    cvol_context *context = *state;
    random_state r = {9};
    const struct shape shape = {3, {8, 6, 4}};
    for (int t = CVOL_DCT; t <= CVOL_DFT; t++) {
        support_whole a = make(context, &r, (cvol_transform)t, &shape, 2);
        const cvol_kernel k = random_kernel(&r, 3);
        cvol_array *one, *many;
        cvol_context_set_threads(context, 1);
        assert_int_equal(cvol_array_convolve_kernel(context, &one, a.array, &k, NULL), CVOL_OK);
        cvol_context_set_threads(context, 3);
        assert_int_equal(cvol_array_convolve_kernel(context, &many, a.array, &k, NULL), CVOL_OK);
        cvol_context_set_threads(context, 0);
        const cvol_spectrum *x = &one->whole, *y = &many->whole;
        assert_true(x->sparse_count == y->sparse_count);
        assert_memory_equal(x->low_values, y->low_values, x->low_count * sizeof(float));
        assert_memory_equal(x->values, y->values, x->sparse_count * sizeof(float));
        cvol_array_free(one);
        cvol_array_free(many);
        support_whole_free(&a);
    }
}

static int set_up(void **state)
{
    *state = cvol_context_create();
    return *state ? 0 : -1;
}

static int tear_down(void **state)
{
    print_message("worst relative error %.3g\n", worst);
    cvol_context_destroy(*state);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kernels_filter_as_on_samples),
        cmocka_unit_test(derivative_of_mirrored_ramp),
        cmocka_unit_test(truncated_results),
        cmocka_unit_test(arrays_convolve_as_on_samples),
        cmocka_unit_test(shifts_read_the_polynomial),
        cmocka_unit_test(resampling_is_the_same_function),
        cmocka_unit_test(gradients_are_those_of_samples),
        cmocka_unit_test(padded_arrays_convolve_linearly),
        cmocka_unit_test(sentences),
        cmocka_unit_test(same_bits_for_any_threads),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
