/* alpha a + beta b, alpha a + beta, and truncation, on the terms of blocks. The filter of lapped
 * volumes is linear: the sum of two lapped volumes is lapped. A lapped and a plain volume are added
 * as samples. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/algebra/operations.h"
#include "array/algebra/result_mask.h"
#include "array/block/block_sums.h"
#include "array/block/halo.h"
#include "array/truncate/account.h"
#include "array/truncate/blocks_keep.h"
#include "array/truncate/build.h"
#include "array/truncate/producer.h"
#include "array/truncate/result_block.h"
#include "base/context.h"
#include "base/memory.h"

/* ---- add and truncate ------------------------------------------------------------------------ */

typedef struct sum {
    const cvol_array *a, *b; /* b may be NULL */
    double alpha, beta;
    const cvol_array *shape;        /* the result */
    cvol_masked_operands *operands; /* a and b, where their background differs; or NULL */
} sum;

/* Samples on either side of a block that the pre-filter mixes with it. */
enum { REACH = 2 };

/* Lists one block's terms, times factor. */
static int list_terms(uint32_t *places, float *values, const uint32_t *words, const uint32_t *end,
                      double factor, int place_bits)
{
    int count = 0;
    for (; words < end; count++)
        values[count] = (float)(factor *
                                (double)cvol_term_unpack(&words, &places[count], place_bits));
    return count;
}

/* Merges the terms of two blocks. The only branches are for escapes, which are rare: the processor
 * cannot predict which list is ahead. */
static void add_listed(cvol_dense_block *out, const sum *s, const cvol_block *x,
                       const cvol_block *y, int place_bits)
{
    const uint32_t mask = (UINT32_C(1) << place_bits) - 1;
    const int32_t escape = cvol_term_escape(place_bits);
    const double step_a = s->alpha * s->a->step, step_b = s->beta * s->b->step;
    const uint32_t *a = x->terms, *b = y->terms;
    const uint32_t *const end_a = a + x->words, *const end_b = b + y->words;
    uint32_t *restrict places = out->places;
    float *restrict values = out->values;
    int count = 0;
    while (a < end_a && b < end_b) {
        const uint32_t place_a = *a & mask, place_b = *b & mask;
        const int take_a = place_a <= place_b, take_b = place_b <= place_a;
        int32_t value_a = (int32_t)*a >> place_bits, value_b = (int32_t)*b >> place_bits;
        a += take_a;
        b += take_b;
        if (__builtin_expect(take_a && value_a == escape, 0))
            value_a = (int32_t)*a++;
        if (__builtin_expect(take_b && value_b == escape, 0))
            value_b = (int32_t)*b++;
        places[count] = take_a ? place_a : place_b;
        values[count++] = (float)(step_a * (double)(-take_a & value_a) +
                                  step_b * (double)(-take_b & value_b));
    }
    count += list_terms(places + count, values + count, a, end_a, step_a, place_bits);
    count += list_terms(places + count, values + count, b, end_b, step_b, place_bits);
    out->count = count;
}

/* x = alpha x + beta y - offset */
static void add_samples(float *x, const float *y, const sum *s, size_t count, double offset)
{
    for (size_t i = 0; i < count; i++)
        x[i] = (float)(s->alpha * (double)x[i] + s->beta * (double)y[i] - offset);
}

/* Blocks with different splits are added as samples (of lapped volumes: before the filter), and
 * split anew. */
static void add_cells(cvol_dense_block *out, const sum *s, size_t index, float *x)
{
    float *y = x + cvol_array_block_terms(s->a);
    cvol_block_evaluate(x, s->a, index);
    cvol_block_evaluate(y, s->b, index);
    add_samples(x, y, s, cvol_array_block_terms(s->a), 0);
    cvol_result_transform(out, x, y, s->shape);
}

