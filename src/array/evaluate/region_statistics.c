/* Statistics of a box or an ellipsoid, with bounds of their error (cvol/algebra.h).
 *
 * Let d be the errors of the n samples of the region, of which c are not exact, |d| <= e (L2 norm)
 * and |d_i| <= m, so |d| <= E = min(e, sqrt(c) m). Then, as in statistics.c,
 *     mean          |<1, d>| / n <= sqrt(c) E / n         (Cauchy, Schwarz)
 *     deviation     |sd - sd~| <= E / sqrt(n)
 *     extremes      |min a - min a~| <= max |d_i|, the same for the largest: with i where a~ is
 *                   least, min a <= a_i <= min a~ + |d_i|, and with i where a is least, min a~ <=
 *                   a~_i <= min a + |d_i|
 * Extremes are those of samples in the stored type: clamped, and integers are rounded.
 *
 * The sum of (a - mean)^2 is one of positive terms, so that it does not cancel: that of each row,
 * and, where a row of m samples joins n others, the square of the distance of their means times
 * n m / (n + m) (Chan, Golub and LeVeque, The American Statistician 37, 1983, 2.1). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/array.h"
#include "array/evaluate/box.h"
#include "array/evaluate/pieces.h"
#include "array/evaluate/sample_errors.h"
#include "base/context.h"
#include "base/memory.h"

/* Samples on the surface of the ellipsoid belong to it, however their sum is rounded. */
static const double surface = 1 + 1e-12;

typedef struct statistics {
    const cvol_array *array;
    cvol_region_shape shape;
    double centre[3], radius[3]; /* of the ellipsoid, in samples */
    double shift;                /* the middle of the range */
    double *samples;             /* of a piece */
    double row[CVOL_PIECE_X];
    uint8_t *fills;
    uint64_t count, exact;
    double sum;       /* of samples less the shift */
    double variation; /* sum of (a - mean)^2 */
    double least, largest;
} statistics;

/* The square of the distance from the centre along an axis; 1 at the surface. */
static double square_along(const statistics *s, int axis, size_t at)
{
    const double along = ((double)at - s->centre[axis]) / s->radius[axis];
    return along * along;
}

/* A sample within the range of the original ones, from which it is not further away then. */
static double clamped_value(const cvol_array *array, double value)
{
    const cvol_error_bound *bound = &array->error_bound;
    return fmin(fmax(value, bound->value_min), bound->value_max);
}

/* Adds `count` samples, less the shift, of a row. */
static void join_row(statistics *s, const double *values, size_t count)
{
    if (!count)
        return;
    const double n = (double)s->count, m = (double)count;
    double sum = 0, variation = 0;
    for (size_t i = 0; i < count; i++)
        sum += values[i];
    const double mean = sum / m, apart = n > 0 ? mean - s->sum / n : 0;
    for (size_t i = 0; i < count; i++)
        variation += (values[i] - mean) * (values[i] - mean);
    s->variation += variation + apart * apart * (n * m / (n + m));
    s->sum += sum;
    s->count += count;
}

/* Adds the samples of a row that begins at (x, y, z). */
static void add_row(statistics *s, const double *samples, const uint8_t *fills, const size_t at[3],
                    size_t count)
{
    const int is_void = fills && cvol_mask_is_void(s->array->mask);
    const int is_exact = cvol_array_has_exact_background(s->array);
    const cvol_type type = s->array->grid.type;
    const double background = cvol_array_background(s->array); /* may not fit into a float */
    const double square = s->shape == CVOL_REGION_BOX
                              ? 0
                              : square_along(s, 1, at[1]) + square_along(s, 2, at[2]);
    size_t values = 0;
    for (size_t i = 0; i < count; i++) {
        const int is_filled = fills && fills[i];
        if (is_filled && is_void)
            continue;
        if (s->shape != CVOL_REGION_BOX && square + square_along(s, 0, at[0] + i) > surface)
            continue;
        const double value = is_filled ? background : clamped_value(s->array, samples[i]);
        const double stored = cvol_type_is_integer(type) ? rint(value)
                              : type == CVOL_FLOAT32     ? (double)(float)value
                                                         : value;
        s->exact += (uint64_t)(is_filled && is_exact);
        s->row[values++] = value - s->shift;
        s->least = fmin(s->least, stored);
        s->largest = fmax(s->largest, stored);
    }
    join_row(s, s->row, values);
}

static int add_piece(cvol_context *context, void *user, const size_t begin[3], const size_t end[3])
{
    statistics *s = user;
    const cvol_mask *mask = s->array->mask;
    const size_t row = end[0] - begin[0], rows = end[1] - begin[1];
    const int code = cvol_array_evaluate_doubles(context, s->samples, s->array, begin, end);
    if (code)
        return code;
    const int has_fills = mask && cvol_mask_get(s->fills, mask, begin, end);
    for (size_t r = 0; r < rows * (end[2] - begin[2]); r++) {
        const size_t at[3] = {begin[0], begin[1] + r % rows, begin[2] + r / rows};
        add_row(s, s->samples + r * row, has_fills ? s->fills + r * row : NULL, at, row);
    }
    return CVOL_OK;
}

static void report(cvol_region_statistics *out, const statistics *s)
{
    const double n = (double)s->count, coded = (double)(s->count - s->exact);
    double all, each;
    if (!s->count)
        return;
    cvol_array_sample_errors(&all, &each, s->array);
    const double error = coded > 0 ? fmin(all, all > 0 ? sqrt(coded) * each : 0) : 0;
    const double off = coded > 0 ? cvol_array_stored_error(s->array) : 0;
    *out = (cvol_region_statistics){.samples = s->count,
                                    .mean = s->shift + s->sum / n,
                                    .standard_deviation = sqrt(s->variation / n),
                                    .least = s->least,
                                    .largest = s->largest,
                                    .mean_error = sqrt(coded) * error / n,
                                    .standard_deviation_error = error / sqrt(n),
                                    .least_error = off,
                                    .largest_error = off};
}

int cvol_array_compute_region_statistics(cvol_context *context, cvol_region_statistics *out,
                                         const cvol_array *array, const size_t begin[3],
                                         const size_t end[3], cvol_region_shape shape)
{
    memset(out, 0, sizeof *out);
    int code = cvol_array_check_box(context, array, begin, end);
    if (code)
        return code;
    if (shape != CVOL_REGION_BOX && shape != CVOL_REGION_ELLIPSOID)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "region: the shape is %d, must be a box or an ellipsoid", (int)shape);
    const size_t piece = CVOL_PIECE_SAMPLES;
    const cvol_error_bound *bound = &array->error_bound;
    const double middle = 0.5 * (bound->value_min + bound->value_max);
    statistics s = {.array = array,
                    .shape = shape,
                    .shift = isfinite(middle) ? middle : 0,
                    .least = (double)INFINITY,
                    .largest = -(double)INFINITY,
                    .samples = cvol_allocate(piece, sizeof *s.samples),
                    .fills = array->mask ? cvol_allocate(piece, 1) : NULL};
    for (int a = 0; a < 3; a++) {
        s.centre[a] = 0.5 * (double)(begin[a] + end[a] - 1);
        s.radius[a] = 0.5 * (double)(end[a] - begin[a]);
    }
    if (!s.samples || (array->mask && !s.fills))
        code = cvol_fail_memory(context, piece * sizeof *s.samples, "a piece of a region");
    if (!code)
        code = cvol_pieces_walk(context, add_piece, &s, begin, end);
    if (!code)
        report(out, &s);
    free(s.samples);
    free(s.fills);
    return code;
}
