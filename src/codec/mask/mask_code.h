/* Coding of a brick's mask (array/core/mask.h): bits in adaptive contexts (range_coder.h).
 *
 * No bytes: no sample is masked. Else one bit first, what is thought to be beyond the brick's faces
 * where nothing better is known (1: masked). Then for every cell of 16^3, x fastest, whether its
 * samples differ, and if they do not, whether they are masked, in contexts of what the cells before
 * it are. Then the samples of the other cells, row by row of a cell, rows in the brick's order. In
 * a row, a *stretch* is as many samples as have nothing near them in the rows above and before but
 * what the sample on their left is too: one bit tells whether one of them differs (which costs
 * next to nothing if not: most of a cell is no edge). Samples up to the one that differs, and those
 * in no stretch, are a bit each, in the context of a level from mask_predict.h and two neighbours;
 * contexts begin with the probability that the level means.
 *
 * Where there are several fills, the number of its fill follows a masked cell, and a row those of
 * its masked samples: bits from the highest on, in the context of those before and of the fill
 * before.
 */
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

/* A brick's mask by cells, x fastest: as cvol_mask_cell_get gives them. */
typedef struct cvol_mask_brick {
    size_t size[3];
    int fills;
    uint8_t states[CVOL_MASK_BRICK_CELLS][CVOL_MASK_BRICK_CELLS][CVOL_MASK_BRICK_CELLS];
    cvol_mask_rows rows[CVOL_MASK_BRICK_CELLS][CVOL_MASK_BRICK_CELLS][CVOL_MASK_BRICK_CELLS]
                       [CVOL_MASK_PLANES];
} cvol_mask_brick;

/* The bytes replace those of *out; the brick is left as it is. 1, or 0 when memory is short. */
int cvol_mask_encode(cvol_range_encoder *coder, cvol_bytes *out, cvol_mask_brick *brick);
/* size and fills are set; 0 if the bytes say what cannot be. */
int cvol_mask_decode(cvol_mask_brick *brick, cvol_span data);

#endif
