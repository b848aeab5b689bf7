/* Bricks of cells from dense samples: what the forward transform of each cell is handed. */
#ifndef CVOL_ARRAY_BLOCK_BRICK_H
#define CVOL_ARRAY_BLOCK_BRICK_H

#include "array/core/array.h"

/* Sheets first_sheet .. first_sheet + sheets - 1 of a volume of any type, sample (0, 0,
 * first_sheet) first. */
typedef struct cvol_slab {
    const void *samples;
    size_t first_sheet, sheets;
} cvol_slab;

/* The floats of scratch that a brick of this many cells needs. */
size_t cvol_brick_scratch(const cvol_array *shape, const size_t cells_count[3]);

/* Reads cells_count cells from first_cell on, all of them cells of `shape`, as floats minus
 * shape->offset: cell after cell (x fastest), each of cvol_array_block_terms(shape) floats. If
 * shape is lapped they are pre-filtered, with the same bits as if the whole volume had been. Beyond
 * the volume's end the last sample, filtered, is repeated. The slab needs to have the cells' own
 * sheets and, if lapped, two more at either end, as far as these are the volume's. Both outputs are
 * 64-byte aligned; one thread. */
void cvol_brick_gather(float *cells, float *scratch, const cvol_slab *slab, const cvol_array *shape,
                       const size_t first_cell[3], const size_t cells_count[3]);

#endif
