/* Kernels for a cell that crosses the volume's end (true_length.h). */
#ifndef CVOL_CODEC_QUANTIZE_TRUE_LENGTH_KERNEL_H
#define CVOL_CODEC_QUANTIZE_TRUE_LENGTH_KERNEL_H

#include <stdint.h>

#include "transform/cell.h"

/* The division of a cell along an axis: whole, or in halves of eights or fours. */
enum {
    CVOL_TRUE_LENGTH_WHOLE,
    CVOL_TRUE_LENGTH_HALVES,
    CVOL_TRUE_LENGTH_WAYS = CVOL_TRUE_LENGTH_HALVES + 4
};

/* The distance from a half at which numbers still round towards 0. */
#define CVOL_TRUE_LENGTH_TIE_MARGIN 0x1p-10

typedef struct cvol_true_length_matrix {
    double of[CVOL_CELL][CVOL_CELL] __attribute__((aligned(64))); /* [from][to], by place */
    uint16_t reached; /* bit u: of[][u] may be nonzero */
} cvol_true_length_matrix;

/* Kernels; every instruction set gives the same bits:
 * void cvol_true_length_axes(double *cell, uint16_t rows[16], const int inside[3], uint16_t split,
 *                            const cvol_true_length_matrix *matrices)
 *   transforms along the axes with inside[] < 16, by matrices[CVOL_TRUE_LENGTH_WAYS inside + way].
 *   rows: bit v of rows[w] marks row (v, w) along x as possibly nonzero, before and after; other
 *   rows are not read. Rows that the matrices do not reach become zero and are not marked.
 * int cvol_true_length_round(int32_t *values, uint64_t *found, const double *cell,
 *                            const uint16_t rows[16])
 *   rounds those rows to integers after moving numbers 2^-10 towards 0, and marks nonzero ones in
 *   found; returns 0 if one exceeds CVOL_VALUE_LIMIT. Other rows of both stay unchanged. */

#endif
