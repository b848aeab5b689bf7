/* Transcoding of arrays with a residual. */
#ifndef CVOL_CODEC_RATE_TRANSCODE_DECODED_H
#define CVOL_CODEC_RATE_TRANSCODE_DECODED_H

#include "cvol/codec.h"

/* Makes a coarser array of one with a residual. Its terms are coarser than its decoded samples, so
 * the decoded samples are compressed. The source's own errors are added to the bound. `target` is a
 * PSNR or a ratio of this value; the other options are the caller's. The caller frees *out. */
int cvol_transcode_decoded(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                           const cvol_array *array, cvol_target target, double value,
                           const cvol_compress_options *options);

#endif
