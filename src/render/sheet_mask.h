/* Samples without a value (array/mask.h) as the sheet engine sees them: which blocks have some, and
 * how much of each of a layer's samples is of samples that have a value, its cover. */
#ifndef CVOL_RENDER_SHEET_MASK_H
#define CVOL_RENDER_SHEET_MASK_H

#include "array/mask.h"
#include "render/sheet.h"

/* cvol_mask_state of every block; the caller frees it. Errors: MEMORY. */
int cvol_sheet_mask_blocks(cvol_context *context, uint8_t **out, const cvol_array *array);

/* Writes the cover of block (lane, row) of a layer, whose state it is, where its samples lie. */
void cvol_sheet_mask_cover(float *out, long row_stride, long sheet_stride,
                           const cvol_sheet_plan *plan, const cvol_array *array,
                           const cvol_mask *mask, int state, size_t lane, size_t row, size_t layer);

#endif
