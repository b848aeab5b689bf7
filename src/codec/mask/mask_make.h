/* From samples to their mask, and to samples that the transform meets no edge in. */
#ifndef CVOL_CODEC_MASK_MASK_MAKE_H
#define CVOL_CODEC_MASK_MASK_MAKE_H

#include "array/core/mask.h"

/* The mask of those samples that are fills, and a copy of all samples where those have other values
 * (mask_fill.h); *mask and *filled are NULL where no sample is one. The caller frees both. Errors:
 * MEMORY, CANCELLED. */
int cvol_mask_make(cvol_context *context, cvol_mask **mask, void **filled, const void *samples,
                   const cvol_grid *grid, const cvol_fills *fills);

#endif
