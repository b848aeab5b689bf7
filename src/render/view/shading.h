/* Checks of the options of light and surfaces. */
#ifndef CVOL_RENDER_VIEW_SHADING_H
#define CVOL_RENDER_VIEW_SHADING_H

#include "cvol/render.h"

/* For lit pictures, and for surfaces. Errors: ARGUMENT (invalid numbers, each named in the
 * message). */
int cvol_shading_check(cvol_context *context, const cvol_render_options *options);

#endif
