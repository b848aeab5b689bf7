/* Linear operations on the terms of whole arrays: alpha a + beta b, alpha a + beta, truncation.
 *
 * The transforms are linear and orthonormal; the constant 1 is sqrt(N) in the slot of place 0. A
 * sum has the larger low box along each axis, and the union of the sparse terms outside of it.
 * Every product and sum is rounded once. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/algebra/operations.h"
#include "array/truncate/account.h"
#include "array/truncate/candidates.h"
#include "array/truncate/producer.h"
#include "array/truncate/truncate.h"
#include "base/context.h"
#include "base/memory.h"

/* ---- sums ----------------------------------------------------------------------------------- */

/* Sparse terms times a factor. */
typedef struct term_list {
    const uint32_t *places;
    const float *values;
    size_t count;
    double factor;
} term_list;

static size_t copy_terms(uint32_t *places, float *values, const term_list *from, size_t first)
{
    const size_t count = from->count - first;
    for (size_t i = 0; i < count; i++) {
        places[i] = from->places[first + i];
        values[i] = (float)(from->factor * (double)from->values[first + i]);
    }
    return count;
}

/* Merges two lists and returns the number of terms. It has no branches that could be mispredicted:
 * each step takes the term at the lower place, from both lists if they share it. */
static size_t merge_terms(uint32_t *places, float *values, const term_list *a, const term_list *b)
{
    const double alpha[2] = {0, a->factor}, beta[2] = {0, b->factor};
    size_t i = 0, j = 0, count = 0;
    while (i < a->count && j < b->count) {
        const uint32_t p = a->places[i], q = b->places[j];
        const double x = alpha[p <= q], y = beta[q <= p];
        places[count] = p < q ? p : q;
        values[count++] = (float)(x * (double)a->values[i] + y * (double)b->values[j]);
        i += p <= q;
        j += q <= p;
    }
    count += copy_terms(places + count, values + count, a, i);
    count += copy_terms(places + count, values + count, b, j);
    return count;
}

static float *low_slot(const cvol_spectrum *s, const size_t dims[3], uint32_t place)
{
    const uint32_t nx = (uint32_t)dims[0], ny = (uint32_t)dims[1], row = place / nx;
    const size_t i = cvol_box_index(place % nx, s->low[0], s->box[0], dims[0]);
    const size_t j = cvol_box_index(row % ny, s->low[1], s->box[1], dims[1]);
    const size_t l = cvol_box_index(row / ny, s->low[2], s->box[2], dims[2]);
    if (!s->low_count || i == SIZE_MAX || j == SIZE_MAX || l == SIZE_MAX)
        return NULL;
    return s->low_values + i + s->box[0] * (j + s->box[1] * l);
}

/* Adds a low box to the low box of `out`, which contains it. */
static void add_low(cvol_spectrum *out, double factor, const cvol_spectrum *s, const size_t dims[3])
{
    const size_t rows = s->low_count ? s->box[1] * s->box[2] : 0;
    for (size_t row = 0; row < rows; row++) {
        const size_t v = cvol_box_place(row % s->box[1], s->low[1], s->box[1], dims[1]);
        const size_t w = cvol_box_place(row / s->box[1], s->low[2], s->box[2], dims[2]);
        const size_t j = cvol_box_index(v, out->low[1], out->box[1], dims[1]);
        const size_t l = cvol_box_index(w, out->low[2], out->box[2], dims[2]);
        float *to = out->low_values + out->box[0] * (j + out->box[1] * l);
        const float *from = s->low_values + row * s->box[0];
        for (size_t u = 0; u < s->box[0]; u++) {
            const size_t place = cvol_box_place(u, s->low[0], s->box[0], dims[0]);
            const size_t i = cvol_box_index(place, out->low[0], out->box[0], dims[0]);
            to[i] = (float)((double)to[i] + factor * (double)from[u]);
        }
    }
}

/* Adds the sparse terms within the box of `out` to it. The others become *rest, in separate
 * memory. */
static int divide_terms(cvol_context *context, term_list *rest, cvol_spectrum *out, double factor,
                        const cvol_spectrum *s, const size_t dims[3])
{
    uint32_t *places = cvol_allocate(s->sparse_count, sizeof *places);
    float *values = cvol_allocate(s->sparse_count, sizeof *values);
    *rest = (term_list){.places = places, .values = values, .factor = factor};
    if (!places || !values)
        return cvol_fail_memory(context, s->sparse_count * (sizeof *places + sizeof *values),
                                "sparse terms");
    for (size_t i = 0; i < s->sparse_count; i++) {
        float *slot = low_slot(out, dims, s->places[i]);
        if (slot) {
            *slot = (float)((double)*slot + factor * (double)s->values[i]);
        } else {
            places[rest->count] = s->places[i];
            values[rest->count++] = s->values[i];
        }
    }
    return CVOL_OK;
}

static void free_terms(term_list *list)
{
    free((void *)(uintptr_t)list->places);
    free((void *)(uintptr_t)list->values);
}

/* Frees unused reserved memory. */
static void shrink(cvol_spectrum *s)
{
    if (s->sparse_count == s->sparse_capacity)
        return;
    const size_t count = s->sparse_count ? s->sparse_count : 1;
    uint32_t *places = realloc(s->places, count * sizeof *places);
    float *values = realloc(s->values, count * sizeof *values);
    s->places = places ? places : s->places;
    s->values = values ? values : s->values;
    s->sparse_capacity = s->sparse_count;
}

