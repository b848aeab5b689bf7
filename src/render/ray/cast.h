/* One ray of the ray engine. */
#ifndef CVOL_RENDER_RAY_CAST_H
#define CVOL_RENDER_RAY_CAST_H

#include "render/ray/interval.h"
#include "render/ray/job.h"

/* Follows the ray of pixel (i, j). */
cvol_ray_seen cvol_ray_cast(const cvol_ray_job *job, int i, int j);

#endif
