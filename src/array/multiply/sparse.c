/* The plan `sparse`: the product of two whole arrays (DFT, DHT) whose terms lie scattered over all
 * places, without evaluating all samples.
 *
 * Chen and Reif (2003) evaluate both operands at 2 n' roots of unity of order 2 n', n' the number
 * of terms, multiply, and interpolate. That folds the product's places modulo 2 n', and is right
 * only if no two of its terms meet there. But the product's support is the sumset of the operands'
 * supports: up to n'^2 places anywhere (doc/method.md has a counter-example small enough to check
 * by hand).
 *
 * This plan works as follows:
 *   1. find a superset of the sumset, coarse but certain          sparse_support.c
 *      (rank 1: after a dilation u -> m u that gathers the places  sparse_dilate.c)
 *   2. choose the number of bins to fold into                      sparse_columns.c
 *   3. choose the shifts, one per term that a bin may hold          sparse_shifts.c
 *   4. sample both operands at the shifts, multiply, fold          sparse_fold.c
 *   5. solve each bin for the few places that it can hold          sparse_solve.c
 *   6. truncate                                                    sparse_keep.c
 *
 * The result is certain, not probable: no term lies outside the superset, and each bin's system has
 * one solution. The effect of rounding is bounded and counted as dropped. If the supports have no
 * structure that makes the superset small, the plan does nothing: *verified is 0, at the cost of
 * steps 1 to 3. *verified is also 0 if bins that must be empty hold more than rounding, which
 * checks the whole chain on the actual numbers.
 *
 * Cost: O(shifts (terms + bins log bins) + superset). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/multiply/multiply.h"
#include "array/multiply/sparse.h"
#include "array/truncate/account.h"
#include "array/truncate/producer.h"
#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "transform/fft.h"

#define NEAR 5.0 /* times the least cost: no other way is tried below it */

/* Steps 1 and 2. */
static int plan_shape(cvol_context *context, cvol_sparse_shape *shape, int *found,
                      cvol_sparse_terms *a, cvol_sparse_terms *b)
{
    int rc = cvol_sparse_support(context, shape, found, a, b);
    if (rc || !*found)
        return rc;
    return cvol_sparse_choose_fold(context, shape, found, a->count + b->count);
}

/* Steps 3 to 6. */
static int carry_out(cvol_context *context, cvol_array *out, cvol_build_result *result,
                     cvol_sparse_shape *shape, const cvol_sparse_terms *a,
                     const cvol_sparse_terms *b, double spent, const cvol_keep *keep, int *verified)
{
    cvol_sparse_roots roots[3];
    cvol_sparse_found found = {0};
    float *values[CVOL_SPARSE_SHIFTS] = {NULL};
    double noise = 0, stray = 0;
    int apart, rc = cvol_sparse_choose_shifts(context, shape, &apart);
    if (rc || !apart)
        return rc;
    rc = cvol_sparse_roots_make(context, roots, shape);
    if (rc)
        return rc;
    for (size_t s = 0; s < shape->shift_count; s++) {
        values[s] = cvol_fft_allocate(cvol_sparse_half(shape));
        if (!values[s]) {
            rc = cvol_fail_memory(context, cvol_sparse_half(shape) * sizeof(float),
                                  "a fold of the product");
            goto done;
        }
    }
    rc = cvol_sparse_fold(context, values, &noise, shape, roots, a, b);
    if (rc || !isfinite(noise))
        goto done;
    rc = cvol_sparse_solve(context, &found, &stray, shape, roots, values);
    if (rc || stray > noise)
        goto done;
    rc = cvol_report_progress(context, "multiplying", 1);
    if (!rc)
        rc = cvol_sparse_keep(context, out, result, verified, shape, &found, noise, spent, keep);
done:
    for (size_t s = 0; s < shape->shift_count; s++)
        free(values[s]);
    cvol_sparse_found_free(&found);
    cvol_sparse_roots_free(roots);
    return rc;
}

/* The operands' terms of at least the magnitude `least`; one list if a and b are the same array.
 * *spent bounds |a b - a' b'|_2 for the remaining terms a' and b':
 *     a b - a' b' = a (b - b') + b' (a - a'),   max|b'| <= max|b| + |b - b'|_2 */
static int make_terms(cvol_context *context, cvol_sparse_terms terms[2], double *spent,
                      const cvol_array *a, const cvol_array *b, double least)
{
    double tail_a, tail_b;
    int rc = cvol_sparse_terms_make(context, &terms[0], &tail_a, a, least);
    if (rc)
        return rc;
    tail_b = tail_a;
    if (a != b)
        rc = cvol_sparse_terms_make(context, &terms[1], &tail_b, b, least);
    *spent = cvol_error_bound_tighten(&a->error_bound) * tail_b +
             (cvol_error_bound_tighten(&b->error_bound) + tail_b) * tail_a;
    return rc;
}

