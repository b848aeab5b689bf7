/* The pixels that see the volume: their rays against its faces (Kay and Kajiya, "Ray Tracing
 * Complex Scenes", 1986), with slices as the measure along them. The intermediate image ends with
 * its own rays, which may lie further apart than pixels. */
#include "render/sheet/warp/outline.h"

#include <math.h>

/* The remaining part of rays: from slice `from` to `to`. */
typedef struct ray_parts {
    double from[CVOL_WARP_CHUNK], to[CVOL_WARP_CHUNK];
} ray_parts;

/* Keeps the part with start[i] + rate z >= 0. */
static void cut_rays(ray_parts *parts, const double *start, double rate, int count)
{
    if (!(fabs(rate) > 1e-12)) {
        for (int i = 0; i < count; i++)
            parts->to[i] = start[i] < 0 ? -INFINITY : parts->to[i];
        return;
    }
    const double inverse = -1 / rate;
    for (int i = 0; i < count; i++) {
        const double at = start[i] * inverse;
        if (rate > 0)
            parts->from[i] = at > parts->from[i] ? at : parts->from[i];
        else
            parts->to[i] = at < parts->to[i] ? at : parts->to[i];
    }
}

void cvol_warp_outline(uint8_t hit[CVOL_WARP_CHUNK], const cvol_sheet_plan *plan,
                       const cvol_warp_places *places)
{
    const double shears[2] = {plan->shear_lane, plan->shear_row};
    double at[2][CVOL_WARP_CHUNK], start[CVOL_WARP_CHUNK];
    ray_parts parts;
    for (int i = 0; i < places->count; i++) {
        at[0][i] = plan->u0 + places->u[i] * plan->du;
        at[1][i] = plan->v0 + places->v[i] * plan->dv;
        parts.from[i] = plan->lo[2];
        parts.to[i] = plan->hi[2];
    }
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < places->count; i++)
            start[i] = at[k][i] - plan->lo[k];
        cut_rays(&parts, start, shears[k], places->count);
        for (int i = 0; i < places->count; i++)
            start[i] = plan->hi[k] - at[k][i];
        cut_rays(&parts, start, -shears[k], places->count);
    }
    for (int i = 0; i < places->count; i++)
        hit[i] = parts.to[i] >= parts.from[i];
}
