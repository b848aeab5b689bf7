/* Bricks of blocks from dense samples: the input of the forward transform of each block. */
#ifndef CVOL_ARRAY_BLOCK_BRICK_H
#define CVOL_ARRAY_BLOCK_BRICK_H

#include "array/core/array.h"

/* Rows first_row .. first_row + rows - 1 of slices first_slice .. first_slice + slices - 1 of a
 * volume of any type, sample (0, first_row, first_slice) first. */
typedef struct cvol_slab {
    const void *samples;
    size_t first_slice, slices, first_row, rows;
} cvol_slab;

/* A slab of all samples. */
static inline cvol_slab cvol_slab_of(const void *samples, const cvol_grid *grid)
{
    return (cvol_slab){samples, 0, grid->dims[2], 0, grid->dims[1]};
}

/* The number of sample (0, y, z) in a slab of rows of `width` samples. */
static inline size_t cvol_slab_row(const cvol_slab *slab, size_t width, size_t y, size_t z)
{
    return width * (y - slab->first_row + slab->rows * (z - slab->first_slice));
}

/* The floats of scratch for a brick of this size. */
size_t cvol_brick_scratch(const cvol_array *shape, const size_t cells_count[3]);

/* Reads cells_count blocks from first_cell on, all within `shape`, as floats minus shape->offset:
 * block after block (x fastest), each of cvol_array_block_terms(shape) floats. If shape is lapped,
 * they are pre-filtered, with the same bits as for the whole volume. Beyond the volume's end the
 * last filtered sample is repeated. The slab must contain the rows and slices of the blocks and, if
 * lapped, two more at either end where the volume has them. Both outputs are 64-byte aligned; one
 * thread. */
void cvol_brick_gather(float *cells, float *scratch, const cvol_slab *slab, const cvol_array *shape,
                       const size_t first_cell[3], const size_t cells_count[3]);

#endif
