/* Transfer functions made from others: moved to a window of values, and more or less opaque.
 *
 * A window moves values linearly, the first point to its lower end and the last to its upper end.
 * At s times the density, opacity becomes 1 - (1 - opacity)^s (Beer's law), which stays below 1. */
#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/transfer/transfer.h"

static int check(cvol_context *context, const double *window, double opacity_scale)
{
    if (window && (!isfinite(window[0]) || !isfinite(window[1]) || !(window[1] > window[0])))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "a window from %g to %g: must be finite, the second larger", window[0],
                         window[1]);
    if (!(opacity_scale >= 0) || !isfinite(opacity_scale))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "opacities times %g: must be finite and not below 0", opacity_scale);
    return CVOL_OK;
}

int cvol_transfer_create_adjusted(cvol_context *context, cvol_transfer **out,
                                  const cvol_transfer *from, const double *window,
                                  double opacity_scale)
{
    *out = NULL;
    int code = check(context, window, opacity_scale);
    if (code)
        return code;
    const size_t count = from->count;
    const double first = from->points[0].value, span = from->points[count - 1].value - first;
    cvol_transfer_point *points = cvol_allocate(count, sizeof *points);
    if (!points)
        return cvol_fail_memory(context, count * sizeof *points, "a transfer function");
    for (size_t i = 0; i < count; i++) {
        points[i] = from->points[i];
        if (window) {
            const double t = span > 0 ? (points[i].value - first) / span : 0.5;
            points[i].value = window[0] + t * (window[1] - window[0]);
        }
        if (opacity_scale < 1 || opacity_scale > 1)
            points[i].opacity = cvol_opacity_over(points[i].opacity, opacity_scale);
    }
    code = cvol_transfer_create(context, out, points, count);
    free(points);
    return code;
}

int cvol_transfer_create_rescaled(cvol_context *context, cvol_transfer **out,
                                  const cvol_transfer *from, const double rescale[2])
{
    const size_t count = from->count;
    *out = NULL;
    if (!(fabs(rescale[0]) > 0) || !isfinite(rescale[0]) || !isfinite(rescale[1]))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "a rescale of %g, %g: must be finite, with a factor that is not 0",
                         rescale[0], rescale[1]);
    cvol_transfer_point *points = cvol_allocate(count, sizeof *points);
    if (!points)
        return cvol_fail_memory(context, count * sizeof *points, "a transfer function");
    for (size_t i = 0; i < count; i++) { /* a negative factor reverses their order */
        points[i] = from->points[rescale[0] < 0 ? count - 1 - i : i];
        points[i].value = (points[i].value - rescale[1]) / rescale[0];
    }
    const int code = cvol_transfer_create(context, out, points, count);
    free(points);
    return code;
}

/* The points of both, in the order of values; at a jump of the opacities both sides. */
int cvol_transfer_create_recoloured(cvol_context *context, cvol_transfer **out,
                                    const cvol_transfer *opacities, const cvol_transfer *colours)
{
    const size_t n = opacities->count, m = colours->count;
    cvol_transfer_point *points = cvol_allocate(n + m, sizeof *points);
    size_t i = 0, j = 0, count = 0;
    *out = NULL;
    if (!points)
        return cvol_fail_memory(context, (n + m) * sizeof *points, "a transfer function");
    while (i < n || j < m) {
        const int own = j == m || (i < n && opacities->points[i].value <= colours->points[j].value);
        cvol_transfer_point p = own ? opacities->points[i] : colours->points[j];
        const cvol_transfer_point colour = own ? cvol_transfer_at(colours, p.value) : p;
        if (!own)
            p.opacity = cvol_transfer_at(opacities, p.value).opacity;
        p.r = colour.r;
        p.g = colour.g;
        p.b = colour.b;
        /* A value of both: the opacities' own points have it. */
        if (own || i == 0 || p.value > opacities->points[i - 1].value)
            points[count++] = p;
        if (own)
            i++;
        else
            j++;
    }
    const int code = cvol_transfer_create(context, out, points, count);
    free(points);
    return code;
}
