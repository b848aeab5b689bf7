/* The set-up that engines splat and transform share: a state over samples, and the frame of a view.
 */
#ifndef CVOL_RENDER_SPLAT_SETUP_H
#define CVOL_RENDER_SPLAT_SETUP_H

#include "render/splat/frame.h"

/* Errors: ARGUMENT. */
int cvol_splat_options_check(cvol_context *context, const cvol_splat_options *splat);

/* Allocates an engine's state of `bytes`, zero except its first member, a cvol_splat_input over an
 * array or a volume (the other one is NULL). Errors: as cvol_splat_input_make. */
int cvol_splat_state_create(cvol_context *context, void **out, size_t bytes,
                            const cvol_array *array, const cvol_volume *volume);

/* The samples as a view sees them. */
typedef struct cvol_splat_setup {
    cvol_splat_plan plan;
    cvol_light light;
    int front;     /* slices are composited front to back */
    int ascending; /* slices are visited in rising order */
} cvol_splat_setup;

void cvol_splat_setup_make(cvol_splat_setup *out, const cvol_splat_input *input,
                           const cvol_view *view, const cvol_shading *shading, int front);
/* The same for the options of a picture, which it checks first; `engine` names it in messages.
 * Errors: ARGUMENT. */
int cvol_splat_setup_picture(cvol_context *context, cvol_splat_setup *out,
                             const cvol_splat_input *input, const cvol_view *view,
                             const cvol_render_options *options, const char *engine);

#endif
