/* Fills masked samples with values that avoid artificial edges in the transform. Each brick of 64^3
 * is filled separately from its unmasked samples by push and pull (Gortler and others 1996, "The
 * Lumigraph"): averages of known points on grids of half the points, then back from coarse to fine,
 * smoothing unknown points. The values do not depend on the number of threads or on slabs. */
#ifndef CVOL_CODEC_MASK_MASK_FILL_H
#define CVOL_CODEC_MASK_MASK_FILL_H

#include "array/core/mask.h"
#include "cvol/base.h"

/* Copies slices [first, end) of a volume; samples and out begin at slice `first`, a multiple of 64
 * (end too, or the volume's end). Replaces masked samples; a brick without unmasked samples gets
 * `otherwise`. Errors: MEMORY, CANCELLED. */
int cvol_mask_fill(cvol_context *context, void *out, const void *samples, const cvol_grid *grid,
                   const cvol_mask *mask, size_t first, size_t end, double otherwise);

#endif
