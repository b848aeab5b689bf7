/* Light of one interval of a ray. */
#ifndef CVOL_RENDER_RAY_INTERVAL_H
#define CVOL_RENDER_RAY_INTERVAL_H

#include "render/ray/light.h"
#include "render/ray/table.h"

/* The light that has reached the eye, the transmittance, and the depth at which it fell to one
 * half: infinity if it never did. */
typedef struct cvol_ray_seen {
    double rgb[3], through, depth;
} cvol_ray_seen;

/* An interval of a ray. */
typedef struct cvol_ray_interval {
    double share; /* its length in steps, times cover and density: at most 1 */
    cvol_ray_lit lit;
    double depth, rise; /* depth of its beginning, and the change to its end */
} cvol_ray_interval;

/* Composites the interval behind the light as one part: the whole of it has this value. */
void cvol_ray_interval_add(cvol_ray_seen *light, const cvol_ray_table *table,
                           const cvol_ray_interval *interval, double value);

/* The same for a volume that has these values at its front, middle and back, and is linear between
 * them. */
void cvol_ray_interval_add_divided(cvol_ray_seen *light, const cvol_ray_table *table,
                                   const cvol_ray_interval *interval, const double values[3]);

#endif
