/* The table of a frame of the sheet engine, and the format of its samples. */
#ifndef CVOL_RENDER_SHEET_FRAME_VALUES_H
#define CVOL_RENDER_SHEET_FRAME_VALUES_H

#include "cvol/render.h"
#include "render/sheet/band/skip.h"
#include "render/sheet/frame/frame.h"
#include "render/sheet/frame/policy.h"

/* Sets the table of a plan's frame, and the plan's sample format, which follows from it; for a
 * surface also its visibility. noise: of the samples, by cvol_transfer_traits_of. Errors: MEMORY.
 */
int cvol_frame_values_set(cvol_context *context, cvol_sheet_table *table, cvol_sheet_plan *plan,
                          cvol_visibility *by_surface, const cvol_array *array,
                          const cvol_transfer *transfer, double noise,
                          const cvol_render_options *options, const cvol_policy *policy);

/* 1 if int16 samples of the array suit light. */
int cvol_frame_fits_lit_int16(const cvol_array *array, int lapped);

#endif
