/* From values at chirp points to terms at known places, rank 1: least squares by conjugate
 * gradients on the normal equations (Hestenes and Stiefel 1952).
 *
 * The matrix A holds each slot's function at the points. A small matrix is stored, in double
 * precision; a large one is applied by the chirp transform and its adjoint over the hull of the
 * places. First the condition is checked: conjugate gradients solve A^T A z = g for random signs g,
 * and |z| / |g| times the largest eigenvalue estimates the square of the condition number. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/evaluate/interpolant.h"
#include "array/evaluate/interpolated.h"
#include "base/context.h"
#include "base/memory.h"
#include "transform/chirp.h"
#include "transform/fft.h"

#define MAX_STORED ((size_t)1 << 22)
#define MAX_CONDITION 1e6 /* single precision then leaves less than one digit */

typedef struct fit {
    cvol_context *context;
    cvol_transform transform;
    size_t n, count, terms;
    const uint32_t *places; /* rising */
    double *matrix;         /* columns of `count`; NULL: by chirps */
    cvol_chirp *forward, *adjoint;
    size_t extent, frequencies;
    float *spectrum, *points, *work; /* pairs */
} fit;

/* ---- the matrix ------------------------------------------------------------------------------ */

static int prepare_chirps(fit *of, double start, double step)
{
    const int real = of->transform == CVOL_DCT;
    for (size_t t = 0; t < of->terms; t++) {
        const size_t u = real ? of->places[t] : cvol_frequency(of->places[t], of->n);
        of->extent = u > of->extent ? u : of->extent;
    }
    of->frequencies = real ? of->extent + 1 : 2 * of->extent + 1;
    const cvol_chirp_shape shape = {.first = real ? 0 : -(int64_t)of->extent,
                                    .frequencies = of->frequencies,
                                    .start = real ? start + 0.5 : start,
                                    .step = step,
                                    .points = of->count,
                                    .n = (double)of->n * (real ? 2 : 1)};
    int code = cvol_chirp_create(of->context, &of->forward, &shape, 0);
    if (!code)
        code = cvol_chirp_create(of->context, &of->adjoint, &shape, 1);
    if (code)
        return code;
    of->spectrum = cvol_fft_allocate(2 * of->frequencies);
    of->points = cvol_fft_allocate(2 * of->count);
    of->work = cvol_fft_allocate(cvol_chirp_work(of->forward));
    if (of->spectrum && of->points && of->work)
        return CVOL_OK;
    return cvol_fail_memory(of->context, 2 * (of->frequencies + of->count) * sizeof(float),
                            "chirp transforms");
}

static int prepare(fit *of, double start, double step)
{
    size_t elements;
    if (!cvol_size_multiply(&elements, of->count, of->terms) || elements > MAX_STORED)
        return prepare_chirps(of, start, step);
    of->matrix = cvol_allocate(elements, sizeof *of->matrix);
    if (!of->matrix)
        return cvol_fail_memory(of->context, elements * sizeof *of->matrix, "the equations");
    for (size_t t = 0; t < of->terms; t++)
        cvol_interpolated_column(of->matrix + of->count * t, of->transform, of->n, of->places[t],
                                 start, step, of->count);
    return CVOL_OK;
}

static void release(fit *of)
{
    free(of->matrix);
    cvol_chirp_free(of->forward);
    cvol_chirp_free(of->adjoint);
    free(of->spectrum);
    free(of->points);
    free(of->work);
}

/* Indices of a term in the hull (two only for n / 2), and its g. */
static int find_term(const fit *of, size_t t, size_t index[2], double g[2])
{
    const size_t u = of->places[t], dims[3] = {of->n, 1, 1}, place[3] = {u, 0, 0};
    cvol_slot_factor(g, of->transform, place, dims);
    if (of->transform == CVOL_DCT) {
        index[0] = u;
        return 1;
    }
    const size_t size = cvol_frequency(u, of->n);
    index[0] = 2 * u <= of->n ? of->extent + size : of->extent - size;
    index[1] = of->extent - size;
    return u && 2 * u == of->n ? 2 : 1;
}