/* A block in which an operand's background ends, while the result's does not: from samples. */
static int produce_masked(const sum *s, cvol_dense_block *out, size_t index, void *scratch)
{
    const cvol_array *a = &s->operands->a, *b = &s->operands->b;
    const size_t halo_a = cvol_halo_bytes(a), room = cvol_result_box_room(s->shape);
    size_t size[3];
    ptrdiff_t begin[3];
    const size_t count = cvol_result_box(begin, size, s->shape, index);
    float *x = (float *)((char *)scratch + halo_a + cvol_halo_bytes(b)), *y = x + room;
    cvol_halo_read(x, scratch, a, begin, size);
    cvol_halo_read(y, (char *)scratch + halo_a, b, begin, size);
    add_samples(x, y, s, count, s->shape->offset);
    cvol_result_put(out, x, y + room, s->shape, index);
    out->max_abs = -1;
    return CVOL_OK;
}

/* One of the two is lapped: the sum is not. */
static int produce_mixed(const void *user, cvol_dense_block *out, size_t index, void *scratch)
{
    const sum *s = user;
    if (s->operands && cvol_masked_operands_differ(s->operands, index, 0))
        return produce_masked(s, out, index, scratch);
    const size_t halo_a = cvol_halo_bytes(s->a);
    float *x = (float *)((char *)scratch + halo_a + cvol_halo_bytes(s->b));
    float *y = x + cvol_array_block_terms(s->a);
    cvol_halo_evaluate(x, scratch, s->a, index);
    cvol_halo_evaluate(y, (char *)scratch + halo_a, s->b, index);
    add_samples(x, y, s, cvol_array_block_terms(s->a), 0);
    cvol_result_put(out, x, y, s->shape, index);
    out->max_abs = -1;
    return CVOL_OK;
}

static int produce_sum(const void *user, cvol_dense_block *out, size_t index, void *scratch)
{
    const sum *s = user;
    if (s->operands &&
        cvol_masked_operands_differ(s->operands, index, s->shape->lapped ? REACH : 0))
        return produce_masked(s, out, index, scratch);
    const int place_bits = cvol_place_bits(s->a->block_log2);
    const cvol_block *x = &s->a->block_table[index];
    const cvol_block *y = s->b ? &s->b->block_table[index] : x;
    if (x->split != y->split && x->words && y->words) {
        add_cells(out, s, index, scratch);
        return CVOL_OK;
    }
    out->split = x->words ? x->split : y->split;
    if (s->b)
        add_listed(out, s, x, y, place_bits);
    else
        out->count = list_terms(out->places, out->values, x->terms, x->terms + x->words,
                                s->alpha * s->a->step, place_bits);
    return CVOL_OK;
}

static int build_sum(cvol_context *context, cvol_array *out, cvol_build_result *result,
                     const sum *s, const cvol_keep *keep, const char *what)
{
    cvol_producer producer = {
        .produce = produce_sum,
        .user = s,
        .scratch_bytes = (2 * cvol_result_box_room(out) + cvol_result_scratch(out)) * sizeof(float),
        .what = what};
    if (s->b && s->a->lapped != s->b->lapped)
        producer.produce = produce_mixed;
    if (s->operands || producer.produce == produce_mixed)
        producer.scratch_bytes += cvol_halo_bytes(s->a) + cvol_halo_bytes(s->b);
    return cvol_build_blocks(context, out, result, &producer, keep);
}

int cvol_blocks_add(cvol_context *context, cvol_array *out, cvol_build_result *result, double alpha,
                    const cvol_array *a, double beta, const cvol_array *b, const cvol_keep *keep)
{
    cvol_masked_operands operands;
    sum s = {.a = a, .b = b, .alpha = alpha, .beta = beta, .shape = out};
    out->offset = alpha * a->offset + beta * b->offset;
    out->lapped = a->lapped && b->lapped;
    cvol_blocks_set_expected_bound(
        out, cvol_error_bound_add(alpha, &a->error_bound, beta, &b->error_bound));
    int code = cvol_result_mask_combine(context, out, &operands, a, b, 0,
                                        alpha * cvol_array_background(a) +
                                            beta * cvol_array_background(b));
    if (operands.masks[0] || operands.masks[1])
        s.operands = &operands;
    const cvol_keep resolved = cvol_blocks_keep_for_add(out, keep, alpha, &operands.a, beta,
                                                        &operands.b);
    if (!code)
        code = build_sum(context, out, result, &s, &resolved, "adding");
    cvol_masked_operands_free(&operands);
    return code;
}

