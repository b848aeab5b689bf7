/* The low-resolution volume of a compressed array, from the lowest frequencies of its blocks. */
#ifndef CVOL_RENDER_SHEET_COARSE_LEVEL_H
#define CVOL_RENDER_SHEET_COARSE_LEVEL_H

#include "render/light/coarse.h"
#include "render/sheet/frame/level.h"

/* The means of cells of the level below, at the level of cvol_coarse_level. Memory: the level of
 * the cells, at most that of cells of 8 samples in 320 slices. Errors: MEMORY, CANCELLED. */
int cvol_coarse_of_array(cvol_context *context, cvol_coarse *out, const cvol_array *array);
/* The same at a given level, of an array without a residual. */
int cvol_coarse_of_array_at(cvol_context *context, cvol_coarse *out, const cvol_array *array,
                            int number);

#endif
