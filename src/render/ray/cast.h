/* One ray of the ray engine. */
#ifndef CVOL_RENDER_RAY_CAST_H
#define CVOL_RENDER_RAY_CAST_H

#include "render/engine/engine.h"
#include "render/ray/light.h"
#include "render/ray/sample.h"
#include "render/ray/table.h"

typedef struct cvol_ray_state {
    cvol_grid grid;
    cvol_ray_field field;
    cvol_ray_line_fn line;
    cvol_ray_masked_fn masked; /* with a mask */
    cvol_transfer *transfer;
} cvol_ray_state;

/* What all pixels of one picture share. */
typedef struct cvol_ray_job {
    const cvol_ray_state *state;
    const cvol_view *view;
    cvol_mode mode;
    double background[3];
    double step; /* world length of one step */
    cvol_ray_table table;
    const cvol_ray_light *light; /* NULL: colours are as they are */
    const cvol_surface *surface;
} cvol_ray_job;

/* Light that has reached the eye, the share that still comes through, and how deep half of it was
 * lost: infinity where it never was. */
typedef struct cvol_ray_seen {
    double rgb[3], through, depth;
} cvol_ray_seen;

/* What pixel (i, j) sees. */
cvol_ray_seen cvol_ray_cast(const cvol_ray_job *job, int i, int j);

#endif
