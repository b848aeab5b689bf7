/* Questions about the options of a compression. */
#ifndef CVOL_CODEC_RATE_TARGET_H
#define CVOL_CODEC_RATE_TARGET_H

#include "cvol/codec.h"

/* True if the file needs a residual or a mask: for a bound on every sample, lossless compression,
 * or samples without a value. */
static inline int cvol_compress_needs_residual(const cvol_compress_options *options)
{
    return options->lossless || options->max_error > 0 || options->has_fill ||
           options->target == CVOL_TARGET_MAX_ERROR;
}

#endif
