/* True-length DCTs of cells that cross the volume's end (format.md, section 8).
 *
 * If n < M samples of a sub-block of side M along an axis belong to the volume, the file has the n
 * coefficients of the orthonormal DCT-II of these n samples; if n = 0, it has none. Algebra on
 * terms knows only DCTs of 16, 8 and 4. So in memory the samples continue beyond the end as their
 * cosines do, which mirrors them, and have a transform of length M: along that axis
 *     A[u] = sum over k < n, x < M of D_M[u][x] D_n[k][x] c[k]
 * rounded to a step that is finer by 2^bits; coefficients of other cells are multiplied by 2^bits.
 * The way back ignores the padding,
 *     c[k] = sum over x < n, u < M of D_n[k][x] D_M[u][x] A[u],
 * and is the inverse for any A beyond the end. Its rows have norm at most 1, so rounding errors of
 * A stay small. Along axes that do not cross the end both are the identity. */
#ifndef CVOL_CODEC_QUANTIZE_TRUE_LENGTH_H
#define CVOL_CODEC_QUANTIZE_TRUE_LENGTH_H

#include <stddef.h>
#include <stdint.h>

#include "codec/entropy/scan.h"
#include "transform/cell.h"

/* The encoder's number of bits, and the maximum in a file. */
enum { CVOL_TRUE_LENGTH_BITS = 2, CVOL_TRUE_LENGTH_BITS_MAX = 8 };

/* Converts the coefficients of a cell, by place, with inside[] samples in the volume, from file
 * form to terms and back. */
void cvol_true_length_to_terms(double cell[CVOL_CELL_SAMPLES], const int inside[3], uint16_t split);
void cvol_true_length_from_terms(double cell[CVOL_CELL_SAMPLES], const int inside[3],
                                 uint16_t split);

/* Works as cvol_cell_forward, but gives the file form of such a cell, for any samples beyond the
 * end. */
void cvol_true_length_forward(float *coefficients, const float *samples, const int inside[3],
                              uint16_t split);

/* Converts coded values to terms. found: a bit for every nonzero value; inside NULL: the cell does
 * not cross the volume's end. Returns 0 if a value would exceed CVOL_VALUE_LIMIT. */
int cvol_true_length_take(int32_t values[CVOL_CELL_SAMPLES], uint64_t found[CVOL_CELL_SAMPLES / 64],
                          const int *inside, uint16_t split, int bits);
/* The inverse. Returns 0 if no coded values give these terms; ignores sub-blocks in padding. */
int cvol_true_length_put(int32_t values[CVOL_CELL_SAMPLES], const int *inside, uint16_t split,
                         int bits);

/* The scans of the sub-blocks that cross a volume's end. */
typedef struct cvol_true_length_scans {
    int left[3];            /* samples of the last cell along each axis; 0: not made yet */
    cvol_scan *scans[3][8]; /* by size class and by axes that cross the end; NULL if there is no
                               such sub-block */
} cvol_true_length_scans;
/* Makes the scans for a volume, if not made yet; returns 0 when memory is short. */
int cvol_true_length_scans_make(cvol_true_length_scans *ends, const size_t dims[3]);
void cvol_true_length_scans_clear(cvol_true_length_scans *ends);

#endif
