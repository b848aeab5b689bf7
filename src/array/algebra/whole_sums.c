/* Sums over the samples of whole arrays, from their terms.
 *
 * The basis is orthonormal (Parseval), and its function of place 0 is N^-1/2 everywhere:
 *     sum a = sqrt(N) A[0],   sum a^2 = sum A^2,   sum a b = sum A B,
 *     sum (a - b)^2 = sum (A - B)^2
 * Sparse terms are matched by walking through both lists. Each step depends on the one before, so
 * four sections of the lists are walked in parallel. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/algebra/operations.h"
#include "array/truncate/account.h"
#include "array/truncate/producer.h"
#include "base/context.h"

static double mean_term(const cvol_spectrum *s)
{
    if (s->low_count)
        return (double)s->low_values[0];
    return s->sparse_count && s->places[0] == 0 ? (double)s->values[0] : 0;
}

int cvol_whole_sums(cvol_context *context, double *sum, double *squares, const cvol_array *a)
{
    (void)context;
    *sum = sqrt((double)cvol_grid_samples(&a->grid)) * mean_term(&a->whole);
    *squares = cvol_spectrum_energy(&a->whole);
    return CVOL_OK;
}

double cvol_whole_variation(const cvol_array *a)
{
    const cvol_spectrum *s = &a->whole;
    const size_t low = s->low_count ? 1 : 0, sparse = !low && s->sparse_count && s->places[0] == 0;
    return cvol_sum_squares(s->low_values + low, s->low_count - low) +
           cvol_sum_squares(s->values + sparse, s->sparse_count - sparse);
}

/* ---- sums over two arrays ------------------------------------------------------------------- */

/* Sums of products, and of squared differences. */
typedef struct pair_sums {
    double inner, distance;
} pair_sums;

enum { PARALLEL_MERGES = 4, LANES = 8 };

static pair_sums sum_low(const float *a, const float *b, size_t count)
{
    double inner[LANES] = {0}, distance[LANES] = {0};
    pair_sums sums = {0};
    size_t i = 0;
    for (; i + LANES <= count; i += LANES)
        for (size_t l = 0; l < LANES; l++) {
            const double x = (double)a[i + l], y = (double)b[i + l];
            inner[l] += x * y;
            distance[l] += (x - y) * (x - y);
        }
    for (; i < count; i++) {
        const double x = (double)a[i], y = (double)b[i];
        inner[0] += x * y;
        distance[0] += (x - y) * (x - y);
    }
    for (size_t l = 0; l < LANES; l++) {
        sums.inner += inner[l];
        sums.distance += distance[l];
    }
    return sums;
}

/* Positions and ends of the two walks of a section. */
typedef struct merge {
    size_t i, i_end, j, j_end;
} merge;

/* One step: takes the term at the lower place, from both lists if they share it. It has no branch:
 * the processor cannot predict which list is lower. */
static inline void take_step(merge *s, pair_sums *sums, const cvol_spectrum *a,
                             const cvol_spectrum *b)
{
    const uint32_t p = a->places[s->i], q = b->places[s->j];
    const int from_a = p <= q, from_b = q <= p;
    const double x = (double)a->values[s->i] * from_a, y = (double)b->values[s->j] * from_b;
    sums->inner += x * y;
    sums->distance += (x - y) * (x - y);
    s->i += (size_t)from_a;
    s->j += (size_t)from_b;
}

static size_t find_place(const cvol_spectrum *s, uint32_t place)
{
    size_t begin = 0, end = s->sparse_count;
    while (begin < end) {
        const size_t middle = begin + (end - begin) / 2;
        if (s->places[middle] < place)
            begin = middle + 1;
        else
            end = middle;
    }
    return begin;
}

static pair_sums sum_sparse(const cvol_spectrum *a, const cvol_spectrum *b)
{
    merge s[PARALLEL_MERGES];
    pair_sums sums[PARALLEL_MERGES] = {{0}}, out = {0};
    for (size_t k = 0; k < PARALLEL_MERGES; k++) {
        s[k].i = a->sparse_count / PARALLEL_MERGES * k;
        s[k].j = k && a->sparse_count ? find_place(b, a->places[s[k].i]) : 0;
    }
    for (size_t k = 0; k < PARALLEL_MERGES; k++) {
        s[k].i_end = k + 1 < PARALLEL_MERGES ? s[k + 1].i : a->sparse_count;
        s[k].j_end = k + 1 < PARALLEL_MERGES ? s[k + 1].j : b->sparse_count;
    }
    while (s[0].i < s[0].i_end && s[0].j < s[0].j_end && s[1].i < s[1].i_end &&
           s[1].j < s[1].j_end && s[2].i < s[2].i_end && s[2].j < s[2].j_end &&
           s[3].i < s[3].i_end && s[3].j < s[3].j_end) {
        take_step(&s[0], &sums[0], a, b);
        take_step(&s[1], &sums[1], a, b);
        take_step(&s[2], &sums[2], a, b);
        take_step(&s[3], &sums[3], a, b);
    }
    for (size_t k = 0; k < PARALLEL_MERGES; k++) {
        while (s[k].i < s[k].i_end && s[k].j < s[k].j_end)
            take_step(&s[k], &sums[k], a, b);
        out.inner += sums[k].inner;
        out.distance += sums[k].distance +
                        cvol_sum_squares(a->values + s[k].i, s[k].i_end - s[k].i) +
                        cvol_sum_squares(b->values + s[k].j, s[k].j_end - s[k].j);
    }
    return out;
}

