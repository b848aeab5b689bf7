/* Valid shapes of bricks, and the number of bricks that share a checksum. */
#ifndef CVOL_CODEC_BRICK_BRICK_SHAPE_H
#define CVOL_CODEC_BRICK_BRICK_SHAPE_H

#include "array/core/array.h"
#include "codec/quantize/coding.h"
#include "cvol/codec.h"

/* Bricks of these sides; 0, 0, 0: the usual ones. Unusual bricks are runs of one, so that a reader
 * of one brick reads no other. */
cvol_brick_shape cvol_brick_shape_make(const int side[3]);
/* True for the shape of files that do not state it: 64^3, in runs of 16. */
int cvol_brick_shape_is_usual(const cvol_brick_shape *brick);

/* True if bricks of blocks of side B may have that side: 16, 32, 48 or 64, and a multiple of B. */
int cvol_brick_side_is_valid(uint64_t side, int block);
/* Rejects invalid sides; all 0 means none given. Errors: ARGUMENT. */
int cvol_brick_sides_check(cvol_context *context, const int side[3], int block);

#endif
