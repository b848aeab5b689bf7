/* Studio light (cvol_render_options_set_studio). */
#include "cvol/look.h"

#define CINEMATIC_SAMPLES 64

/* Half of the light is soft; the key light makes forms, the fill keeps its far side readable. */
static const cvol_shading shading = {.on = 1,
                                     .light = {-0.55, 0.65, 0.9},
                                     .ambient = 0.3,
                                     .diffuse = 0.6,
                                     .specular = 0.1,
                                     .shininess = 24};
static const cvol_illumination illumination = {
    .fill = 0.2, .occlusion = 0.75, .shadows = 0.6, .in_view = 1, .keeps_brightness = 1};

void cvol_render_options_set_studio(cvol_render_options *options)
{
    const double gradient_opacity = options->shading.gradient_opacity;
    options->shading = shading;
    options->shading.gradient_opacity = gradient_opacity;
    options->illumination = illumination;
}

void cvol_render_options_set_cinematic(cvol_render_options *options, int samples)
{
    cvol_render_options_set_studio(options);
    options->shading.ambient = 0.35;
    options->shading.diffuse = 0.65;
    options->shading.specular = 0.15;
    options->shading.shininess = 32;
    options->illumination.fill = 0.1;
    options->illumination.occlusion = options->illumination.shadows = 1;
    options->illumination.samples = samples ? samples : CINEMATIC_SAMPLES;
}