/* y = A x */
static int apply(fit *of, double *y, const double *x)
{
    if (of->matrix) {
        memset(y, 0, of->count * sizeof *y);
        for (size_t t = 0; t < of->terms; t++)
            for (size_t j = 0; j < of->count; j++)
                y[j] += x[t] * of->matrix[of->count * t + j];
        return CVOL_OK;
    }
    memset(of->spectrum, 0, 2 * of->frequencies * sizeof *of->spectrum);
    for (size_t t = 0; t < of->terms; t++) {
        size_t index[2];
        double g[2];
        const int ends = find_term(of, t, index, g);
        for (int e = 0; e < ends; e++) {
            of->spectrum[2 * index[e]] += (float)(x[t] * g[0] / ends);
            of->spectrum[2 * index[e] + 1] += (float)(x[t] * g[1] / ends);
        }
    }
    int code = cvol_chirp_apply(of->context, of->forward, of->points, 1, of->spectrum, 1, of->work);
    for (size_t j = 0; j < of->count; j++)
        y[j] = (double)of->points[2 * j];
    return code;
}

/* x = A^T y */
static int apply_adjoint(fit *of, double *x, const double *y)
{
    if (of->matrix) {
        for (size_t t = 0; t < of->terms; t++) {
            x[t] = 0;
            for (size_t j = 0; j < of->count; j++)
                x[t] += of->matrix[of->count * t + j] * y[j];
        }
        return CVOL_OK;
    }
    for (size_t j = 0; j < of->count; j++) {
        of->points[2 * j] = (float)y[j];
        of->points[2 * j + 1] = 0;
    }
    int code = cvol_chirp_apply(of->context, of->adjoint, of->spectrum, 1, of->points, 1, of->work);
    for (size_t t = 0; t < of->terms; t++) {
        size_t index[2];
        double g[2];
        const int ends = find_term(of, t, index, g);
        x[t] = 0;
        for (int e = 0; e < ends; e++)
            x[t] += (g[0] * (double)of->spectrum[2 * index[e]] +
                     g[1] * (double)of->spectrum[2 * index[e] + 1]) /
                    ends;
    }
    return code;
}

/* ---- conjugate gradients ------------------------------------------------------------------- */

static double dot(const double *a, const double *b, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += a[i] * b[i];
    return sum;
}

typedef struct gradients {
    double *x, *p; /* terms: the solution, the direction */
    double *s;     /* 2 terms: the residual of the normal equations, and its change */
    double *r, *q; /* count: the values, A p */
} gradients;

/* Solves A^T A x = s from x = 0 until the residual |s| has shrunk by `tolerance`. *done: 1 if it
 * has; *largest: the largest Rayleigh quotient found. */
static int solve(fit *of, gradients *v, double tolerance, int *done, double *largest)
{
    const size_t terms = of->terms, most = 10 * terms + 100;
    const double goal = dot(v->s, v->s, terms) * tolerance * tolerance;
    double gamma = dot(v->s, v->s, terms);
    memset(v->x, 0, terms * sizeof *v->x);
    memcpy(v->p, v->s, terms * sizeof *v->p);
    *largest = 0;
    *done = gamma <= 0;
    for (size_t i = 0; i < most && !*done; i++) {
        int code = apply(of, v->q, v->p);
        if (code)
            return code;
        const double curvature = dot(v->q, v->q, of->count);
        if (!(curvature > 0))
            return CVOL_OK;
        const double alpha = gamma / curvature;
        *largest = fmax(*largest, curvature / dot(v->p, v->p, terms));
        for (size_t t = 0; t < terms; t++)
            v->x[t] += alpha * v->p[t];
        for (size_t j = 0; j < of->count; j++)
            v->q[j] *= alpha;
        double *change = v->s + terms;
        code = apply_adjoint(of, change, v->q);
        if (code)
            return code;
        for (size_t t = 0; t < terms; t++)
            v->s[t] -= change[t];
        const double next = dot(v->s, v->s, terms);
        *done = next <= goal;
        for (size_t t = 0; t < terms; t++)
            v->p[t] = v->s[t] + next / gamma * v->p[t];
        gamma = next;
        if (i % 64 == 63) {
            code = cvol_report_progress(of->context, "interpolating", (double)i / (double)most);
            if (code)
                return code;
        }
    }
    return CVOL_OK;
}

