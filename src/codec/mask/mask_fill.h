/* Values for masked samples, so that the transform meets no edge where there is none: each brick of
 * 64^3 by itself, from its samples that are not masked, by push and pull (Gortler and others 1996,
 * "The Lumigraph"): averages of what is known on grids of half the points, and back, from coarse to
 * fine, smoothed where nothing is known. The same values for any number of threads, and slab by
 * slab. */
#ifndef CVOL_CODEC_MASK_MASK_FILL_H
#define CVOL_CODEC_MASK_MASK_FILL_H

#include "array/core/mask.h"
#include "cvol/base.h"

/* Copies sheets [first, end) of a volume; samples and out: sheet `first`, a multiple of 64 (end
 * too, or the volume's). Masked samples are replaced, in bricks without any other by `otherwise`.
 * Errors: MEMORY, CANCELLED. */
int cvol_mask_fill(cvol_context *context, void *out, const void *samples, const cvol_grid *grid,
                   const cvol_mask *mask, size_t first, size_t end, double otherwise);

#endif
