/* Cells that the volume ends in, as DCTs of their true length (format.md, section 8).
 *
 * Of a part of side M of which n < M samples along an axis are the volume's, a file has the n
 * coefficients of the orthonormal DCT-II of these n samples; of one of which none are, nothing at
 * all. Whoever computes with terms knows DCTs of 16, 8 and 4 only. So in memory the samples go on
 * beyond the end as their cosines do, which mirrors them, and are transformed by M: along that axis
 *
 *     A[u] = sum over k < n, x < M of D_M[u][x] D_n[k][x] c[k]
 *
 * and rounded to a step that is finer by 2^bits; others are multiplied by 2^bits. What nobody sees
 * drops out again on the way back,
 *
 *     c[k] = sum over x < n, u < M of D_n[k][x] D_M[u][x] A[u],
 *
 * which is the inverse, whatever A says beyond the end: rows are no longer than 1, so rounding of A
 * stays small. All of it is the identity along axes that do not end.
 */
#ifndef CVOL_CODEC_QUANTIZE_TRUE_LENGTH_H
#define CVOL_CODEC_QUANTIZE_TRUE_LENGTH_H

#include <stddef.h>
#include <stdint.h>

#include "codec/entropy/scan.h"
#include "transform/cell.h"

/* What the encoder makes of it, and the most there may be in a file. */
enum { CVOL_TRUE_LENGTH_BITS = 2, CVOL_TRUE_LENGTH_BITS_MOST = 8 };

/* Coefficients of a cell of which inside[] samples are the volume's, by place, from one of both to
 * the other. */
void cvol_true_length_to_terms(double cell[CVOL_CELL_SAMPLES], const int inside[3], uint16_t split);
void cvol_true_length_from_terms(double cell[CVOL_CELL_SAMPLES], const int inside[3],
                                 uint16_t split);

/* As cvol_cell_forward: what a file has of such a cell, whatever its samples are beyond. */
void cvol_true_length_forward(float *coefficients, const float *samples, const int inside[3],
                              uint16_t split);

/* From what a file codes to terms, and back. found: a bit for every value that is not 0; inside
 * NULL: the volume does not end in the cell. 0 if a value would be beyond CVOL_VALUE_LIMIT. */
int cvol_true_length_take(int32_t values[CVOL_CELL_SAMPLES], uint64_t found[CVOL_CELL_SAMPLES / 64],
                          const int *inside, uint16_t split, int bits);
/* 0 if these are not the terms of anything that a file could code; what is in parts that nobody
 * sees does not matter. */
int cvol_true_length_put(int32_t values[CVOL_CELL_SAMPLES], const int *inside, uint16_t split,
                         int bits);

/* The scans of a volume's ended parts. */
typedef struct cvol_true_length_scans {
    int left[3];            /* samples of the last cell along each axis; 0: not made yet */
    cvol_scan *scans[3][8]; /* by size class and by axes that end; NULL where there are none */
} cvol_true_length_scans;
/* Makes them for a volume, if they are not made yet; 0 when memory is short. */
int cvol_true_length_scans_make(cvol_true_length_scans *ends, const size_t dims[3]);
void cvol_true_length_scans_clear(cvol_true_length_scans *ends);

#endif
