/* Light that is scattered once, by rays through the samples: cvol_illumination.samples. The
 * reference for the cells of render/light. */
#ifndef CVOL_RENDER_RAY_SCATTERING_H
#define CVOL_RENDER_RAY_SCATTERING_H

#include "render/light/directions.h"
#include "render/ray/job.h"

typedef struct cvol_ray_scattering {
    const cvol_ray_job *job;
    cvol_directions directions;
    cvol_ray_table table; /* for steps of one mean spacing */
    double from_sky, from_disc;
    double start; /* the distance of the first sample, in the world */
} cvol_ray_scattering;

/* Prepares the light of a picture. It refers to the job. `cell`: the length of the cells of engine
 * sheet, in the world: factors are means over neighbouring cells, in which the
 * transparent ones count, so rays begin one cell away. The caller frees it, also after an error.
 * Errors: MEMORY. */
int cvol_ray_scattering_make(cvol_context *context, cvol_ray_scattering *out,
                             const cvol_ray_job *job, const cvol_render_options *options,
                             double cell);
void cvol_ray_scattering_free(cvol_ray_scattering *scattering);

/* The factor of light at a place, in sample indices, for cvol_ray_light. */
double cvol_ray_scattering_at(const void *scattering, const double place[3]);

#endif
