/* The defaults of options of pictures. */
#include "render/view/options.h"

#include "base/options.h"

static const cvol_render_options defaults = {
    .size = sizeof(cvol_render_options),
    .width = 512,
    .height = 512,
    .mode = CVOL_MODE_COMPOSITE,
    .camera = {.zoom = 1},
    .surface = {.colour = {0.9, 0.85, 0.75}},
    .shading = {.ambient = 0.1, .diffuse = 0.7, .specular = 0.2, .shininess = 10},
    .splat = {.footprint = CVOL_FOOTPRINT_GAUSSIAN,
              .size = 5,
              .plane = CVOL_FOOTPRINT_IN_VIEW,
              .order = CVOL_ORDER_FRONT},
    .transform = {CVOL_DCT, 16, 0.1, CVOL_SCHEDULE_DEFERRED, 0},
};

void cvol_render_options_set_defaults(cvol_render_options *options, size_t size)
{
    cvol_options_fill(options, size, &defaults, sizeof defaults);
}

int cvol_render_options_complete(cvol_context *context, cvol_render_options *out,
                                 const cvol_render_options *options)
{
    *out = defaults;
    return cvol_options_copy(context, out, sizeof *out, CVOL_SIZE_TO(cvol_render_options, clip),
                             "cvol_render_options", options);
}
