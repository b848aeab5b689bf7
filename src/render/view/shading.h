/* Checks of the options of light and surfaces. */
#ifndef CVOL_RENDER_VIEW_SHADING_H
#define CVOL_RENDER_VIEW_SHADING_H

#include "cvol/render.h"

/* Of lit pictures, and of surfaces. Errors: ARGUMENT (numbers that have no meaning, each named in
 * the message). */
int cvol_shading_check(cvol_context *context, const cvol_render_options *options);

#endif
