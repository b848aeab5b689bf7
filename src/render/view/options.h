/* Options of pictures: complete. */
#ifndef CVOL_RENDER_VIEW_OPTIONS_H
#define CVOL_RENDER_VIEW_OPTIONS_H

#include "cvol/render.h"

/* Copies the options of a caller over the defaults. Errors: ARGUMENT (its size). */
int cvol_render_options_complete(cvol_context *context, cvol_render_options *out,
                                 const cvol_render_options *options);

#endif
