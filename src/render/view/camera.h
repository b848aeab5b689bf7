/* Views from the options of pictures. */
#ifndef CVOL_RENDER_VIEW_CAMERA_H
#define CVOL_RENDER_VIEW_CAMERA_H

#include "cvol/render.h"
#include "render/view/view.h"

/* Returns 1 if pictures of the mode are grey levels, not colours. */
static inline int cvol_mode_is_grey(cvol_mode mode)
{
    return mode == CVOL_MODE_XRAY || mode == CVOL_MODE_MIP || mode == CVOL_MODE_MIN;
}

/* The axis across a slab, a volume much thinner than wide; -1: not a slab. */
int cvol_view_thin_axis(const cvol_grid *grid);

/* Adds a face of the volume as a cut: the lower one of an axis, or the upper one. strength: 0 (no
 * effect) to 1 (as a face of the clip). */
void cvol_view_add_face(cvol_view *view, const cvol_grid *grid, int axis, int is_upper,
                        double strength);

/* The view of a grid under these options. Errors: ARGUMENT (invalid sizes, zoom, angles or step,
 * each named in the message; a clip that leaves nothing). */
int cvol_view_make(cvol_context *context, cvol_view *out, const cvol_grid *grid,
                   const cvol_render_options *options);

/* 1 if the clip shows the place with these coordinates, in samples. */
int cvol_clip_shows(const cvol_clip *clip, const cvol_grid *grid, const double at[3]);

#endif