static int merge_into(cvol_context *context, cvol_spectrum *out, const term_list *a,
                      const term_list *b)
{
    int code = cvol_spectrum_reserve(context, out, a->count + b->count);
    if (code)
        return code;
    out->sparse_count = merge_terms(out->places, out->values, a, b);
    shrink(out);
    return CVOL_OK;
}

/* *norm: the norm that rounding is a share of. */
static int add_spectra(cvol_context *context, cvol_spectrum *out, double *norm, double alpha,
                       const cvol_array *a, double beta, const cvol_array *b)
{
    const cvol_spectrum *x = &a->whole, *y = &b->whole;
    const size_t *dims = a->grid.dims;
    size_t low[3];
    for (int i = 0; i < 3; i++)
        low[i] = x->low[i] > y->low[i] ? x->low[i] : y->low[i];
    int code = cvol_spectrum_start(context, out, a->transform, dims, low);
    if (code)
        return code;
    if (!memcmp(x->box, y->box, sizeof x->box)) {
        for (size_t i = 0; i < out->low_count; i++)
            out->low_values[i] = (float)(alpha * (double)x->low_values[i] +
                                         beta * (double)y->low_values[i]);
        const term_list p = {x->places, x->values, x->sparse_count, alpha};
        const term_list q = {y->places, y->values, y->sparse_count, beta};
        code = merge_into(context, out, &p, &q);
        *norm = sqrt(cvol_spectrum_energy(out));
    } else {
        term_list p, q = {0};
        add_low(out, alpha, x, dims);
        add_low(out, beta, y, dims);
        code = divide_terms(context, &p, out, alpha, x, dims);
        if (!code)
            code = divide_terms(context, &q, out, beta, y, dims);
        if (!code)
            code = merge_into(context, out, &p, &q);
        free_terms(&p);
        free_terms(&q);
        /* A first product was rounded before the second was added. */
        *norm = fabs(alpha) * sqrt(cvol_spectrum_energy(x)) +
                fabs(beta) * sqrt(cvol_spectrum_energy(y));
    }
    if (code)
        cvol_spectrum_free(out);
    return code;
}

/* ---- the operations ------------------------------------------------------------------------- */

/* Fills out's terms with the part of `terms` that is kept. */
static int keep_terms(cvol_context *context, cvol_array *out, cvol_build_result *result,
                      const cvol_spectrum *terms, const cvol_keep *keep)
{
    const cvol_candidates candidates = {.slots = terms->low_values,
                                        .low = {terms->low[0], terms->low[1], terms->low[2]},
                                        .box = {terms->box[0], terms->box[1], terms->box[2]},
                                        .places = terms->places,
                                        .values = terms->values,
                                        .count = terms->sparse_count};
    return cvol_truncate(context, out, &result->dropped, &candidates, keep);
}

int cvol_whole_add(cvol_context *context, cvol_array *out, cvol_build_result *result, double alpha,
                   const cvol_array *a, double beta, const cvol_array *b, const cvol_keep *keep)
{
    const double threshold = fmax(fabs(alpha) * a->threshold, fabs(beta) * b->threshold);
    cvol_spectrum sum;
    *result = (cvol_build_result){.max_abs = -1};
    int code = add_spectra(context, &sum, &result->norm, alpha, a, beta, b);
    if (code)
        return code;
    if (keep->rule == CVOL_KEEP_LIKE_INPUTS) {
        out->whole = sum;
    } else {
        code = keep_terms(context, out, result, &sum, keep);
        cvol_spectrum_free(&sum);
    }
    out->threshold = fmax(out->threshold, threshold);
    return code;
}

int cvol_whole_scale(cvol_context *context, cvol_array *out, cvol_build_result *result,
                     double alpha, const cvol_array *a, double beta)
{
    const cvol_spectrum *from = &a->whole;
    cvol_spectrum *to = &out->whole;
    const double samples = (double)cvol_grid_samples(&a->grid), constant = beta * sqrt(samples);
    const float zero = 0;
    const uint32_t origin = 0;
    *result = (cvol_build_result){.max_abs = -1};
    int code = cvol_spectrum_start(context, to, a->transform, a->grid.dims, from->low);
    if (code)
        return code;
    for (size_t i = 0; i < to->low_count; i++)
        to->low_values[i] = (float)(alpha * (double)from->low_values[i]);
    const term_list terms = {from->places, from->values, from->sparse_count, alpha};
    const int has_constant = fabs(beta) > 0;
    const term_list one = {&origin, &zero, has_constant && !to->low_count ? 1 : 0, 0};
    code = merge_into(context, to, &one, &terms);
    if (code)
        return code;
    if (has_constant) {
        float *mean = to->low_count ? to->low_values : to->values;
        const float *was = to->low_count ? from->low_values : from->values;
        const int had = to->low_count || (from->sparse_count && from->places[0] == 0);
        *mean = (float)(constant + (had ? alpha * (double)*was : 0));
    }
    out->threshold = fabs(alpha) * a->threshold;
    result->norm = sqrt(cvol_spectrum_energy(to));
    return CVOL_OK;
}

int cvol_whole_truncate(cvol_context *context, cvol_array *out, cvol_build_result *result,
                        const cvol_array *a, const cvol_keep *keep)
{
    if (keep->rule == CVOL_KEEP_LIKE_INPUTS)
        return cvol_whole_scale(context, out, result, 1, a, 0);
    *result = (cvol_build_result){.norm = sqrt(cvol_spectrum_energy(&a->whole)), .max_abs = -1};
    int code = keep_terms(context, out, result, &a->whole, keep);
    out->threshold = fmax(out->threshold, a->threshold);
    return code;
}
