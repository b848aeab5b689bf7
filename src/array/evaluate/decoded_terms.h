/* The terms of what an array with residual decodes to.
 *
 * The terms of a lossless file, or of one with a largest error, are only as fine as makes the file
 * smallest: residual (residual.h) do the rest. Pictures and operations, which are on terms,
 * would show and compute something else than the samples. So the decoded samples are transformed
 * again, once, when they are first needed, and the result stays with the array. */
#ifndef CVOL_ARRAY_EVALUATE_DECODED_TERMS_H
#define CVOL_ARRAY_EVALUATE_DECODED_TERMS_H

#include "array/core/array.h"

/* *out: the array itself where its terms are all that there is, or are nearly as fine as its
 * decoded ones would be; else the decoded terms, in blocks of the same size, not lapped, with the
 * array's mask. They are the array's. Their bound includes what the array's samples may be wrong
 * by. May be called by several threads. Cost: the samples in memory, decoded and transformed once.
 * Errors: DATA, MEMORY, CANCELLED. */
int cvol_array_decoded_terms(cvol_context *context, const cvol_array **out,
                             const cvol_array *array);
/* A box of an array with residual, in the grid's type; masked samples are some value within the
 * range. Errors: those of the residual. */
int cvol_array_decoded_samples(cvol_context *context, void *out, const cvol_array *array,
                               const size_t begin[3], const size_t end[3]);
#endif
