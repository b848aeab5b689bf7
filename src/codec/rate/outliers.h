/* Float samples that lie far outside the range of nearly all others. */
#ifndef CVOL_CODEC_RATE_OUTLIERS_H
#define CVOL_CODEC_RATE_OUTLIERS_H

#include "cvol/base.h"

/* A base under a residual need not follow outliers: one outlier makes large terms at all
 * frequencies of its cell, whereas a residual takes a few bytes. *clamped: a copy of the samples
 * with outliers moved to the nearest value in range; NULL if there are no outliers, if more than
 * one sample in 1024 is an outlier, or if the type is an integer type. The caller frees it. Errors:
 * MEMORY. */
int cvol_outliers_clamp(cvol_context *context, void **clamped, const void *samples,
                        const cvol_grid *grid);
/* True if some samples are NaN and no sample is infinite. */
int cvol_samples_nan_alone(const void *samples, const cvol_grid *grid);

#endif
