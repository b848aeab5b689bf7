/* Compressing with a bound on every sample, without any loss, or with samples that have no value:
 * what cvol_compress does when the options ask for it. */
#ifndef CVOL_CODEC_RATE_COMPRESS_RESIDUAL_H
#define CVOL_CODEC_RATE_COMPRESS_RESIDUAL_H

#include "cvol/codec.h"

/* As cvol_compress, which has checked the options, but lossy whatever a lossless file would take
 * unless that is what they ask for. *out is NULL after success where no step has the PSNR. report
 * must not be NULL. */
int cvol_compress_residual(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                           const void *samples, const cvol_grid *grid,
                           const cvol_compress_options *options);

#endif
