/* A small filter on a whole array: one factor per term.
 *
 * Under DFT and DHT the array is periodic, and F[u] becomes F[u] H(2 pi u / n), with H the product
 * over the axes and the sum over the parts; an antisymmetric line has H = i times a real number.
 * Under DCT the array is mirrored about its ends: one half of a period of 2 n samples, whose
 * frequencies are pi u / n. A symmetric line multiplies A[u] by H(pi u / n). An antisymmetric line
 * with H = i g turns cos(pi u (x + 1/2) / n) into -g(pi u / n) sin(pi u (x + 1/2) / n), another
 * basis (the DST's): its samples along that axis are computed and transformed again.
 *
 * A kernel wider than the array's axis needs no special case: responses are exact for any periodic
 * extension. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/convolve/convolve.h"
#include "array/convolve/kernel.h"
#include "array/truncate/account.h"
#include "array/truncate/candidates.h"
#include "array/truncate/producer.h"
#include "array/truncate/spectrum_map.h"
#include "array/truncate/truncate.h"
#include "base/complex.h"
#include "base/context.h"
#include "base/memory.h"
#include "transform/fft.h"

static const double PI = 3.14159265358979323846;

/* Axes up to this length have tables of responses for any number of terms. */
#define SHORT_AXIS 65536

typedef struct filter {
    const cvol_kernel *kernel;
    const cvol_spectrum *from;
    cvol_transform transform;
    size_t dims[3];
    int odd_lines[CVOL_KERNEL_PARTS];    /* the number of antisymmetric lines of a part */
    double *table[CVOL_KERNEL_PARTS][3]; /* responses by index, or NULL */
} filter;

static double omega_of(const filter *f, int axis, size_t u)
{
    const double turns = (double)u / (double)f->dims[axis];
    return f->transform == CVOL_DCT ? PI * turns : 2 * PI * turns;
}

/* The line's H, without the i of an antisymmetric one. */
static double response(const filter *f, int part, int axis, size_t u)
{
    if (f->table[part][axis])
        return f->table[part][axis][u];
    return cvol_kernel_response(&f->kernel->line[part][axis], omega_of(f, axis, u));
}

/* The part's H, without its powers of i. */
static double part_response(const filter *f, int part, const size_t place[3])
{
    return f->kernel->weight[part] * response(f, part, 0, place[0]) *
           response(f, part, 1, place[1]) * response(f, part, 2, place[2]);
}

/* The sum of the parts with an even (odd 0) or odd number of antisymmetric lines: Re H, Im H. */
static double sum_of(const filter *f, int odd, const size_t place[3])
{
    double sum = 0;
    for (int t = 0; t < f->kernel->parts; t++)
        if (f->odd_lines[t] % 2 == odd) /* i^0 = 1, i^1 = i, i^2 = -1, i^3 = -i */
            sum += f->odd_lines[t] < 2 ? part_response(f, t, place) : -part_response(f, t, place);
    return sum;
}

static double real_term(const void *user, const size_t place[3])
{
    const filter *f = user;
    return sum_of(f, 0, place) * (double)cvol_spectrum_value(f->from, f->dims, place);
}

static double complex_term(const void *user, const size_t place[3])
{
    const filter *f = user;
    const double complex F = cvol_spectrum_coefficient(f->from, f->transform, f->dims, place);
    const double re = sum_of(f, 0, place), im = sum_of(f, 1, place);
    return cvol_slot_of(f->transform, f->dims, place,
                        cvol_complex(re * creal(F) - im * cimag(F), re * cimag(F) + im * creal(F)));
}

static void close_filter(filter *f)
{
    for (int t = 0; t < CVOL_KERNEL_PARTS; t++)
        for (int a = 0; a < 3; a++)
            free(f->table[t][a]);
}

/* On failure there is nothing to close. */
static int open_filter(cvol_context *context, filter *f, const cvol_array *a,
                       const cvol_kernel *kernel)
{
    memset(f, 0, sizeof *f);
    f->kernel = kernel;
    f->from = &a->whole;
    f->transform = a->transform;
    memcpy(f->dims, a->grid.dims, sizeof f->dims);
    const size_t terms = a->whole.low_count + a->whole.sparse_count;
    for (int t = 0; t < kernel->parts; t++)
        for (int axis = 0; axis < 3; axis++) {
            const size_t n = f->dims[axis];
            f->odd_lines[t] += kernel->line[t][axis].antisymmetric != 0;
            if (n > SHORT_AXIS && n > terms)
                continue;
            double *table = cvol_allocate(n, sizeof *table);
            if (!table) {
                close_filter(f);
                return cvol_fail_memory(context, n * sizeof *table, "a filter's responses");
            }
            for (size_t u = 0; u < n; u++)
                table[u] = cvol_kernel_response(&kernel->line[t][axis], omega_of(f, axis, u));
            f->table[t][axis] = table;
        }
    return CVOL_OK;
}

