/* A whole spectrum for another number of samples: the interpolant of one grid
 * (array/evaluate/interpolant.h) sampled on another grid of the same span, as slots. More samples:
 * zero padding; fewer: frequencies fold (alias) onto the grid's. */
#ifndef CVOL_ARRAY_EVALUATE_FOLD_H
#define CVOL_ARRAY_EVALUATE_FOLD_H

#include "array/core/spectrum.h"

/* Adds the spectrum (of shape `from`), sampled on the grid `to`, to dense slots of shape `to`.
 * Errors: MEMORY. */
int cvol_fold(cvol_context *context, float *slots, const size_t to[3],
              const cvol_spectrum *spectrum, cvol_transform transform, const size_t from[3]);

/* The same into a stored box of slots, like cvol_spectrum's low box: low and box of `to`. Parts
 * outside are lost. */
int cvol_fold_into_box(cvol_context *context, float *slots, const size_t low[3],
                       const size_t box[3], const size_t to[3], const cvol_spectrum *spectrum,
                       cvol_transform transform, const size_t from[3]);

#endif
