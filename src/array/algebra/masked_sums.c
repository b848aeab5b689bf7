/* Sums over arrays with masks: masked_sums.h. */
#include "array/algebra/masked_sums.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/evaluate/box.h"
#include "base/context.h"
#include "base/memory.h"

/* Samples along each axis of the pieces that are evaluated together. */
enum { PIECE_X = 256, PIECE_Y = 256, PIECE_Z = 64, PIECE = PIECE_X * PIECE_Y * PIECE_Z };

typedef struct sums {
    const cvol_array *arrays[2];
    int count;         /* of arrays */
    double shifts[2];  /* values near the means, so that variations do not cancel */
    float *samples[2]; /* of a piece */
    uint8_t *fills[2]; /* for arrays with samples without a value, or NULL */
    double number, sum[2], squares[2], inner, apart; /* of samples less the shifts */
} sums;

/* The samples of an array with a residual have its largest error, other samples the bound of the
 * terms. */
static double error_of(const cvol_array *a)
{
    if (a->residual)
        return a->max_error * sqrt((double)cvol_grid_samples(&a->grid));
    return a->error_bound.l2_error;
}

static int evaluate_piece(cvol_context *context, sums *s, const size_t begin[3],
                          const size_t end[3])
{
    int code = CVOL_OK;
    for (int i = 0; i < s->count && !code; i++) {
        code = cvol_array_evaluate_real(context, s->samples[i], s->arrays[i], begin, end);
        if (s->fills[i])
            cvol_mask_get(s->fills[i], s->arrays[i]->mask, begin, end);
    }
    return code;
}

/* Adds a row; rows are summed apart, so that sums of many samples stay exact. */
static void add_row(sums *s, size_t first, size_t count)
{
    const int second = s->count - 1; /* a alone: b is a */
    const float *a = s->samples[0] + first, *b = s->samples[second] + first;
    const uint8_t *void_a = s->fills[0] ? s->fills[0] + first : NULL;
    const uint8_t *void_b = s->fills[second] ? s->fills[second] + first : NULL;
    double number = 0, sum[2] = {0}, squares[2] = {0}, inner = 0, apart = 0;
    for (size_t i = 0; i < count; i++) {
        if ((void_a && void_a[i]) || (void_b && void_b[i]))
            continue;
        const double x = (double)a[i] - s->shifts[0], y = (double)b[i] - s->shifts[second];
        const double difference = (double)a[i] - (double)b[i];
        number++;
        sum[0] += x;
        sum[1] += y;
        squares[0] += x * x;
        squares[1] += y * y;
        inner += x * y;
        apart += difference * difference;
    }
    s->number += number;
    s->inner += inner;
    s->apart += apart;
    for (int i = 0; i < 2; i++) {
        s->sum[i] += sum[i];
        s->squares[i] += squares[i];
    }
}

static size_t least_of(size_t a, size_t b)
{
    return a < b ? a : b;
}

static int add_pieces(cvol_context *context, sums *s)
{
    const size_t *dims = s->arrays[0]->grid.dims;
    size_t at[3];
    int code = CVOL_OK;
    for (at[2] = 0; at[2] < dims[2]; at[2] += PIECE_Z)
        for (at[1] = 0; at[1] < dims[1]; at[1] += PIECE_Y)
            for (at[0] = 0; at[0] < dims[0]; at[0] += PIECE_X) {
                const size_t end[3] = {least_of(at[0] + PIECE_X, dims[0]),
                                       least_of(at[1] + PIECE_Y, dims[1]),
                                       least_of(at[2] + PIECE_Z, dims[2])};
                code = cvol_report_progress(context, "summing", (double)at[2] / (double)dims[2]);
                if (!code)
                    code = evaluate_piece(context, s, at, end);
                if (code)
                    return code;
                const size_t row = end[0] - at[0];
                for (size_t r = 0; r < (end[1] - at[1]) * (end[2] - at[2]); r++)
                    add_row(s, r * row, row);
            }
    return cvol_report_progress(context, "summing", 1);
}

/* sum a b from sums of a - p and b - q: add q sum (a - p) + p sum (b - q) + n p q. */
static void report(cvol_masked_sums *out, const sums *s)
{
    const int second = s->count - 1;
    *out = (cvol_masked_sums){.samples = s->number, .apart = s->apart};
    for (int i = 0; i < s->count; i++) {
        const double shift = s->shifts[i];
        out->sum[i] = s->sum[i] + s->number * shift;
        out->squares[i] = s->squares[i] + 2 * shift * s->sum[i] + s->number * shift * shift;
        out->variation[i] = s->number > 0 ? s->squares[i] - s->sum[i] * s->sum[i] / s->number : 0;
        out->error[i] = error_of(s->arrays[i]);
    }
    out->inner = s->inner + s->shifts[second] * s->sum[0] + s->shifts[0] * s->sum[1] +
                 s->number * s->shifts[0] * s->shifts[second];
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
            code = cvol_fail_memory(context, PIECE * sizeof(float), "a piece of samples");
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