/* One way: all terms or the larger ones, original or dilated. */
typedef struct way {
    cvol_sparse_terms terms[2];
    const cvol_sparse_terms *of_b; /* terms[1], or terms[0] for a square */
    cvol_sparse_shape shape;
    double spent;
    int found;
} way;

static int make_plan(cvol_context *context, way *out, const cvol_array *a, const cvol_array *b,
                     double least, int dilate)
{
    const size_t *dims = a->grid.dims;
    cvol_sparse_terms *first = &out->terms[0], *second = a == b ? first : &out->terms[1];
    out->of_b = second;
    out->shape.transform = a->transform;
    memcpy(out->shape.dims, dims, sizeof out->shape.dims);
    out->shape.multiplier = out->shape.inverse = 1;
    int rc = make_terms(context, out->terms, &out->spent, a, b, least);
    if (rc)
        return rc;
    if (dilate) {
        out->shape.multiplier = cvol_sparse_multiplier(first, second, dims[0], &out->shape.inverse);
        if (out->shape.multiplier == 1)
            return CVOL_OK;
        cvol_sparse_terms_dilate(first, dims[0], out->shape.multiplier);
        if (second != first)
            cvol_sparse_terms_dilate(second, dims[0], out->shape.multiplier);
    }
    return plan_shape(context, &out->shape, &out->found, first, second);
}

static void free_plan(way *w)
{
    cvol_sparse_terms_free(&w->terms[0]);
    cvol_sparse_terms_free(&w->terms[1]);
    cvol_sparse_shape_free(&w->shape);
}

/* Plans both ways, unless the first is near the best possible, and takes the cheaper one. */
static int choose_plan(cvol_context *context, cvol_array *out, cvol_build_result *result,
                       const cvol_array *a, const cvol_array *b, double least,
                       const cvol_keep *keep, double limit_ms, int *verified)
{
    way ways[2];
    memset(ways, 0, sizeof ways);
    int rc = make_plan(context, &ways[0], a, b, least, 0), first = 0;
    const cvol_sparse_shape *plain = &ways[0].shape;
    if (!rc && a->rank == 1 && !(ways[0].found && plain->cost_ns < NEAR * plain->least_ns))
        rc = make_plan(context, &ways[1], a, b, least, 1);
    if (ways[1].found && (!ways[0].found || ways[1].shape.cost_ns < plain->cost_ns))
        first = 1;
    for (int i = 0; i < 2 && !rc && !*verified; i++) {
        way *w = &ways[i ? 1 - first : first];
        if (w->found && 1e-6 * w->shape.cost_ns <= limit_ms)
            rc = carry_out(context, out, result, &w->shape, &w->terms[0], w->of_b, w->spent, keep,
                           verified);
    }
    free_plan(&ways[0]);
    free_plan(&ways[1]);
    return rc;
}

/* The largest magnitude, by bisection of exponents, below which terms may be dropped for half of
 * the allowed loss; 0: none. */
static int find_least(cvol_context *context, double *least, const cvol_array *a,
                      const cvol_array *b, double allowed)
{
    double spent, low = -40, high = cvol_log2(allowed + 1e-300);
    *least = 0;
    for (int step = 0; step < 10 && low < high; step++) {
        cvol_sparse_terms terms[2] = {{0}, {0}};
        const double middle = (low + high) / 2;
        const int rc = make_terms(context, terms, &spent, a, b, cvol_pow(2, middle));
        cvol_sparse_terms_free(&terms[0]);
        cvol_sparse_terms_free(&terms[1]);
        if (rc)
            return rc;
        *(spent <= allowed / 2 ? &low : &high) = middle;
        if (spent <= allowed / 2)
            *least = cvol_pow(2, middle);
    }
    return CVOL_OK;
}

int cvol_multiply_sparse(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_array *b, const cvol_keep *keep,
                         double limit_ms, int *verified)
{
    *verified = 0;
    if (a->block || a->transform == CVOL_DCT)
        return CVOL_OK;
    const double allowed = cvol_array_allowed(out, keep);
    double least = 0;
    int rc = CVOL_OK;
    for (int pruned = 0; pruned < 2 && !rc && !*verified; pruned++) {
        if (pruned) {
            if (!isfinite(allowed))
                break;
            rc = find_least(context, &least, a, b, allowed);
            if (rc || least == 0)
                break;
        }
        rc = choose_plan(context, out, result, a, b, least, keep, limit_ms, verified);
    }
    return rc;
}
