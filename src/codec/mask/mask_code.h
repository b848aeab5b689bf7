/* Coding of a brick's mask (array/core/mask.h): bits in adaptive contexts (range_coder.h).
 *
 * No bytes: no sample is masked. Otherwise the first bit is the assumed state beyond the brick's
 * faces if no better value is known (1: masked). Then for every cell of 16^3, x fastest, one bit
 * states that its samples differ, and, if they do not, one bit that they are masked; contexts are
 * the states of earlier cells. Then follow the samples of mixed cells, row by row of a cell, rows
 * in the brick's order. In a row, a *stretch* is a sequence of samples whose neighbours in the rows
 * above and before all equal the sample to their left. One bit states that a sample of the stretch
 * differs; it costs almost nothing if none does, which is the common case away from edges. Samples
 * up to the differing one, and samples outside stretches, are one bit each; the context is a level
 * from mask_predict.h and two neighbours, and starts with the level's probability.
 *
 * If there are several fills, the number of its fill follows a masked cell, and the numbers of its
 * masked samples follow a row: bits from the highest on, in the context of the bits before and of
 * the previous fill. */
#ifndef CVOL_CODEC_MASK_MASK_CODE_H
#define CVOL_CODEC_MASK_MASK_CODE_H

#include "array/core/mask.h"
#include "base/bytes.h"
#include "codec/brick/brick_code.h"
#include "codec/entropy/range_coder.h"

enum {
    CVOL_MASK_BRICK_CELLS = CVOL_BRICK_SIDE / CVOL_MASK_CELL,
    CVOL_MASK_PLANES = 3 /* of CVOL_FILLS_MAX */
};

/* A brick's mask by cells, x fastest, as from cvol_mask_cell_get. */
typedef struct cvol_mask_brick {
    size_t size[3];
    int fills;
    uint8_t states[CVOL_MASK_BRICK_CELLS][CVOL_MASK_BRICK_CELLS][CVOL_MASK_BRICK_CELLS];
    cvol_mask_rows rows[CVOL_MASK_BRICK_CELLS][CVOL_MASK_BRICK_CELLS][CVOL_MASK_BRICK_CELLS]
                       [CVOL_MASK_PLANES];
} cvol_mask_brick;

/* Encodes a brick; the bytes replace the content of *out. Does not change the brick. Returns 1, or
 * 0 when memory is short. */
int cvol_mask_encode(cvol_range_encoder *coder, cvol_bytes *out, cvol_mask_brick *brick);
/* Decodes a brick whose size and fills are set; returns 0 if the bytes are invalid. */
int cvol_mask_decode(cvol_mask_brick *brick, cvol_span data);

#endif
