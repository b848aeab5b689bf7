/* Counts and sums over a region, with bounds of their error (cvol/algebra.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/array.h"
#include "array/evaluate/box.h"
#include "array/evaluate/pieces.h"
#include "array/evaluate/sample_errors.h"
#include "base/context.h"
#include "base/memory.h"

/* Distances are counted by their leading bits, as floats: by 1/128 of their size. */
enum { BIN_SHIFT = 16, BINS = 1 << (31 - BIN_SHIFT) };

typedef struct region {
    const cvol_array *array;
    double
        half; /* decoded samples within so much of a limit count as on it: integers are rounded */
    double least, largest;  /* the limits */
    double below, above;    /* the nearest values outside */
    double error, each;     /* bounds of the errors: L2 of all samples, and of each */
    uint64_t *distances[2]; /* of samples inside, outside; BINS each */
    double *samples;
    uint8_t *fills;
    uint64_t inside, count;
    double sum, piece_sum; /* the latter of one piece, so that few additions follow each other */
} region;

/* ---- limits ---------------------------------------------------------------------------------- */

/* The nearest values that an original sample outside can have. Measured arrays of integers are made
 * from integers. */
static void find_outside(region *r)
{
    const int is_integer = cvol_type_is_integer(r->array->grid.type) &&
                           (r->array->measured || r->array->residual);
    if (is_integer) {
        r->half = 0.5;
        r->least = ceil(r->least);
        r->largest = floor(r->largest);
    }
    r->below = is_integer ? r->least - 1 : r->least;
    r->above = is_integer ? r->largest + 1 : r->largest;
}

/* ---- counting -------------------------------------------------------------------------------- */

static uint32_t bin_of(double distance)
{
    const float key = (float)fmax(0, distance * (1 - 1e-6)); /* never too far */
    uint32_t bits;
    memcpy(&bits, &key, sizeof bits);
    bits >>= BIN_SHIFT;
    return bits < BINS ? bits : BINS - 1;
}

static double least_in(uint32_t bin)
{
    const uint32_t bits = bin << BIN_SHIFT;
    float key;
    memcpy(&key, &bits, sizeof key);
    return (double)key;
}

/* Counts a sample, and its distance from where it would change sides. */
static void count_sample(region *r, double value, int is_exact)
{
    const cvol_error_bound *bound = &r->array->error_bound;
    if (!is_exact) /* the original is in this range, so this is not further from it */
        value = fmin(fmax(value, bound->value_min), bound->value_max);
    r->count++;
    r->piece_sum += value;
    const int is_inside = value >= r->least - r->half && value <= r->largest + r->half;
    double distance;
    if (is_inside)
        distance = fmin(value - r->below, r->above - value);
    else
        distance = value < r->least ? r->least - value : value - r->largest;
    r->inside += (uint64_t)is_inside;
    if (!is_exact && distance <= r->each)
        r->distances[!is_inside][bin_of(distance)]++;
}

/* At most so many of the samples at these distances can change sides. */
static uint64_t most_changes(const uint64_t *distances, double error)
{
    double left = error * error;
    uint64_t most = 0;
    for (uint32_t b = 0; b < BINS && error > 0; b++) {
        const double each = least_in(b) * least_in(b);
        if (!distances[b])
            continue;
        if ((double)distances[b] * each > left)
            return most + (uint64_t)floor(left / each);
        left -= (double)distances[b] * each;
        most += distances[b];
    }
    return most;
}

static int count_piece(cvol_context *context, void *user, const size_t begin[3],
                       const size_t end[3])
{
    region *r = user;
    const cvol_mask *mask = r->array->mask;
    const size_t count = (end[0] - begin[0]) * (end[1] - begin[1]) * (end[2] - begin[2]);
    const int code = cvol_array_evaluate_doubles(context, r->samples, r->array, begin, end);
    if (code)
        return code;
    const int has_fills = mask && cvol_mask_get(r->fills, mask, begin, end);
    const int is_exact = cvol_array_has_exact_background(r->array);
    const double background = cvol_array_background(r->array); /* may not fit into a float */
    r->piece_sum = 0;
    for (size_t i = 0; i < count; i++) {
        const int is_filled = has_fills && r->fills[i];
        if (!is_filled)
            count_sample(r, r->samples[i], 0);
        else if (!cvol_mask_is_void(mask))
            count_sample(r, background, is_exact);
    }
    r->sum += r->piece_sum;
    return CVOL_OK;
}

/* ---- public ---------------------------------------------------------------------------------- */

static void report(cvol_region *out, const region *r)
{
    const double count = (double)r->count;
    const uint64_t lost = most_changes(r->distances[0], r->error),
                   gained = most_changes(r->distances[1], r->error);
    *out = (cvol_region){
        .samples = r->count,
        .inside = r->inside,
        .inside_least = r->inside - lost,
        .inside_most = r->inside + gained,
        .sum = r->sum,
        .mean = r->count ? r->sum / count : 0,
        .sum_error = fmin(sqrt(count) * r->error, r->error > 0 ? count * r->each : 0)};
    out->mean_error = r->count ? out->sum_error / count : 0;
}

int cvol_array_compute_region(cvol_context *context, cvol_region *out, const cvol_array *array,
                              const size_t begin[3], const size_t end[3], double least,
                              double largest)
{
    memset(out, 0, sizeof *out);
    const int code = cvol_array_check_box(context, array, begin, end);
    if (code)
        return code;
    if (!(least <= largest))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "region: the least value is %g, the largest %g", least, largest);
    region r = {.array = array, .least = least, .largest = largest};
    const size_t piece = CVOL_PIECE_SAMPLES;
    r.distances[0] = cvol_allocate_zero(BINS, sizeof *r.distances[0]);
    r.distances[1] = cvol_allocate_zero(BINS, sizeof *r.distances[1]);
    r.samples = cvol_allocate(piece, sizeof *r.samples);
    r.fills = array->mask ? cvol_allocate(piece, 1) : NULL;
    int done = CVOL_OK;
    if (!r.distances[0] || !r.distances[1] || !r.samples || (array->mask && !r.fills))
        done = cvol_fail_memory(context, piece * sizeof *r.samples, "a piece of a region");
    cvol_array_sample_errors(&r.error, &r.each, array);
    find_outside(&r);
    if (!done)
        done = cvol_pieces_walk(context, count_piece, &r, begin, end);
    if (!done)
        report(out, &r);
    free(r.distances[0]);
    free(r.distances[1]);
    free(r.samples);
    free(r.fills);
    return done;
}
