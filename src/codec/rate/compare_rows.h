/* Kernels that compare a row of samples with what decodes. */
#ifndef CVOL_CODEC_RATE_COMPARE_ROWS_H
#define CVOL_CODEC_RATE_COMPARE_ROWS_H

#include "array/core/samples.h"

/* How far a row's samples are from others. Sums are made of eight, which sample i goes to i mod 8
 * of, and the last count mod 8 samples to the first: the same bits from every instruction set. */
typedef struct cvol_row_distance {
    double most, squares; /* of differences of samples in their own type */
    double real_squares;  /* of those to what decodes, neither rounded nor clamped */
    double real_norms;    /* squares of that itself */
    double real_most;     /* the largest magnitude of that */
} cvol_row_distance;

/* A kernel gets `count` samples of a type, from number `first` on.
 *
 * void cvol_compare_samples(cvol_row_distance *out, const void *samples, size_t first,
 *                           const void *decoded, cvol_type type, size_t count)
 *   sets most and squares: samples against `decoded` of the same type;
 * void cvol_compare_reals(cvol_row_distance *out, const void *samples, size_t first,
 *                         const float *real, double offset, cvol_type type, size_t count)
 *   sets the others: samples against floats plus offset, rounded to float;
 * void cvol_compare_stored(cvol_row_distance *out, const void *samples, size_t first,
 *                          const float *real, size_t count, const cvol_stored_as *as)
 *   sets all: both, with what is stored of these floats. */

#endif
