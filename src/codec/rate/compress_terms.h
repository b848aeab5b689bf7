/* Compression to a ratio, bits per sample or a PSNR by the step of the terms alone. cvol_compress
 * calls it unless the options bound errors or some samples have no value. */
#ifndef CVOL_CODEC_RATE_COMPRESS_TERMS_H
#define CVOL_CODEC_RATE_COMPRESS_TERMS_H

#include "cvol/codec.h"

/* Works as cvol_compress, which has checked the options, but returns a lossy array even if a
 * lossless file were smaller. *out is NULL after success if no step reaches the PSNR; the report is
 * then not set. */
int cvol_compress_terms(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                        const void *samples, const cvol_grid *grid,
                        const cvol_compress_options *options);

#endif
