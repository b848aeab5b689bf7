/* What the two ways of planning a frame share: plan.c (parallel projection) and
 * plan_perspective.c. */
#ifndef CVOL_RENDER_SHEET_FRAME_PLAN_H
#define CVOL_RENDER_SHEET_FRAME_PLAN_H

#include "render/sheet/frame/frame.h"

#define CVOL_INTERMEDIATE_MAX 32768

/* Of rays that nothing else softens: what is lost is seen, and costs little. */
#define CVOL_COARSEST_PITCH_OF_PIXELS 0.5

/* Clears a plan and sets what of it is the volume's and its clip's, with sheets across `axis`. */
void cvol_sheet_plan_volume(cvol_sheet_plan *plan, const cvol_array *array, int level,
                            const cvol_view *view, int axis);

/* Makes a sheet of every two, midpoint between these, if the volume allows it. */
void cvol_sheet_plan_halve(cvol_sheet_plan *plan);

/* Makes as few sheets as lie no further apart along a ray than `apart` mean spacings, if the volume
 * allows it, and at least one of every two. */
void cvol_sheet_plan_space(cvol_sheet_plan *plan, double apart);

/* The line kernels reconstruct a group of pixels from the points of one window, and from a fixed
 * number of vectors of points: they need pixels that lie at most one point apart on every sheet.
 * This limits `du` and `dv` to that. `farthest`: the largest scale of a sheet that a ray meets (see
 * cvol_sheet_crossing), 1 in parallel projection. */
void cvol_sheet_plan_limit(cvol_sheet_plan *plan, double farthest);

/* Makes a plan in parallel projection, at level 0, one whose rays are those of the picture's
 * pixels. 0, and it stays as it is, where neither lines nor columns of the picture run along lanes,
 * or pixels are more than 64 samples apart.
 */
int cvol_sheet_plan_image_order(cvol_sheet_plan *plan, const cvol_view *view);
/* As many points as these are worth; before a plan is made one of them. */
void cvol_sheet_refine(cvol_sheet_plan *plan);

/* Points per block and axis, their pitch, the place of the first, and the distance of intermediate
 * pixels, in samples, where a pixel of the picture spans `pixel` samples. */
void cvol_sheet_resolution(int *points, double *pitch, double *first, double *delta,
                           const cvol_view *view, double pixel, int block);

#endif
