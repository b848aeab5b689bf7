/* Sums over arrays with masks: masked_sums.h. */
#include "array/algebra/masked_sums.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/share.h"
#include "array/evaluate/box.h"
#include "base/context.h"
#include "base/memory.h"

/* Samples along each axis of the pieces that are evaluated together. Each has its own sums, which
 * are added in order. */
enum { PIECE_X = 256, PIECE_Y = 256, PIECE_Z = 64, PIECE = PIECE_X * PIECE_Y * PIECE_Z };

/* `sum` and `variation` over samples less the shifts. */
typedef struct partial {
    double number, sum[2], variation[2], squares[2], inner, apart;
} partial;

typedef struct sums {
    const cvol_array *arrays[2];
    int count;          /* of arrays */
    double shifts[2];   /* values near the means, so that variations do not cancel */
    double *samples[2]; /* of a piece */
    uint8_t *fills[2];  /* for arrays with samples without a value, or NULL */
    partial total;
} sums;

/* The loss of sums in double precision, as a share of the L2 norm of what is added: 2^-53 for each
 * of the additions that follow each other, in rows of a piece and of pieces. */
#define SUM_ROUNDING 1e-11

/* The samples of an array with a residual have its largest error, other samples the bound of the
 * terms. */
static double error_of(const cvol_array *a)
{
    if (a->residual)
        return a->max_error * sqrt((double)cvol_grid_samples(&a->grid));
    return a->error_bound.l2_error;
}

/* Samples of which the error is zero. That of a result's background is part of its bound. */
static double exact_samples(const cvol_array *a)
{
    const int is_exact = cvol_mask_is_background(a->mask) && a->measured;
    return is_exact ? (double)cvol_mask_samples(a->mask) : 0;
}

static int evaluate_piece(cvol_context *context, sums *s, const size_t begin[3],
                          const size_t end[3])
{
    int code = CVOL_OK;
    for (int i = 0; i < s->count && !code; i++) {
        code = cvol_array_evaluate_doubles(context, s->samples[i], s->arrays[i], begin, end);
        if (s->fills[i])
            cvol_mask_get(s->fills[i], s->arrays[i]->mask, begin, end);
    }
    return code;
}

static void add_partial(partial *to, const partial *from)
{
    to->number += from->number;
    to->inner += from->inner;
    to->apart += from->apart;
    for (int i = 0; i < 2; i++) {
        to->sum[i] += from->sum[i];
        to->variation[i] += from->variation[i];
        to->squares[i] += from->squares[i];
    }
}

/* Adds a row; rows are summed apart, so that sums of many samples stay exact. */
static void add_row(partial *to, const sums *s, size_t first, size_t count)
{
    const int second = s->count - 1; /* a alone: b is a */
    const double *a = s->samples[0] + first, *b = s->samples[second] + first;
    const uint8_t *void_a = s->fills[0] ? s->fills[0] + first : NULL;
    const uint8_t *void_b = s->fills[second] ? s->fills[second] + first : NULL;
    partial row = {0};
    for (size_t i = 0; i < count; i++) {
        if ((void_a && void_a[i]) || (void_b && void_b[i]))
            continue;
        const double x = a[i] - s->shifts[0], y = b[i] - s->shifts[second];
        const double difference = a[i] - b[i];
        row.number++;
        row.sum[0] += x;
        row.sum[1] += y;
        row.variation[0] += x * x;
        row.variation[1] += y * y;
        row.squares[0] += a[i] * a[i];
        row.squares[1] += b[i] * b[i];
        row.inner += a[i] * b[i];
        row.apart += difference * difference;
    }
    add_partial(to, &row);
}

