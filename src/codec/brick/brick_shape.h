/* Which shapes bricks may have, and how many of them share a checksum. */
#ifndef CVOL_CODEC_BRICK_BRICK_SHAPE_H
#define CVOL_CODEC_BRICK_BRICK_SHAPE_H

#include "array/core/array.h"
#include "codec/quantize/coding.h"
#include "cvol/codec.h"

/* Bricks of these sides; 0, 0, 0: the usual ones. Of others one brick is a run: who wants one reads
 * no other. */
cvol_brick_shape cvol_brick_shape_make(const int side[3]);
/* Whether it is what files have that do not say it: 64^3, in runs of 16. */
int cvol_brick_shape_is_usual(const cvol_brick_shape *brick);

/* Whether bricks of blocks of side B may have that side: 16, 32, 48 or 64, and a multiple of B. */
int cvol_brick_side_is_valid(uint64_t side, int block);
/* Refuses sides that bricks cannot have; all 0 are as good as none. Errors: ARGUMENT. */
int cvol_brick_sides_check(cvol_context *context, const int side[3], int block);

#endif
