/* The cells of a result's mask (array/core/mask.h), one after the other. */
#ifndef CVOL_ARRAY_ALGEBRA_MASK_CELLS_H
#define CVOL_ARRAY_ALGEBRA_MASK_CELLS_H

#include <stddef.h>

#include "array/core/array.h"
#include "array/core/mask.h"

enum { CVOL_MASK_CELL_SAMPLES = CVOL_MASK_CELL * CVOL_MASK_CELL * CVOL_MASK_CELL };

/* A cell: its place among the cells, and its samples begin .. end - 1 along each axis. */
typedef struct cvol_mask_place {
    size_t at[3], begin[3], end[3];
} cvol_mask_place;

size_t cvol_mask_place_count(const size_t dims[3]);
cvol_mask_place cvol_mask_place_at(const size_t dims[3], size_t index);
size_t cvol_mask_place_samples(const cvol_mask_place *cell);

/* MEMORY, and a message. */
int cvol_mask_fail_memory(cvol_context *context);

/* The bits of a value as float32, the sample type of results. */
uint64_t cvol_mask_result_bits(double value);
/* The fills of an operand's mask, in the type of results. */
cvol_fills cvol_mask_result_fills(const cvol_array *operand);

#endif
