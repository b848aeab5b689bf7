/* Bricks as boxes of blocks: their place in an array, and the places of sub-blocks in them. */
#ifndef CVOL_CODEC_QUANTIZE_BRICK_BOX_H
#define CVOL_CODEC_QUANTIZE_BRICK_BOX_H

#include "array/core/array.h"
#include "transform/cell.h"

enum { CVOL_SUBBANDS = 4 };

/* The number of bricks along each axis and in total; no brick has a side above CVOL_BRICK_SIDE. */
void cvol_brick_grid(size_t bricks[3], const cvol_array *array);
size_t cvol_brick_count(const cvol_array *array);

/* The blocks of a brick. */
typedef struct cvol_brick_box {
    size_t first[3], count[3]; /* in blocks of the array */
} cvol_brick_box;
cvol_brick_box cvol_brick_box_of(const cvol_array *array, size_t brick);
/* The number of samples of a brick within the volume, along each axis. */
void cvol_brick_inside(size_t size[3], const cvol_array *array, size_t brick);
/* Blocks along each axis, and samples, of a brick that lies within the volume. */
void cvol_brick_shape_blocks(size_t blocks[3], const cvol_array *array);
size_t cvol_brick_volume(const cvol_array *array);
size_t cvol_brick_box_blocks(const cvol_brick_box *box);
/* The array's index of the box' block `i`, x fastest. */
size_t cvol_brick_block_index(const cvol_array *array, const cvol_brick_box *box, size_t i);

/* A byte string. */
typedef struct cvol_span {
    const uint8_t *data;
    size_t size;
} cvol_span;

/* Lists the sub-blocks of a block of side B with this split; returns their number. */
int cvol_block_sub_blocks(cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX], int block, uint16_t split);
/* The begin of a sub-block, in units of four samples of the brick, in block `place` (of x, y,
 * z). */
static inline void cvol_sub_block_place(int at[3], const cvol_sub_block *part,
                                        const size_t place[3], int block)
{
    for (int a = 0; a < 3; a++)
        at[a] = ((int)place[a] * block + part->begin[a]) / 4;
}
/* The place of block `i` within the box. */
static inline void cvol_brick_box_place(size_t place[3], const cvol_brick_box *box, size_t i)
{
    place[0] = i % box->count[0];
    place[1] = i / box->count[0] % box->count[1];
    place[2] = i / box->count[0] / box->count[1];
}

#endif
