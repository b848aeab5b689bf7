/* Which shape of bricks a compression uses. */
#ifndef CVOL_CODEC_RATE_BRICK_CHOICE_H
#define CVOL_CODEC_RATE_BRICK_CHOICE_H

#include "array/core/array.h"
#include "codec/quantize/coding.h"
#include "cvol/codec.h"

/* What a compression asks for, or, where it says nothing, what suits the volume: planes of large
 * files that are made to a size (a ratio, bits a sample) need less than an eighth of the bricks as
 * long as bricks hold 2 kB; all others have the usual ones. The grid's and the options' values are
 * checked. */
cvol_brick_shape cvol_brick_shape_choose(const cvol_grid *grid,
                                         const cvol_compress_options *options);
#endif
