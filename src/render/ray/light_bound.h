/* Bounds of the light at a place whose samples are known only within an error. */
#ifndef CVOL_RENDER_RAY_LIGHT_BOUND_H
#define CVOL_RENDER_RAY_LIGHT_BOUND_H

#include "render/ray/light.h"

/* Bounds of each field. */
typedef struct cvol_ray_lit_range {
    cvol_ray_lit lo, hi;
} cvol_ray_lit_range;

/* Bounds of cvol_ray_light_at for all volumes whose samples differ by at most `error`, which
 * includes rounding, from those of the reader. */
cvol_ray_lit_range cvol_ray_light_bound(const cvol_ray_light *light, const cvol_ray_reader *reader,
                                        const double place[3], double value, double error);

#endif
