/* Kernels that compare a row of samples with decoded values. */
#ifndef CVOL_CODEC_RATE_COMPARE_ROWS_H
#define CVOL_CODEC_RATE_COMPARE_ROWS_H

#include "array/core/samples.h"

/* The distance of a row's samples from decoded values. Eight partial sums: sample i goes to sum i
 * mod 8, and the last count mod 8 samples go to the first sum. Every instruction set gives the same
 * bits. */
typedef struct cvol_row_distance {
    double most, squares;            /* of differences in the samples' own type */
    double real_error, real_squares; /* of differences from the decoded values, neither rounded nor
                                        clamped */
    double real_norms;               /* squares of the decoded values */
    double real_most;                /* the largest magnitude of the decoded values */
} cvol_row_distance;

/* A kernel reads `count` samples of a type, from number `first` on.
 * void cvol_compare_samples(cvol_row_distance *out, const void *samples, size_t first,
 *                           const void *decoded, cvol_type type, size_t count)
 *   sets most and squares: samples against `decoded` of the same type;
 * void cvol_compare_reals(cvol_row_distance *out, const void *samples, size_t first,
 *                         const float *real, double offset, cvol_type type, size_t count)
 *   sets the other members: samples against floats plus offset, rounded to float;
 * void cvol_compare_stored(cvol_row_distance *out, const void *samples, size_t first,
 *                          const float *real, size_t count, const cvol_sample_format *as)
 *   sets all members: both comparisons, with the stored form of these floats. */

#endif
