/* Sums over the terms of a block. */
#ifndef CVOL_ARRAY_BLOCK_BLOCK_SUMS_H
#define CVOL_ARRAY_BLOCK_BLOCK_SUMS_H

#include "array/core/array.h"

/* The sum of squares of the quantized values; the same bits on every processor. */
double cvol_block_squares(const cvol_block *block, int place_bits);
#endif
