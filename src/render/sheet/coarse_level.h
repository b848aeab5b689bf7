/* The low-resolution volume of a compressed array, from the lowest frequencies of its blocks. */
#ifndef CVOL_RENDER_SHEET_COARSE_LEVEL_H
#define CVOL_RENDER_SHEET_COARSE_LEVEL_H

#include "render/light/coarse.h"
#include "render/sheet/frame/level.h"

/* The means of cells of the level below. Errors: MEMORY, CANCELLED. */
int cvol_coarse_of_array(cvol_context *context, cvol_coarse *out, const cvol_array *array);

#endif
