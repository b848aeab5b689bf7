/* Transfer functions: sorted control points, linear between them, constant outside.
 *
 * Two points of one value make a jump; at that value itself the later one applies. Opacity is given
 * for one mean sample spacing; by Beer's law a length of d spacings has the opacity 1 - (1 -
 * opacity)^d. */
#include "render/transfer/transfer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"

#define OPACITY_OF_FACES 0.3

/* ---- making ---------------------------------------------------------------------------- */

/* Reports the first invalid field of the point in one sentence. */
static int check_point(cvol_context *context, const cvol_transfer_point *point, size_t index,
                       int code, const char *name)
{
    const struct {
        const char *name;
        double value;
    } fields[] = {{"r", point->r}, {"g", point->g}, {"b", point->b}, {"opacity", point->opacity}};
    if (!isfinite(point->value))
        return cvol_fail(context, code, "%s: point %zu: value is %g, must be finite", name, index,
                         point->value);
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++)
        if (!(fields[i].value >= 0 && fields[i].value <= 1))
            return cvol_fail(context, code, "%s: point %zu: %s is %g, must be within 0 and 1", name,
                             index, fields[i].name, fields[i].value);
    return CVOL_OK;
}

typedef struct ranked {
    cvol_transfer_point point;
    size_t rank; /* its place in the input, which keeps equal values in order */
} ranked;

static int compare_ranked(const void *a, const void *b)
{
    const ranked *p = a, *q = b;
    if (p->point.value != q->point.value)
        return p->point.value < q->point.value ? -1 : 1;
    return p->rank < q->rank ? -1 : p->rank > q->rank;
}

static int sort_points(cvol_context *context, cvol_transfer_point *sorted,
                       const cvol_transfer_point *points, size_t count)
{
    ranked *order = cvol_allocate(count, sizeof *order);
    if (!order)
        return cvol_fail_memory(context, count * sizeof *order, "a transfer function");
    for (size_t i = 0; i < count; i++)
        order[i] = (ranked){points[i], i};
    qsort(order, count, sizeof *order, compare_ranked);
    for (size_t i = 0; i < count; i++)
        sorted[i] = order[i].point;
    free(order);
    return CVOL_OK;
}

int cvol_transfer_make(cvol_context *context, cvol_transfer **out,
                       const cvol_transfer_point *points, size_t count, int code, const char *name)
{
    *out = NULL;
    if (count < 1 || count > CVOL_TRANSFER_POINTS_MAX)
        return cvol_fail(context, code, "%s: %zu points, must be 1 to %d", name, count,
                         CVOL_TRANSFER_POINTS_MAX);
    for (size_t i = 0; i < count; i++)
        if (check_point(context, &points[i], i, code, name))
            return code;
    size_t bytes = sizeof(cvol_transfer) + count * sizeof(cvol_transfer_point);
    cvol_transfer *transfer = malloc(bytes);
    if (!transfer)
        return cvol_fail_memory(context, bytes, "a transfer function");
    transfer->count = count;
    int failure = sort_points(context, transfer->points, points, count);
    if (failure) {
        free(transfer);
        return failure;
    }
    *out = transfer;
    return CVOL_OK;
}

int cvol_transfer_create(cvol_context *context, cvol_transfer **out,
                         const cvol_transfer_point *points, size_t count)
{
    return cvol_transfer_make(context, out, points, count, CVOL_ERROR_ARGUMENT,
                              "transfer function");
}

int cvol_transfer_copy(cvol_context *context, cvol_transfer **out, const cvol_transfer *transfer)
{
    size_t bytes = sizeof *transfer + transfer->count * sizeof *transfer->points;
    *out = malloc(bytes);
    if (!*out)
        return cvol_fail_memory(context, bytes, "a transfer function");
    memcpy(*out, transfer, bytes);
    return CVOL_OK;
}

void cvol_transfer_free(cvol_transfer *transfer)
{
    free(transfer);
}

size_t cvol_transfer_count(const cvol_transfer *transfer)
{
    return transfer->count;
}

cvol_transfer_point cvol_transfer_point_at(const cvol_transfer *transfer, size_t index)
{
    if (index >= transfer->count)
        return (cvol_transfer_point){0};
    return transfer->points[index];
}

int cvol_transfer_is_opaque(const cvol_transfer *transfer)
{
    int are_colours = 0;
    for (size_t i = 0; i < transfer->count; i++) {
        const cvol_transfer_point *p = &transfer->points[i], *first = transfer->points;
        if (p->opacity < OPACITY_OF_FACES)
            return 0;
        are_colours |= fabs(p->r - first->r) + fabs(p->g - first->g) + fabs(p->b - first->b) > 0;
    }
    return are_colours;
}

/* ---- evaluating ------------------------------------------------------------------------ */

/* The number of points whose value is at most `value` (strictly less, if `below`). */
static size_t points_up_to(const cvol_transfer *transfer, double value, int below)
{
    size_t lo = 0, hi = transfer->count;
    while (lo < hi) {
        size_t middle = lo + (hi - lo) / 2;
        double at = transfer->points[middle].value;
        if (below ? at < value : at <= value)
            lo = middle + 1;
        else
            hi = middle;
    }
    return lo;
}

static double mix(double a, double b, double t)
{
    return a + (b - a) * t;
}

/* Interpolates between points next - 1 and next, with next the number of points left of the
 * value. */
static cvol_transfer_point between(const cvol_transfer *transfer, size_t next, double value)
{
    const cvol_transfer_point *q = &transfer->points[next];
    if (next == 0 || next == transfer->count) {
        cvol_transfer_point end = next == 0 ? *q : q[-1];
        end.value = value;
        return end;
    }
    const cvol_transfer_point *p = q - 1;
    /* Halves where the distance itself would overflow. */
    double scale = isfinite(q->value - p->value) ? 1 : 0.5;
    double t = (value * scale - p->value * scale) / (q->value * scale - p->value * scale);
    return (cvol_transfer_point){value, mix(p->r, q->r, t), mix(p->g, q->g, t), mix(p->b, q->b, t),
                                 mix(p->opacity, q->opacity, t)};
}

cvol_transfer_point cvol_transfer_at(const cvol_transfer *transfer, double value)
{
    return between(transfer, points_up_to(transfer, value, 0), value);
}

cvol_transfer_point cvol_transfer_before(const cvol_transfer *transfer, double value)
{
    return between(transfer, points_up_to(transfer, value, 1), value);
}

double cvol_opacity_over(double opacity, double distance)
{
    if (opacity >= 1)
        return distance > 0 ? 1 : 0;
    return -expm1(distance * log1p(-opacity));
}

double cvol_transfer_max_opacity(const cvol_transfer *transfer, double lo, double hi)
{
    double most = fmax(cvol_transfer_at(transfer, lo).opacity,
                       cvol_transfer_before(transfer, hi).opacity);
    for (size_t i = points_up_to(transfer, lo, 1);
         i < transfer->count && transfer->points[i].value <= hi; i++)
        most = fmax(most, transfer->points[i].opacity);
    return most;
}

double cvol_transfer_width(const cvol_transfer *transfer)
{
    if (!transfer)
        return 0;
    const cvol_transfer_point *points = transfer->points;
    size_t first = 0, last = transfer->count - 1;
    while (first < last && !(points[first + 1].opacity > 0) && !(points[first].opacity > 0))
        first++;
    while (last > first && !(points[last - 1].opacity > 0) && !(points[last].opacity > 0))
        last--;
    return points[last].value - points[first].value;
}
