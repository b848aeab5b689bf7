/* The light of a frame of the sheet engine. */
#ifndef CVOL_RENDER_SHEET_FRAME_LIGHT_H
#define CVOL_RENDER_SHEET_FRAME_LIGHT_H

#include "cvol/render.h"
#include "render/light/reach.h"
#include "render/sheet/frame/frame.h"
#include "render/view/shading.h"

/* Sets the light of a plan's frame, and the table's correction of midpoints that follows from it.
 * `table` has its scale; values: see cvol_light_set; reach: NULL if all light reaches everything.
 */
void cvol_frame_light_set(cvol_light *out, cvol_sheet_table *table, const cvol_grid *grid,
                          const cvol_sheet_plan *plan, const cvol_view *view,
                          const cvol_render_options *options, cvol_light_values values,
                          const cvol_reach *reach);

#endif
