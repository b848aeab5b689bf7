/* The common part of the two planners: plan.c (parallel projection) and plan_perspective.c. */
#ifndef CVOL_RENDER_SHEET_FRAME_PLAN_H
#define CVOL_RENDER_SHEET_FRAME_PLAN_H

#include "render/sheet/frame/frame.h"

#define CVOL_INTERMEDIATE_MAX 32768

/* The coarsest points in image order, in pixels: it has no smoothing, and lost detail is visible.
 * The second is for pictures whose samples would otherwise exceed the memory of a frame. */
#define CVOL_IMAGE_ORDER_POINTS 0.3
#define CVOL_IMAGE_ORDER_POINTS_COARSE 0.5

/* Clears a plan and sets the properties of the volume and its clip, with slices across `axis`. */
void cvol_sheet_plan_volume(cvol_sheet_plan *plan, const cvol_array *array, int level,
                            const cvol_view *view, int axis);

/* Replaces every two slices by one at their midpoint, if the volume allows it. */
void cvol_sheet_plan_halve(cvol_sheet_plan *plan);

/* The line kernels reconstruct a group of pixels from the points of one window, and from a fixed
 * number of vectors of points. So pixels must lie at most one point apart on every slice; this
 * limits `du` and `dv` accordingly. `farthest`: the largest scale of a slice that a ray meets (see
 * cvol_sheet_crossing), 1 in parallel projection. */
void cvol_sheet_plan_limit(cvol_sheet_plan *plan, double farthest);

/* Converts a plan in parallel projection, at level 0, to one in image order. Returns 0 and leaves
 * it unchanged if neither lines nor columns of the picture run along lanes, or if pixels are more
 * than 64 samples apart. coarsest: the largest distance of points, in pixels. */
int cvol_sheet_plan_image_order(cvol_sheet_plan *plan, const cvol_view *view, double coarsest);
/* Returns 1 if the pixels of an image-order plan are so close together that the lit kernel for
 * int16 samples can draw it. */
int cvol_sheet_plan_fits_lit_int16(const cvol_sheet_plan *plan);
/* Sets the number of points that image order needs; before a plan becomes image-order. */
void cvol_sheet_refine(cvol_sheet_plan *plan, double coarsest);

/* Points per block and axis, their pitch, the place of the first, and the distance of intermediate
 * pixels, in samples, for a pixel of the picture that spans `pixel` samples. */
void cvol_sheet_resolution(int *points, double *pitch, double *first, double *delta,
                           const cvol_view *view, double pixel, int block);

#endif
