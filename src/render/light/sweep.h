/* How much matter lies between each cell and a light: sweeps over a low-resolution volume, slice
 * by slice away from the light. */
#ifndef CVOL_RENDER_LIGHT_SWEEP_H
#define CVOL_RENDER_LIGHT_SWEEP_H

#include "render/light/coarse.h"

/* A sweep goes along the axis on which `way` is longest; depths of a slice follow from those of the
 * slice before, blurred, so that shadows become softer with the distance from what casts them.
 *
 *     depth(p) = keep (depth(q) + length extinction(q)),   q = p + one cell towards the light */
typedef struct cvol_sweep {
    double way[3]; /* to the light, in the world, of any length */
    double blur;   /* of each step: 0 (B-spline, 3 x 3 cells) to 1 (weights 1 2 1) */
    double keep;   /* the share of the depth that counts one cell further, 1: all */
} cvol_sweep;

/* Calls use(user, depths, first, count, stride) for every row of cells: cell k of the row is number
 * first + k stride of the volume. Rows of a slice are in parallel. Errors: MEMORY. */
typedef void (*cvol_sweep_fn)(void *user, const float *depths, size_t first, size_t count,
                              size_t stride);
int cvol_sweep_run(cvol_context *context, const cvol_coarse *coarse, const float *extinction,
                   const cvol_sweep *sweep, cvol_sweep_fn use, void *user);

/* The transmittance of a depth, within 0.02 of exp(-depth). */
static inline float cvol_sweep_transmittance(float depth)
{
    return 1 / (1 + depth * (1 + depth * (0.5f + depth * (1.0f / 6 + depth * (1.0f / 24)))));
}

#endif