/* Sparse terms of b that lie in the low box of a. */
static double sum_mixed(const cvol_spectrum *a, const cvol_spectrum *b, const size_t dims[3])
{
    const uint32_t nx = (uint32_t)dims[0], ny = (uint32_t)dims[1];
    double sum = 0;
    for (size_t n = 0; n < b->sparse_count && a->low_count; n++) {
        const uint32_t row = b->places[n] / nx;
        const size_t i = cvol_box_index(b->places[n] % nx, a->low[0], a->box[0], dims[0]);
        const size_t j = cvol_box_index(row % ny, a->low[1], a->box[1], dims[1]);
        const size_t l = cvol_box_index(row / ny, a->low[2], a->box[2], dims[2]);
        if (i != SIZE_MAX && j != SIZE_MAX && l != SIZE_MAX)
            sum += (double)a->low_values[i + a->box[0] * (j + a->box[1] * l)] *
                   (double)b->values[n];
    }
    return sum;
}

/* The common part of two low boxes, through the rows of a's box. */
static double sum_boxes(const cvol_spectrum *a, const cvol_spectrum *b, const size_t dims[3])
{
    const size_t rows = a->low_count && b->low_count ? a->box[1] * a->box[2] : 0;
    double sum = 0;
    for (size_t row = 0; row < rows; row++) {
        const size_t v = cvol_box_place(row % a->box[1], a->low[1], a->box[1], dims[1]);
        const size_t w = cvol_box_place(row / a->box[1], a->low[2], a->box[2], dims[2]);
        const size_t j = cvol_box_index(v, b->low[1], b->box[1], dims[1]);
        const size_t l = cvol_box_index(w, b->low[2], b->box[2], dims[2]);
        if (j == SIZE_MAX || l == SIZE_MAX)
            continue;
        const float *x = a->low_values + row * a->box[0];
        const float *y = b->low_values + b->box[0] * (j + b->box[1] * l);
        for (size_t u = 0; u < a->box[0]; u++) {
            const size_t place = cvol_box_place(u, a->low[0], a->box[0], dims[0]);
            const size_t i = cvol_box_index(place, b->low[0], b->box[0], dims[0]);
            if (i != SIZE_MAX)
                sum += (double)x[u] * (double)y[i];
        }
    }
    return sum;
}

static int same_box(const cvol_spectrum *a, const cvol_spectrum *b)
{
    return !memcmp(a->box, b->box, sizeof a->box);
}

static pair_sums sum_same(const cvol_spectrum *a, const cvol_spectrum *b)
{
    pair_sums low = sum_low(a->low_values, b->low_values, a->low_count), rest = sum_sparse(a, b);
    return (pair_sums){low.inner + rest.inner, low.distance + rest.distance};
}

int cvol_whole_inner(cvol_context *context, double *inner, const cvol_array *a, const cvol_array *b)
{
    const cvol_spectrum *x = &a->whole, *y = &b->whole;
    const size_t *dims = a->grid.dims;
    (void)context;
    *inner = same_box(x, y) ? sum_same(x, y).inner
                            : sum_boxes(x, y, dims) + sum_mixed(x, y, dims) +
                                  sum_mixed(y, x, dims) + sum_sparse(x, y).inner;
    return CVOL_OK;
}

int cvol_whole_compare(cvol_context *context, double *inner, double *distance, const cvol_array *a,
                       const cvol_array *b)
{
    cvol_array *difference;
    cvol_build_result result;
    if (same_box(&a->whole, &b->whole)) {
        const pair_sums sums = sum_same(&a->whole, &b->whole);
        *inner = sums.inner;
        *distance = sqrt(sums.distance);
        return CVOL_OK;
    }
    int code = cvol_whole_inner(context, inner, a, b);
    if (!code)
        code = cvol_array_create_like(context, &difference, a);
    if (code)
        return code;
    const cvol_keep keep = cvol_keep_like_inputs();
    code = cvol_whole_add(context, difference, &result, 1, a, -1, b, &keep);
    if (!code)
        *distance = sqrt(cvol_spectrum_energy(&difference->whole));
    cvol_array_free(difference);
    return code;
}
