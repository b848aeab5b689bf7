/* Samples of floats that lie far outside of the range of nearly all others. */
#ifndef CVOL_CODEC_RATE_OUTLIERS_H
#define CVOL_CODEC_RATE_OUTLIERS_H

#include "cvol/base.h"

/* A base that residual are added to need not follow outliers: one of them makes large terms at
 * all frequencies of its cell, where a correction takes a few bytes. *clamped: a copy of the
 * samples with outliers moved to the nearest value that is none; NULL where there are none, where
 * they are more than one sample of 1024, or where the type is one of integers. The caller frees it.
 * Errors: MEMORY. */
int cvol_outliers_clamp(cvol_context *context, void **clamped, const void *samples,
                        const cvol_grid *grid);
/* Whether samples are NaN, and none is infinite. */
int cvol_samples_nan_alone(const void *samples, const cvol_grid *grid);

#endif
