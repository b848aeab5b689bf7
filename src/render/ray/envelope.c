/* Extremes of a transfer function over an interval (envelope.h).
 *
 * The function is linear between its points, so its extremes over a .. b are at a, at b or at a
 * point between them. A sparse table has the extremes over all runs of 2^k points; two of them,
 * which may overlap, cover any run of points. (Bender and Farach-Colton, The LCA problem revisited,
 * 2000.)
 *
 * Interpolation in double precision has an error of some 2^-52. All bounds of a channel that is not
 * constant are therefore 2^-45 wider, but not beyond 0 and 1, which are limits of the points. (An
 * interpolated value may exceed 1 by rounding; the slack of certified pictures covers that.) */
#include "render/ray/envelope.h"

#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"

#define ROUNDING 0x1p-45

static int levels_of(size_t count)
{
    int levels = 1;
    while (count >> levels)
        levels++;
    return levels;
}

static cvol_ray_extremes range_of(const cvol_transfer_point *point)
{
    return (cvol_ray_extremes){{point->r, point->g, point->b, point->opacity},
                               {point->r, point->g, point->b, point->opacity}};
}

static void join(cvol_ray_extremes *to, const cvol_ray_extremes *from)
{
    for (int c = 0; c < 4; c++) {
        to->lo[c] = from->lo[c] < to->lo[c] ? from->lo[c] : to->lo[c];
        to->hi[c] = from->hi[c] > to->hi[c] ? from->hi[c] : to->hi[c];
    }
}

int cvol_ray_envelope_make(cvol_context *context, cvol_ray_envelope *envelope,
                           const cvol_transfer *transfer)
{
    const size_t count = transfer->count;
    const int levels = levels_of(count);
    *envelope = (cvol_ray_envelope){.transfer = transfer};
    envelope->runs = cvol_allocate(count * (size_t)levels, sizeof *envelope->runs);
    if (!envelope->runs)
        return cvol_fail_memory(context, count * (size_t)levels * sizeof *envelope->runs,
                                "the extremes of the transfer function");
    for (size_t i = 0; i < count; i++)
        envelope->runs[i] = range_of(&transfer->points[i]);
    for (int k = 1; k < levels; k++) {
        const cvol_ray_extremes *half = envelope->runs + count * (size_t)(k - 1);
        cvol_ray_extremes *whole = envelope->runs + count * (size_t)k;
        const size_t length = (size_t)1 << k;
        for (size_t i = 0; i + length <= count; i++) {
            whole[i] = half[i];
            join(&whole[i], &half[i + length / 2]);
        }
    }
    return CVOL_OK;
}

void cvol_ray_envelope_free(cvol_ray_envelope *envelope)
{
    free(envelope->runs);
    envelope->runs = NULL;
}

/* The number of points with values below `value`, or, if not `below`, at most it. */
static size_t points_up_to(const cvol_transfer *transfer, double value, int below)
{
    size_t first = 0, count = transfer->count;
    while (count > 0) {
        const size_t half = count / 2;
        const double at = transfer->points[first + half].value;
        const int is_left = below ? at < value : at <= value;
        first = is_left ? first + half + 1 : first;
        count = is_left ? count - half - 1 : half;
    }
    return first;
}

/* Bounds of the function at a value with `next` points before it, on the segment to the next. */
static cvol_ray_extremes range_at(const cvol_transfer *transfer, size_t next, double value)
{
    const cvol_transfer_point *q = &transfer->points[next];
    if (next == 0 || next == transfer->count)
        return range_of(next == 0 ? q : q - 1);
    const cvol_ray_extremes p = range_of(q - 1), r = range_of(q);
    /* Halves, because the distance itself may overflow. */
    const double t = (value / 2 - q[-1].value / 2) / (q->value / 2 - q[-1].value / 2);
    cvol_ray_extremes out;
    for (int c = 0; c < 4; c++) {
        const double rise = r.lo[c] - p.lo[c], at = p.lo[c] + rise * t;
        const double slack = fabs(rise) > 0 ? ROUNDING : 0;
        out.lo[c] = at - slack;
        out.hi[c] = at + slack;
    }
    return out;
}

cvol_ray_extremes cvol_ray_envelope_over(const cvol_ray_envelope *envelope, double a, double b)
{
    const cvol_transfer *transfer = envelope->transfer;
    const size_t first = points_up_to(transfer, a, 1), end = points_up_to(transfer, b, 0);
    cvol_ray_extremes out = range_at(transfer, first, a);
    const cvol_ray_extremes last = range_at(transfer, end, b);
    join(&out, &last);
    if (first < end) {
        int k = levels_of(end - first) - 1;
        const cvol_ray_extremes *runs = envelope->runs + transfer->count * (size_t)k;
        join(&out, &runs[first]);
        join(&out, &runs[end - ((size_t)1 << k)]);
    }
    for (int c = 0; c < 4; c++) {
        const double slack = out.lo[c] < out.hi[c] ? ROUNDING : 0;
        out.lo[c] = fmax(out.lo[c] - slack, 0);
        out.hi[c] = fmin(out.hi[c] + slack, 1);
    }
    return out;
}
