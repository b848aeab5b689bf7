/* Compression with a bound on every sample, without loss, or with samples that have no value.
 * cvol_compress calls it when the options ask for one of these. */
#ifndef CVOL_CODEC_RATE_COMPRESS_RESIDUAL_H
#define CVOL_CODEC_RATE_COMPRESS_RESIDUAL_H

#include "cvol/codec.h"

/* Works as cvol_compress, which has checked the options, but returns a lossy array even if a
 * lossless file were smaller, unless the options ask for lossless. *out is NULL after success if no
 * step reaches the PSNR. report must not be NULL. */
int cvol_compress_residual(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                           const void *samples, const cvol_grid *grid,
                           const cvol_compress_options *options);

#endif
