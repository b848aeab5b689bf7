/* The product of two whole arrays term by term: frequencies add, amplitudes multiply. Every pair of
 * terms once, O(n_a n_b), summed in double precision.
 *
 * Sums are stored by the hull index of their frequency (terms.h): in a dense array if the hull is
 * small compared with the number of products, else in a hash table with open addressing and linear
 * probing (Knuth, volume 3, 6.4), which grows before it is half full. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/multiply/cost.h"
#include "array/multiply/multiply.h"
#include "array/multiply/terms.h"
#include "array/truncate/account.h"
#include "array/truncate/candidates.h"
#include "array/truncate/producer.h"
#include "array/truncate/truncate.h"
#include "base/context.h"
#include "base/memory.h"

/* Products between two reports of progress. */
#define PRODUCTS_PER_REPORT ((size_t)1 << 24)

typedef struct direct_work {
    cvol_hull hull;
    int64_t centre; /* hull index of frequency 0, counted from the hull's first place */
    cvol_exponentials few, many;
    int real;               /* DCT: no imaginary parts */
    cvol_exponential *sums; /* the result, and the hash table: index -1: free */
    size_t count, mask;     /* of the table: sums in it, capacity - 1 */
    double *re, *im;        /* the dense array */
} direct_work;

/* Calls add(work, term of few) for all, with progress. */
static int for_all(cvol_context *context, direct_work *work,
                   int (*add)(cvol_context *context, direct_work *work,
                              const cvol_exponential *term))
{
    size_t since = PRODUCTS_PER_REPORT;
    int code = CVOL_OK;
    for (size_t i = 0; i < work->few.count && !code; i++) {
        if (since >= PRODUCTS_PER_REPORT) {
            since = 0;
            code = cvol_report_progress(context, "multiplying",
                                        (double)i / (double)work->few.count);
        }
        if (!code)
            code = add(context, work, &work->few.list[i]);
        since += work->many.count;
    }
    return code;
}

/* ---- dense ----------------------------------------------------------------------------------- */

/* One term of `few` times `count` neighbours in `many`. */
static void add_run(double *re, double *im, const cvol_exponential *f, const cvol_exponential *many,
                    size_t count)
{
    if (!im)
        for (size_t j = 0; j < count; j++)
            re[j] += f->re * many[j].re;
    else
        for (size_t j = 0; j < count; j++) {
            re[j] += f->re * many[j].re - f->im * many[j].im;
            im[j] += f->re * many[j].im + f->im * many[j].re;
        }
}

static int add_dense(cvol_context *context, direct_work *work, const cvol_exponential *f)
{
    (void)context;
    const cvol_exponential *many = work->many.list;
    const int64_t base = work->centre + f->index;
    for (size_t j = 0; j < work->many.count;) {
        size_t end = j + 1;
        while (end < work->many.count && many[end].index - many[j].index == (int64_t)(end - j))
            end++;
        const int64_t at = base + many[j].index;
        add_run(work->re + at, work->real ? NULL : work->im + at, f, many + j, end - j);
        j = end;
    }
    return CVOL_OK;
}

static int multiply_dense(cvol_context *context, direct_work *work)
{
    const size_t hull = (size_t)work->hull.count;
    work->re = cvol_allocate_zero(hull, sizeof *work->re);
    work->im = cvol_allocate_zero(work->real ? 0 : hull, sizeof *work->im);
    if (!work->re || !work->im)
        return cvol_fail_memory(context, 2 * hull * sizeof *work->re, "the sums of a product");
    int code = for_all(context, work, add_dense);
    if (code)
        return code;
    size_t count = 0;
    for (size_t i = 0; i < hull; i++)
        count += work->re[i] != 0 || (!work->real && work->im[i] != 0);
    work->sums = cvol_allocate(count, sizeof *work->sums);
    if (!work->sums)
        return cvol_fail_memory(context, count * sizeof *work->sums, "the sums of a product");
    for (size_t i = 0; i < hull; i++) {
        const double im = work->real ? 0 : work->im[i];
        if (work->re[i] != 0 || im != 0)
            work->sums[work->count++] = (cvol_exponential){(int64_t)i, work->re[i], im};
    }
    return CVOL_OK;
}

