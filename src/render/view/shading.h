/* Light and surfaces of the options: checks, and the light of a frame. */
#ifndef CVOL_RENDER_VIEW_SHADING_H
#define CVOL_RENDER_VIEW_SHADING_H

#include "cvol/render.h"
#include "render/view/light.h"
#include "render/view/view.h"

#define CVOL_LIGHT_SAMPLES_MAX 65536

/* For lit pictures, and for surfaces. Errors: ARGUMENT (invalid numbers, each named in the
 * message). */
int cvol_shading_check(cvol_context *context, const cvol_render_options *options);

/* Returns 1 if what reaches a place depends on other places. */
static inline int cvol_illumination_needs_volume(const cvol_illumination *light)
{
    return light->occlusion > 0 || light->shadows > 0 || light->keeps_brightness;
}

/* Turns a light that is given in the view (cvol_illumination.in_view) into the world. */
void cvol_shading_place(cvol_render_options *options, const cvol_view *view);

/* The gradient of a sample whose light is half that of a surface and half that of matter without a
 * direction. `width` is that of the transfer function, `range` that of the samples. A picture has
 * 256 levels: where the visible values are so flat that they would take twice as many samples to
 * change from the first to the last, the direction of the gradient is that of noise and rounding.
 * So it is, whatever is visible, where the samples change by less than 1/2048 of their range. */
double cvol_flat_gradient(double width, double range);

/* Values of a volume, as the light needs them. */
typedef struct cvol_light_values {
    double flat;  /* cvol_flat_gradient */
    double range; /* of the samples. Squares of gradients in units of about this range are floats */
} cvol_light_values;

/* Axis k of the light is axis axes[k] of the volume, reversed if turns[k] is -1. fill: see
 * cvol_illumination. */
void cvol_light_set(cvol_light *light, const cvol_view *view, const cvol_grid *grid,
                    const cvol_shading *shading, double fill, cvol_light_values values,
                    const int axes[3], const int turns[3]);

#endif