/* ---- antisymmetric lines under DCT ----------------------------------------------------------- */

/* Converts sine coefficients along one axis (frequency u at index u) to cosine ones. */
static int sines_to_cosines(cvol_context *context, float *slots, const size_t dims[3], int axis)
{
    const size_t n = dims[axis];
    const size_t stride = axis == 0 ? 1 : axis == 1 ? dims[0] : dims[0] * dims[1];
    const size_t outer = dims[0] * dims[1] * dims[2] / (stride * n); /* runs of n stride elements */
    const double c = sqrt(2 / (double)n), c0 = sqrt(1 / (double)n);
    int code = CVOL_OK;
    for (size_t l = 0; l < outer && !code; l++) {
        /* the DST's frequencies begin at 1: one index down */
        float *run = slots + l * stride * n;
        memmove(run, run + stride, (n - 1) * stride * sizeof *run);
        memset(run + (n - 1) * stride, 0, stride * sizeof *run);
        const cvol_fft_lines lines = {.n = n,
                                      .count = stride,
                                      .in_stride = stride,
                                      .in_distance = 1,
                                      .out_stride = stride,
                                      .out_distance = 1};
        code = cvol_fft_along(context, CVOL_FFT_IDST, &lines, run, run);
        if (!code)
            code = cvol_fft_along(context, CVOL_FFT_DCT, &lines, run, run);
        for (size_t i = 0; i < n * stride && !code; i++)
            run[i] *= (float)(c * (i < stride ? c0 : c) / 4);
    }
    return code;
}

static int convolve_dense(cvol_context *context, cvol_array *out, cvol_build_result *result,
                          const filter *f, const cvol_keep *keep)
{
    const size_t *dims = f->dims, N = dims[0] * dims[1] * dims[2];
    float *part = cvol_fft_allocate(N), *sum = cvol_allocate_zero(N, sizeof *sum);
    int code = CVOL_OK;
    double norm = 0; /* norm of the sums; rounding is a share of it */
    if (!part || !sum) {
        code = cvol_fail_memory(context, 2 * N * sizeof *part, "all samples of a filtered array");
        goto done;
    }
    for (int t = 0; t < f->kernel->parts && !code; t++) {
        code = cvol_report_progress(context, "filtering", (double)t / f->kernel->parts);
        if (code)
            break;
        cvol_spectrum_scatter(part, f->from, dims);
        const double sign = f->odd_lines[t] % 2 ? -1 : 1; /* -g per line */
        double energy = 0;
        for (size_t i = 0; i < N; i++) {
            if (part[i] == 0)
                continue;
            size_t place[3];
            cvol_place_split(place, i, dims);
            part[i] = (float)(sign * part_response(f, t, place) * (double)part[i]);
            energy += (double)part[i] * (double)part[i];
        }
        norm += sqrt(energy);
        for (int a = 0; a < 3 && !code; a++)
            if (f->kernel->line[t][a].antisymmetric)
                code = sines_to_cosines(context, part, dims, a);
        for (size_t i = 0; i < N; i++)
            sum[i] += part[i];
    }
    if (code)
        goto done;
    cvol_keep rule = *keep;
    if (rule.rule == CVOL_KEEP_LIKE_INPUTS) {
        rule = cvol_keep_terms(0, f->from->sparse_count);
        memcpy(rule.low, f->from->low, sizeof rule.low);
    }
    const cvol_candidates candidates = {
        .slots = sum, .low = {dims[0], dims[1], dims[2]}, .box = {dims[0], dims[1], dims[2]}};
    *result = (cvol_build_result){.norm = norm, .max_abs = -1};
    code = cvol_truncate(context, out, &result->dropped, &candidates, &rule);
done:
    free(part);
    free(sum);
    return code;
}

int cvol_whole_convolve_kernel(cvol_context *context, cvol_array *out, cvol_build_result *result,
                               const cvol_array *a, const cvol_kernel *kernel,
                               const cvol_keep *keep)
{
    filter f;
    int any = 0, odd = 0; /* antisymmetric lines; parts with an odd number of them */
    int code = open_filter(context, &f, a, kernel);
    if (code)
        return code;
    for (int t = 0; t < kernel->parts; t++) {
        any |= f.odd_lines[t];
        odd |= f.odd_lines[t] % 2;
    }
    if (a->transform == CVOL_DCT && any) {
        code = convolve_dense(context, out, result, &f, keep);
    } else {
        cvol_spectrum terms;
        code = cvol_spectrum_start_like(context, &terms, a->transform, f.dims, &a->whole, odd);
        if (!code) {
            cvol_spectrum_fill(context, &terms, f.dims, odd ? complex_term : real_term, &f);
            code = cvol_spectrum_move(context, out, result, &terms, keep);
            cvol_spectrum_free(&terms);
        }
    }
    close_filter(&f);
    return code;
}
