/* Extremes of a transfer function over an interval (envelope.h).
 *
 * The function is linear between its points, so its extremes over an interval are at its ends or at
 * points within it. Here the intervals are equal bins of the range of values. A sparse table has
 * the extremes over all runs of 2^k bins; two of them, which may overlap, cover any run. (Bender
 * and Farach-Colton, The LCA problem revisited, 2000.)
 *
 * Rounding. A bin includes a thousandth of its neighbours, because a value's bin is computed with
 * rounding. Interpolation in double precision has an error of some 2^-52; bounds of a channel that
 * is not constant are 2^-45 wider, but not beyond 0 and 1, which are limits of the points. (An
 * interpolated colour may exceed 1 by rounding; the slack of certified pictures covers that.)
 * Bounds are rounded outwards to floats; 0, 1 and infinity stay exact. */
#include "render/ray/envelope.h"

#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"

#define ROUNDING 0x1p-45
#define OVERLAP 0.001

typedef struct bounds {
    double lo[4], hi[4]; /* of r, g, b and opacity */
} bounds;

static void include(bounds *to, const cvol_transfer_point *point)
{
    const double values[4] = {point->r, point->g, point->b, point->opacity};
    for (int c = 0; c < 4; c++) {
        to->lo[c] = fmin(to->lo[c], values[c]);
        to->hi[c] = fmax(to->hi[c], values[c]);
    }
}

/* Bounds over the values a .. b; *next: number of points before a, or fewer; it becomes that of
 * points before a. */
static bounds bounds_over(const cvol_transfer *transfer, size_t *next, double a, double b)
{
    bounds out = {{1, 1, 1, 1}, {0, 0, 0, 0}};
    const cvol_transfer_point begin = cvol_transfer_before(transfer, a),
                              end = cvol_transfer_at(transfer, b);
    include(&out, &begin);
    include(&out, &end);
    while (*next < transfer->count && transfer->points[*next].value < a)
        (*next)++;
    for (size_t i = *next; i < transfer->count && transfer->points[i].value <= b; i++)
        include(&out, &transfer->points[i]);
    return out;
}

static float rounded_down(double value)
{
    const float nearest = (float)value;
    return (double)nearest > value ? nextafterf(nearest, -INFINITY) : nearest;
}

static cvol_ray_run run_of(const bounds *from)
{
    cvol_ray_run out;
    for (int c = 0; c < 4; c++) {
        const double slack = from->lo[c] < from->hi[c] ? ROUNDING : 0;
        double lo = fmax(from->lo[c] - slack, 0), hi = fmin(from->hi[c] + slack, 1);
        if (c == 3) {
            lo = -log1p(-lo);
            hi = -log1p(-hi);
        }
        out.least[c] = rounded_down(lo);
        out.least[c + 4] = rounded_down(-hi);
    }
    return out;
}

static void join(cvol_ray_run *out, const cvol_ray_run *a, const cvol_ray_run *b)
{
    for (int c = 0; c < 8; c++)
        out->least[c] = a->least[c] < b->least[c] ? a->least[c] : b->least[c];
}

int cvol_ray_envelope_make(cvol_context *context, cvol_ray_envelope *envelope,
                           const cvol_transfer *transfer, double min, double max)
{
    const double bin = (max - min) / CVOL_RAY_BINS;
    size_t next = 0;
    *envelope = (cvol_ray_envelope){.lo = min, .scale = 1 / bin};
    envelope->runs = cvol_allocate((size_t)CVOL_RAY_BIN_LEVELS * CVOL_RAY_BINS,
                                   sizeof *envelope->runs);
    if (!envelope->runs)
        return cvol_fail_memory(context,
                                sizeof *envelope->runs * CVOL_RAY_BIN_LEVELS * CVOL_RAY_BINS,
                                "the extremes of the transfer function");
    for (size_t i = 0; i < CVOL_RAY_BINS; i++) {
        const bounds all = bounds_over(transfer, &next, min + bin * ((double)i - OVERLAP),
                                       min + bin * ((double)i + 1 + OVERLAP));
        envelope->runs[i] = run_of(&all);
    }
    for (int k = 1; k < CVOL_RAY_BIN_LEVELS; k++) {
        const cvol_ray_run *half = envelope->runs + (size_t)(k - 1) * CVOL_RAY_BINS;
        cvol_ray_run *whole = envelope->runs + (size_t)k * CVOL_RAY_BINS;
        const size_t length = (size_t)1 << k;
        for (size_t i = 0; i + length <= CVOL_RAY_BINS; i++)
            join(&whole[i], &half[i], &half[i + length / 2]);
    }
    return CVOL_OK;
}

void cvol_ray_envelope_free(cvol_ray_envelope *envelope)
{
    free(envelope->runs);
    envelope->runs = NULL;
}