static size_t least_of(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Evaluates the pieces of one layer of them, at slice z. */
static int add_layer(cvol_context *context, partial *pieces, sums *s, size_t z)
{
    const size_t *dims = s->arrays[0]->grid.dims;
    size_t at[3] = {0, 0, z};
    int code = cvol_report_progress(context, "summing", (double)z / (double)dims[2]);
    for (at[1] = 0; at[1] < dims[1]; at[1] += PIECE_Y)
        for (at[0] = 0; at[0] < dims[0] && !code; at[0] += PIECE_X) {
            const size_t end[3] = {least_of(at[0] + PIECE_X, dims[0]),
                                   least_of(at[1] + PIECE_Y, dims[1]),
                                   least_of(at[2] + PIECE_Z, dims[2])};
            const size_t row = end[0] - at[0];
            code = evaluate_piece(context, s, at, end);
            for (size_t r = 0; r < (end[1] - at[1]) * (end[2] - at[2]) && !code; r++)
                add_row(pieces, s, r * row, row);
            pieces++;
        }
    return code;
}

static int add_pieces(cvol_context *context, sums *s)
{
    const size_t *dims = s->arrays[0]->grid.dims;
    const size_t in_layer = ((dims[0] - 1) / PIECE_X + 1) * ((dims[1] - 1) / PIECE_Y + 1);
    const size_t count = in_layer * ((dims[2] - 1) / PIECE_Z + 1);
    const cvol_share share = cvol_share_of(context, s->arrays[0]);
    const size_t first = share.slices[0] / PIECE_Z, end = (share.slices[1] + PIECE_Z - 1) / PIECE_Z;
    partial *pieces = cvol_allocate_zero(count, sizeof *pieces);
    int code = pieces ? CVOL_OK : cvol_fail_memory(context, count * sizeof *pieces, "sums");
    for (size_t layer = first; layer < end && !code; layer++)
        code = add_layer(context, pieces + layer * in_layer, s, layer * PIECE_Z);
    code = cvol_team_complete(context, share.team, code, pieces, sizeof *pieces, first * in_layer,
                              end * in_layer);
    for (size_t i = 0; i < count && !code; i++)
        add_partial(&s->total, &pieces[i]);
    free(pieces);
    return code ? code : cvol_report_progress(context, "summing", 1);
}

static void report(cvol_masked_sums *out, const sums *s)
{
    const partial *t = &s->total;
    *out = (cvol_masked_sums){.samples = t->number, .inner = t->inner, .apart = t->apart};
    for (int i = 0; i < s->count; i++) {
        const double shift = s->shifts[i];
        out->sum[i] = t->sum[i] + t->number * shift;
        out->squares[i] = t->squares[i];
        out->variation[i] = t->number > 0 ? t->variation[i] - t->sum[i] * t->sum[i] / t->number : 0;
        out->error[i] = error_of(s->arrays[i]) +
                        SUM_ROUNDING * (sqrt(t->squares[i]) + sqrt(t->variation[i]));
        out->rounding[i] = SUM_ROUNDING * t->variation[i];
        out->exact[i] = exact_samples(s->arrays[i]);
    }
}

int cvol_masked_sums_compute(cvol_context *context, cvol_masked_sums *out, const cvol_array *a,
                             const cvol_array *b)
{
    sums s = {.arrays = {a, b}, .count = b ? 2 : 1};
    int code = CVOL_OK;
    for (int i = 0; i < s.count; i++) {
        const cvol_array *array = s.arrays[i];
        const cvol_error_bound *bound = &array->error_bound;
        const double middle = 0.5 * (bound->value_min + bound->value_max);
        s.shifts[i] = isfinite(middle) ? middle : 0;
        s.samples[i] = cvol_allocate(PIECE, sizeof *s.samples[i]);
        const int has_void = cvol_mask_is_void(array->mask);
        s.fills[i] = has_void ? cvol_allocate(PIECE, 1) : NULL;
        if (!s.samples[i] || (has_void && !s.fills[i]))
            code = cvol_fail_memory(context, PIECE * sizeof(double), "a piece of samples");
    }
    if (!code)
        code = add_pieces(context, &s);
    if (!code)
        report(out, &s);
    for (int i = 0; i < 2; i++) {
        free(s.samples[i]);
        free(s.fills[i]);
    }
    return code;
}
