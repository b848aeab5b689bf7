/* The operations on exact samples (support_exact.h). */
#include "support_exact.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double *allocate(size_t count)
{
    double *out = calloc(count, sizeof *out);
    if (!out)
        abort();
    return out;
}

size_t support_extended(const support_shape *s, long x, size_t n)
{
    const int periodic = s->block == 0 && s->transform != CVOL_DCT;
    const long period = periodic ? (long)n : 2 * (long)n;
    x %= period;
    x += x < 0 ? period : 0;
    return (size_t)(x < (long)n ? x : period - 1 - x);
}

static void filter_axis(double *out, const double *in, const support_shape *s,
                        const cvol_kernel_line *line, int axis)
{
    const size_t *n = s->dims, count = n[0] * n[1] * n[2];
    const size_t stride = axis == 0 ? 1 : axis == 1 ? n[0] : n[0] * n[1];
    for (size_t i = 0; i < count; i++) {
        const size_t x = i / stride % n[axis], start = i - x * stride;
        double sum = 0;
        for (int m = -line->radius; m <= line->radius; m++) {
            double tap = line->taps[abs(m)];
            if (m < 0 && line->antisymmetric)
                tap = -tap;
            sum += tap * in[start + stride * support_extended(s, (long)x - m, n[axis])];
        }
        out[i] = sum;
    }
}

void support_filter(double *samples, const support_shape *s, const cvol_kernel *kernel)
{
    const size_t count = s->dims[0] * s->dims[1] * s->dims[2];
    double *work = allocate(3 * count), *sum = work + 2 * count;
    memset(sum, 0, count * sizeof *sum);
    for (int p = 0; p < kernel->parts; p++) {
        memcpy(work, samples, count * sizeof *work);
        for (int axis = 0; axis < s->rank; axis++) {
            filter_axis(work + count, work, s, &kernel->line[p][axis], axis);
            memcpy(work, work + count, count * sizeof *work);
        }
        for (size_t i = 0; i < count; i++)
            sum[i] += kernel->weight[p] * work[i];
    }
    memcpy(samples, sum, count * sizeof *sum);
    free(work);
}

void support_gradient(double *samples, const support_shape *s, const double spacing[3])
{
    const size_t count = s->dims[0] * s->dims[1] * s->dims[2];
    double *work = allocate(2 * count), *sum = work + count;
    memset(sum, 0, count * sizeof *sum);
    const cvol_kernel_line line = {.radius = 1, .antisymmetric = 1, .taps = {0, -0.5}};
    for (int axis = 0; axis < s->rank; axis++) {
        filter_axis(work, samples, s, &line, axis);
        for (size_t i = 0; i < count; i++)
            sum[i] += work[i] * work[i] / spacing[axis] / spacing[axis];
    }
    for (size_t i = 0; i < count; i++)
        samples[i] = sqrt(sum[i]);
    free(work);
}

void support_convolve(double *a, const double *b, const support_shape *s)
{
    const size_t *n = s->dims, count = n[0] * n[1] * n[2];
    double *out = allocate(count);
    for (size_t i = 0; i < count; i++)
        for (size_t j = 0; j < count; j++) {
            size_t to = (i % n[0] + j % n[0]) % n[0] +
                        n[0] * ((i / n[0] % n[1] + j / n[0] % n[1]) % n[1] +
                                n[1] * ((i / n[0] / n[1] + j / n[0] / n[1]) % n[2]));
            out[to] += a[i] * b[j];
        }
    memcpy(a, out, count * sizeof *out);
    free(out);
}

/* Linear interpolation, or means of two, along one axis (blocks). */
static void resample_axis(double *out, const double *in, size_t stride, size_t n, size_t n_new)
{
    for (size_t x = 0; x < n_new; x++)
        for (size_t i = 0; i < stride; i++) {
            const size_t near = n_new > n ? x / 2 : 2 * x;
            size_t far = n_new > n && x % 2 == 0 ? (near ? near - 1 : 0) : near + 1;
            far = far < n ? far : n - 1;
            const double w = n_new > n ? 0.75 : 0.5;
            out[x * stride + i] = w * in[near * stride + i] + (1 - w) * in[far * stride + i];
        }
}

double *support_resample(const double *samples, support_shape *s, int factor)
{
    size_t *n = s->dims;
    double *from = allocate(n[0] * n[1] * n[2]);
    memcpy(from, samples, n[0] * n[1] * n[2] * sizeof *from);
    for (int axis = 0; axis < s->rank; axis++) {
        const size_t stride = axis == 0 ? 1 : axis == 1 ? n[0] : n[0] * n[1];
        const size_t old = n[axis], outer = n[0] * n[1] * n[2] / (stride * old);
        n[axis] = factor == 2 ? 2 * old : (old + 1) / 2;
        if (factor != 2 && old == 1)
            continue;
        double *to = allocate(n[0] * n[1] * n[2]);
        for (size_t o = 0; o < outer; o++)
            resample_axis(to + o * stride * n[axis], from + o * stride * old, stride, old, n[axis]);
        free(from);
        from = to;
    }
    return from;
}
