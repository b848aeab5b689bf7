/* Pictures of several channels. */
#ifndef CVOL_VIEWER_VIEW_CHANNELS_H
#define CVOL_VIEWER_VIEW_CHANNELS_H

#include "viewer/view/view.h"

/* Draws the channels of an open view, each in its colour, and adds them like light. */
int channels_draw(cvol_context *context, const view *v, cvol_image *image,
                  const cvol_render_options *options);

#endif
