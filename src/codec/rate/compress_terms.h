/* Compressing to a ratio, bits a sample or a PSNR by the step of the terms alone: what
 * cvol_compress does unless errors are bounded or samples have no value. */
#ifndef CVOL_CODEC_RATE_COMPRESS_TERMS_H
#define CVOL_CODEC_RATE_COMPRESS_TERMS_H

#include "cvol/codec.h"

/* As cvol_compress, which has checked the options, but lossy whatever a lossless file would take.
 * *out is NULL after success where no step has the PSNR; the report is then not set. */
int cvol_compress_terms(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                        const void *samples, const cvol_grid *grid,
                        const cvol_compress_options *options);

#endif