/* ---- hash table ------------------------------------------------------------------------------ */

static cvol_exponential *find_sum(cvol_exponential *sums, size_t mask, int64_t index)
{
    /* the upper half of a product with 2^64 / golden ratio */
    size_t at = (size_t)(((uint64_t)index * UINT64_C(0x9E3779B97F4A7C15)) >> 32) & mask;
    while (sums[at].index != index && sums[at].index >= 0)
        at = (at + 1) & mask;
    return &sums[at];
}

static int resize_table(cvol_context *context, direct_work *work, size_t capacity)
{
    cvol_exponential *larger = cvol_allocate(capacity, sizeof *larger);
    if (!larger)
        return cvol_fail_memory(context, capacity * sizeof *larger, "the sums of a product");
    for (size_t i = 0; i < capacity; i++)
        larger[i] = (cvol_exponential){.index = -1};
    if (work->sums)
        for (size_t i = 0; i <= work->mask; i++)
            if (work->sums[i].index >= 0)
                *find_sum(larger, capacity - 1, work->sums[i].index) = work->sums[i];
    free(work->sums);
    work->sums = larger;
    work->mask = capacity - 1;
    return CVOL_OK;
}

static int add_hashed(cvol_context *context, direct_work *work, const cvol_exponential *f)
{
    const int64_t base = work->centre + f->index;
    for (size_t j = 0; j < work->many.count; j++) {
        const cvol_exponential *g = &work->many.list[j];
        cvol_exponential *sum = find_sum(work->sums, work->mask, base + g->index);
        if (sum->index < 0) {
            sum->index = base + g->index;
            work->count++;
        }
        sum->re += f->re * g->re - f->im * g->im;
        sum->im += f->re * g->im + f->im * g->re;
        if (2 * work->count > work->mask) {
            int code = resize_table(context, work, 2 * (work->mask + 1));
            if (code)
                return code;
        }
    }
    return CVOL_OK;
}

static int multiply_hashed(cvol_context *context, direct_work *work)
{
    int code = resize_table(context, work, 1024);
    if (!code)
        code = for_all(context, work, add_hashed);
    if (code)
        return code;
    size_t count = 0;
    for (size_t i = 0; i <= work->mask; i++)
        if (work->sums[i].index >= 0)
            work->sums[count++] = work->sums[i];
    return CVOL_OK;
}

/* ---- the whole ------------------------------------------------------------------------------- */

int cvol_multiply_direct(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_array *b, const cvol_keep *keep)
{
    direct_work work = {.hull = cvol_hull_of(a, b), .real = a->transform == CVOL_DCT};
    const int64_t *width = work.hull.width, *extent = work.hull.extent;
    work.centre = extent[0] + width[0] * (extent[1] + width[1] * extent[2]);
    cvol_listed_slots slots = {0};
    const size_t terms_a = a->whole.low_count + a->whole.sparse_count;
    const size_t terms_b = b->whole.low_count + b->whole.sparse_count;
    int code = cvol_exponentials_list(context, &work.few, terms_a < terms_b ? a : b, &work.hull, 0);
    if (!code)
        code = cvol_exponentials_list(context, &work.many, terms_a < terms_b ? b : a, &work.hull,
                                      1);
    if (!code)
        code = cvol_multiply_is_dense((double)work.hull.count,
                                      (double)work.few.count * (double)work.many.count)
                   ? multiply_dense(context, &work)
                   : multiply_hashed(context, &work);
    if (!code)
        code = cvol_listed_slots_fold(context, &slots, out, &work.hull, work.sums, work.count);
    if (code)
        goto done;
    const cvol_candidates candidates = {
        .places = slots.places, .values = slots.values, .count = slots.count};
    code = cvol_truncate(context, out, &result->dropped, &candidates, keep);
    result->norm = sqrt(slots.energy);
    result->max_abs = -1;
done:
    free(work.few.list);
    free(work.many.list);
    free(work.sums);
    free(work.re);
    free(work.im);
    cvol_listed_slots_free(&slots);
    return code;
}
