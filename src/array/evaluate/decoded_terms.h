/* The terms of the decoded samples of an array with a residual.
 *
 * The terms of a lossless file, or of one with a largest error, are only as fine as gives the
 * smallest file: the residual (residual.h) corrects them. Pictures and operations work on terms and
 * would ignore the residual. So the decoded samples are transformed again, once, when they are
 * first needed, and the array keeps the result. */
#ifndef CVOL_ARRAY_EVALUATE_DECODED_TERMS_H
#define CVOL_ARRAY_EVALUATE_DECODED_TERMS_H

#include "array/core/array.h"

/* Ranges of samples whose terms fit into single precision. */
#define CVOL_RANGE_LEAST 1e-30
#define CVOL_RANGE_MOST 1e34

/* *out: the array itself if it has no residual, or if its terms are nearly as fine as the decoded
 * ones would be; else the decoded terms, in blocks of the same size, not lapped, with the array's
 * mask. The array owns them. Their bound includes the error of the array's samples. Several threads
 * may call this. Cost: the samples in memory, decoded and transformed once. Errors: DATA, MEMORY,
 * CANCELLED. */
int cvol_array_decoded_terms(cvol_context *context, const cvol_array **out,
                             const cvol_array *array);
/* A box of an array with a residual, in the grid's type; masked samples have some value within the
 * range. Errors: as the residual's evaluation. */
int cvol_array_decoded_samples(cvol_context *context, void *out, const cvol_array *array,
                               const size_t begin[3], const size_t end[3]);
#endif
