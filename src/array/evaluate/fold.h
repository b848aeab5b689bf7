/* A whole spectrum on another number of samples: the interpolant of one grid
 * (array/evaluate/interpolant.h) sampled on another that shares its span, again in slots. More
 * samples: zeros are put in; fewer: frequencies fold (alias) onto those that the grid holds.
 */
#ifndef CVOL_ARRAY_EVALUATE_FOLD_H
#define CVOL_ARRAY_EVALUATE_FOLD_H

#include "array/core/spectrum.h"

/* Adds to dense slots of the shape `to` what the spectrum (of the shape `from`) sampled there has.
 * Errors: MEMORY. */
int cvol_fold(cvol_context *context, float *slots, const size_t to[3],
              const cvol_spectrum *spectrum, cvol_transform transform, const size_t from[3]);

/* The same into slots of which only a box is stored, as cvol_spectrum's low box is: low and box of
 * `to`. What would lie outside is lost. */
int cvol_fold_into_box(cvol_context *context, float *slots, const size_t low[3],
                       const size_t box[3], const size_t to[3], const cvol_spectrum *spectrum,
                       cvol_transform transform, const size_t from[3]);

#endif
