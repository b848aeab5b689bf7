/* Options of a compression: complete, and checked. */
#ifndef CVOL_CODEC_RATE_COMPRESS_OPTIONS_H
#define CVOL_CODEC_RATE_COMPRESS_OPTIONS_H

#include "cvol/codec.h"

/* Copies the options of a caller over the defaults. Errors: ARGUMENT (its size). */
int cvol_compress_options_complete(cvol_context *context, cvol_compress_options *out,
                                   const cvol_compress_options *options);
/* Errors: ARGUMENT, UNSUPPORTED. */
int cvol_compress_options_check(cvol_context *context, const cvol_compress_options *options);

#endif
