/* Certified pictures: bounds of the picture of the original samples (cvol_renderer_certify). */
#ifndef CVOL_RENDER_RAY_CERTIFY_H
#define CVOL_RENDER_RAY_CERTIFY_H

#include "render/engine/engine.h"

/* Bounds for an error above 0. `state` is a cvol_ray_state; range: NULL if unknown. */
int cvol_ray_certify(cvol_context *context, void *state, cvol_image *lower, cvol_image *upper,
                     const cvol_view *view, const cvol_render_options *options, double error,
                     const double range[2]);

#endif