/* TARGET if the condition number, estimated by random signs, is too large. */
static int check_condition(fit *of, gradients *v)
{
    uint64_t bits = UINT64_C(0x9E3779B97F4A7C15);
    for (size_t t = 0; t < of->terms; t++) {
        bits ^= bits << 13; /* xorshift64 (Marsaglia 2003) */
        bits ^= bits >> 7;
        bits ^= bits << 17;
        v->s[t] = bits >> 63 ? 1 : -1;
    }
    int done;
    double largest;
    const double share = 0.1 / sqrt((double)of->terms);
    int code = solve(of, v, share, &done, &largest);
    if (code)
        return code;
    const double stretch = sqrt(dot(v->x, v->x, of->terms) / (double)of->terms);
    if (done && largest * stretch <= MAX_CONDITION * MAX_CONDITION)
        return CVOL_OK;
    return cvol_fail(of->context, CVOL_ERROR_TARGET,
                     "%zu points do not determine %zu terms: the condition is beyond single "
                     "precision; take points that span the period, or fewer terms",
                     of->count, of->terms);
}

/* Least squares; *residual is |values - A x|. */
static int fit_values(fit *of, gradients *v, const float *values, double *residual)
{
    int done;
    double largest;
    int code = check_condition(of, v);
    if (code)
        return code;
    for (size_t j = 0; j < of->count; j++)
        v->r[j] = (double)values[j];
    code = apply_adjoint(of, v->s, v->r);
    if (!code)
        code = solve(of, v, of->matrix ? 1e-13 : 1e-7, &done, &largest);
    if (!code)
        code = apply(of, v->q, v->x);
    if (code)
        return code;
    double sum = 0;
    for (size_t j = 0; j < of->count; j++)
        sum += ((double)values[j] - v->q[j]) * ((double)values[j] - v->q[j]);
    *residual = sqrt(sum);
    return CVOL_OK;
}

/* ---- the call ------------------------------------------------------------------------------- */

static int compare_places(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static int check_places(cvol_context *context, const uint32_t *sorted, size_t terms, size_t n,
                        cvol_transform transform)
{
    for (size_t t = 0; t < terms; t++) {
        if (sorted[t] >= n)
            return cvol_fail(context, CVOL_ERROR_ARGUMENT, "place %u, must be below %zu", sorted[t],
                             n);
        if (t && sorted[t] == sorted[t - 1])
            return cvol_fail(context, CVOL_ERROR_ARGUMENT, "place %u is named twice", sorted[t]);
        const uint32_t mirror = (uint32_t)cvol_mirror_index(sorted[t], n);
        if (transform == CVOL_DFT &&
            !bsearch(&mirror, sorted, terms, sizeof *sorted, compare_places))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "place %u without place %u, the other one of its pair", sorted[t],
                             mirror);
    }
    return CVOL_OK;
}

int cvol_array_interpolate_chirp(cvol_context *context, cvol_array **out, double *residual,
                                 const float *values, size_t count, double start, double step,
                                 const uint32_t *places, size_t terms, const cvol_grid *grid,
                                 cvol_transform transform)
{
    cvol_array *array;
    double off = 0;
    *out = NULL;
    int code = cvol_array_create_as(context, &array, grid, 1, transform, 0);
    if (code)
        return code;
    if (!terms || count < terms || !isfinite(start) || !isfinite(step)) {
        cvol_array_free(array);
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%zu terms from %zu values at %g + i %g; there must be a term, as many "
                         "values, and finite points",
                         terms, count, start, step);
    }
    uint32_t *sorted = cvol_allocate(terms, sizeof *sorted);
    double *numbers = cvol_allocate(4 * terms + 2 * count, sizeof *numbers);
    fit of = {.context = context,
              .transform = transform,
              .n = grid->dims[0],
              .count = count,
              .terms = terms,
              .places = sorted};
    if (!sorted || !numbers) {
        code = cvol_fail_memory(context, (4 * terms + 2 * count) * sizeof *numbers, "the fit");
        goto done;
    }
    memcpy(sorted, places, terms * sizeof *sorted);
    qsort(sorted, terms, sizeof *sorted, compare_places);
    gradients v = {.x = numbers, .p = numbers + terms, .s = numbers + 2 * terms};
    v.r = numbers + 4 * terms;
    v.q = v.r + count;
    code = check_places(context, sorted, terms, of.n, transform);
    if (!code)
        code = cvol_interpolated_check_values(context, values, count);
    if (!code)
        code = prepare(&of, start, step);
    if (!code)
        code = fit_values(&of, &v, values, &off);
    if (!code)
        code = cvol_interpolated_set(context, array, sorted, v.x, terms);
    if (!code)
        code = cvol_interpolated_finish(context, array, 0);
done:
    release(&of);
    free(sorted);
    free(numbers);
    if (code) {
        cvol_array_free(array);
        return code;
    }
    if (residual)
        *residual = off;
    *out = array;
    return CVOL_OK;
}
