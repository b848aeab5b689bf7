/* One pass over a cell that the volume ends in (true_length.h). */
#ifndef CVOL_CODEC_QUANTIZE_TRUE_LENGTH_KERNEL_H
#define CVOL_CODEC_QUANTIZE_TRUE_LENGTH_KERNEL_H

#include <stdint.h>

#include "transform/cell.h"

/* How an axis of a cell is divided: whole, or in halves that are eights or fours. */
enum {
    CVOL_TRUE_LENGTH_WHOLE,
    CVOL_TRUE_LENGTH_HALVES,
    CVOL_TRUE_LENGTH_WAYS = CVOL_TRUE_LENGTH_HALVES + 4
};

/* How far beyond a half numbers are rounded away from 0. */
#define CVOL_TRUE_LENGTH_BESIDE_HALF 0x1p-10

typedef struct cvol_true_length_matrix {
    double of[CVOL_CELL][CVOL_CELL] __attribute__((aligned(64))); /* [from][to], by place */
} cvol_true_length_matrix;

/* Kernel of the same bits from every instruction set:
 *
 * void cvol_true_length_axes(double *cell, uint16_t rows[16], const int inside[3], uint16_t split,
 *                          const cvol_true_length_matrix *matrices)
 *   transforms along the axes with inside[] < 16, by matrices[CVOL_TRUE_LENGTH_WAYS inside + way].
 * rows: bit v of rows[w] says that row (v, w) along x need not be zero, before and after; others
 * are not read.
 *
 * int cvol_true_length_round(int32_t *values, uint64_t *found, const double *cell,
 *                          const uint16_t rows[16])
 *   the nearest integers to what is 2^-10 nearer to 0, of those rows, and which are not 0; 0 if
 * one is beyond CVOL_VALUE_LIMIT. Other rows of both stay as they are. */

#endif
