#include "test.h"

#include "support_operations.h"

#include "cvol/algebra.h"

const struct whole_shape whole_shapes[WHOLE_SHAPES] = {
    {1, {1, 1, 1}},  {1, {2, 1, 1}},  {1, {3, 1, 1}}, {1, {4, 1, 1}}, {1, {7, 1, 1}},
    {1, {16, 1, 1}}, {1, {31, 1, 1}}, {2, {5, 1, 1}}, {2, {1, 6, 1}}, {2, {6, 9, 1}},
    {2, {8, 8, 1}},  {2, {2, 13, 1}}, {3, {4, 5, 3}}, {3, {6, 4, 2}}, {3, {7, 1, 5}},
    {3, {8, 6, 4}},  {3, {2, 2, 2}},
};

static double worst; /* relative error of a result's samples, over all tests */

support_whole whole_make(cvol_context *context, random_state *r, cvol_transform transform,
                         const struct whole_shape *shape, int round)
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

void whole_each(cvol_context *context, random_state *r, cvol_transform first, int rounds,
                void (*check)(cvol_context *context, random_state *r, const whole_case *w))
{
    for (size_t s = 0; s < WHOLE_SHAPES; s++)
        for (int t = (int)first; t <= CVOL_DFT; t++)
            for (int round = 0; round < rounds; round++) {
                const size_t *dims = whole_shapes[s].dims;
                whole_case w = {.shape = &whole_shapes[s],
                                .count = dims[0] * dims[1] * dims[2],
                                .transform = (cvol_transform)t,
                                .round = round,
                                .seed = r->state};
                w.a = whole_make(context, r, w.transform, w.shape, round);
                w.samples = support_whole_samples(w.a.array);
                check(context, r, &w);
                free(w.samples);
                support_whole_free(&w.a);
            }
}

void whole_check(const char *what, uint64_t seed, const cvol_array *result, const double *dense,
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
    cvol_array_get_info(&info, result);
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

double *whole_apply(double *in, size_t dims[3], int axis, const double *matrix, size_t n_new)
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

double *whole_copy(const double *in, size_t count)
{
    double *out = support_doubles(count);
    memcpy(out, in, count * sizeof *out);
    return out;
}

double *whole_filtered(const double *in, const size_t dims[3], const cvol_kernel *kernel,
                       int mirrored)
{
    const size_t N = dims[0] * dims[1] * dims[2];
    double *sum = support_doubles(N);
    for (int t = 0; t < kernel->parts; t++) {
        double *part = whole_copy(in, N);
        size_t shape[3] = {dims[0], dims[1], dims[2]};
        for (int a = 0; a < 3; a++) {
            const cvol_kernel_line *line = &kernel->line[t][a];
            const size_t n = dims[a];
            double *matrix = support_doubles(n * n);
            for (size_t x = 0; x < n; x++)
                for (int i = -line->radius; i <= line->radius; i++)
                    matrix[x * n + extended((ptrdiff_t)x - i, n, mirrored)] += tap(line, i);
            part = whole_apply(part, shape, a, matrix, n);
            free(matrix);
        }
        for (size_t i = 0; i < N; i++)
            sum[i] += kernel->weight[t] * part[i];
        free(part);
    }
    return sum;
}

int whole_set_up(void **state)
{
    *state = cvol_context_create();
    return *state ? 0 : -1;
}

int whole_tear_down(void **state)
{
    print_message("worst relative error %.3g\n", worst);
    cvol_context_free(*state);
    return 0;
}
