/* Makes the mask of samples, and filled samples without artificial edges. */
#ifndef CVOL_CODEC_MASK_MASK_MAKE_H
#define CVOL_CODEC_MASK_MASK_MAKE_H

#include "array/core/mask.h"

/* Makes the mask of the samples that are fills, and a copy of all samples in which they have other
 * values (mask_fill.h); *mask and *filled are NULL if no sample is a fill. The caller frees both.
 * Errors: MEMORY, CANCELLED. */
int cvol_mask_make(cvol_context *context, cvol_mask **mask, void **filled, const void *samples,
                   const cvol_grid *grid, const cvol_fills *fills);

#endif
