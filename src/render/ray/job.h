/* The data of a picture that all its rays share. */
#ifndef CVOL_RENDER_RAY_JOB_H
#define CVOL_RENDER_RAY_JOB_H

#include "render/engine/engine.h"
#include "render/light/reach.h"
#include "render/ray/light.h"
#include "render/ray/sample.h"
#include "render/ray/table.h"

/* A ray ends when its transmittance is below this. */
#define CVOL_RAY_TRANSMITTANCE_MIN (1.0 / 1024)

typedef struct cvol_ray_state {
    cvol_grid grid;
    cvol_ray_field field;
    cvol_ray_line_fn line;
    cvol_ray_masked_fn masked; /* with a mask */
    cvol_transfer *transfer;
    const cvol_volume *volume;
    cvol_reach reach;
} cvol_ray_state;

/* The common data of all pixels of a picture. */
typedef struct cvol_ray_job {
    const cvol_ray_state *state;
    const cvol_view *view;
    cvol_mode mode;
    double background[3];
    double step; /* world length of one step */
    cvol_ray_table table;
    const cvol_ray_light *light; /* NULL: no light */
    const cvol_surface *surface;
    double cuts[2]; /* the values of black and white of its cut faces */
} cvol_ray_job;

/* The distance of samples along a ray, in mean spacings, if the options have none. */
#define CVOL_RAY_DEFAULT_STEP 0.5
/* Rows between two reports of progress. */
#define CVOL_RAY_BAND 32

/* The job of a picture, without its table, of which only the step is set. It refers to all
 * arguments; *light is made here. */
cvol_ray_job cvol_ray_job_make(const cvol_ray_state *state, cvol_ray_light *light,
                               const cvol_view *view, const cvol_render_options *options);

/* A level of a picture of bytes. Values that are not above 0, and NaN, are black. */
static inline uint8_t cvol_ray_to_byte(double level)
{
    if (!(level > 0))
        return 0;
    return level < 1 ? (uint8_t)(level * 255 + 0.5) : 255;
}

#endif
