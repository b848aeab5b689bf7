/* Light along rays: gradients of a dense volume, and Phong's model in double precision. */
#ifndef CVOL_RENDER_RAY_LIGHT_H
#define CVOL_RENDER_RAY_LIGHT_H

#include "render/ray/sample.h"
#include "render/view/camera.h"

/* A frame's light. */
typedef struct cvol_ray_light {
    cvol_shading shading; /* with light a unit vector */
    double eye[3];
    double rise[3];  /* mean spacing over the axis's own: for gradients */
    double fill;     /* cvol_illumination */
    double flat;     /* cvol_flat_gradient */
    double flats[2]; /* its bounds for other volumes (light_bound.h) */
    int cuts;        /* faces of the clip: cvol_view.cut */
    double cut[CVOL_VIEW_CUTS][4];
    /* The factor of light at a place, in sample indices; NULL: 1 everywhere. */
    double (*factor_at)(const void *source, const double place[3]);
    const void *source;
} cvol_ray_light;

cvol_ray_light cvol_ray_light_make(const cvol_render_options *options, const cvol_view *view,
                                   const cvol_grid *grid, double flat);

/* The source of gradients: one of the two functions, `masked` if the field has a mask. */
typedef struct cvol_ray_reader {
    const cvol_ray_field *field;
    cvol_ray_line_fn line;
    cvol_ray_masked_fn masked;
} cvol_ray_reader;

/* The effect of light: it turns a colour c into c factor + gloss, and multiplies distances by the
 * density (cvol_shading.gradient_opacity). */
typedef struct cvol_ray_lit {
    double factor, gloss, density;
} cvol_ray_lit;

/* The gradient, in samples per mean spacing, times cvol_cut_fade. reach[a]: how much its component
 * a changes at most if every sample changes by at most 1. */
void cvol_ray_gradient(double gradient[3], double reach[3], const cvol_ray_light *light,
                       const cvol_ray_reader *reader, const double place[3], double value);

/* The light at a place in sample indices where the volume has `value`. */
cvol_ray_lit cvol_ray_light_at(const cvol_ray_light *light, const cvol_ray_reader *reader,
                               const double place[3], double value);

#endif
