/* Chooses the shape of bricks for a compression. */
#ifndef CVOL_CODEC_RATE_BRICK_CHOICE_H
#define CVOL_CODEC_RATE_BRICK_CHOICE_H

#include "array/core/array.h"
#include "codec/quantize/coding.h"
#include "cvol/codec.h"

/* Returns the shape from the options, or, if they name none, a shape that suits the volume. For
 * large files with a target size (ratio, bits per sample), bricks shrink until a plane needs less
 * than an eighth of them, as long as a brick holds 2 kB. All other files have the usual bricks. The
 * caller has checked the values of grid and options. */
cvol_brick_shape cvol_brick_shape_choose(const cvol_grid *grid,
                                         const cvol_compress_options *options);
#endif