int cvol_blocks_truncate(cvol_context *context, cvol_array *out, cvol_build_result *result,
                         const cvol_array *a, const cvol_keep *keep)
{
    if (keep->rule == CVOL_KEEP_LIKE_INPUTS)
        return cvol_blocks_scale(context, out, result, 1, a, 0);
    const sum s = {.a = a, .b = NULL, .alpha = 1, .beta = 0, .shape = out};
    out->offset = a->offset;
    out->lapped = a->lapped;
    cvol_blocks_set_expected_bound(out, a->error_bound);
    return build_sum(context, out, result, &s, keep, "truncating");
}

/* ---- scale: loses nothing -------------------------------------------------------------------- */

/* Copies a block's words and negates their values if `negate`. */
static void copy_terms(uint32_t *to, const cvol_block *from, int place_bits, int negate)
{
    if (!negate) {
        memcpy(to, from->terms, from->words * sizeof *to);
        return;
    }
    const uint32_t *words = from->terms, *end = words + from->words;
    while (words < end) {
        uint32_t place;
        const int32_t value = cvol_term_unpack(&words, &place, place_bits);
        to += cvol_term_pack(to, place, -value, place_bits);
    }
}

/* The energy of all terms. */
static double energy_of(const cvol_array *a)
{
    const double step = (double)(float)a->step;
    double squares = 0;
    for (size_t i = 0; i < a->block_count; i++)
        squares += cvol_block_squares(&a->block_table[i], cvol_place_bits(a->block_log2));
    return step * step * squares;
}

int cvol_blocks_scale(cvol_context *context, cvol_array *out, cvol_build_result *result,
                      double alpha, const cvol_array *a, double beta)
{
    double total, squares, variation;
    out->lapped = a->lapped;
    if (alpha != 0 && fabs(alpha) * a->step < (double)FLT_MIN) { /* float32 cannot hold it */
        const cvol_keep all = cvol_keep_all();
        const sum s = {.a = a, .b = NULL, .alpha = alpha, .beta = 0, .shape = out};
        out->offset = alpha * a->offset + beta;
        cvol_blocks_set_expected_bound(out, cvol_error_bound_scale(alpha, &a->error_bound, beta));
        return build_sum(context, out, result, &s, &all, "scaling");
    }
    int code = cvol_array_set_coding(context, out, out, a); /* terms stay, or change sign */
    if (code)
        return code;
    memset(result, 0, sizeof *result);
    result->max_abs = -1;
    out->offset = alpha * a->offset + beta;
    out->coefficients = 0;
    size_t words = 0;
    for (size_t i = 0; i < a->block_count && alpha != 0; i++)
        words += a->block_table[i].words;
    if (words == 0)
        return CVOL_OK;
    out->step = fabs(alpha) * a->step;
    out->threshold = fabs(alpha) * a->threshold;
    if (a->lapped)
        squares = energy_of(a);
    else
        code = cvol_blocks_sums(context, &total, &squares, &variation, a);
    if (code)
        return code;
    result->norm = fabs(alpha) * sqrt(squares);
    uint32_t *pool = malloc(words * sizeof *pool);
    if (!pool)
        return cvol_fail_memory(context, words * sizeof *pool, "the coefficients");
    code = cvol_array_adopt_pool(context, out, pool, words);
    if (code) {
        free(pool);
        return code;
    }
    for (size_t i = 0; i < a->block_count; i++) {
        const cvol_block *from = &a->block_table[i];
        cvol_block *to = &out->block_table[i];
        memcpy(to->low, from->low, sizeof to->low);
        to->split = from->split;
        to->words = from->words;
        to->terms = from->words ? pool : NULL;
        if (from->words)
            copy_terms(pool, from, cvol_place_bits(a->block_log2), alpha < 0);
        pool += from->words;
    }
    out->coefficients = a->coefficients;
    return CVOL_OK;
}
