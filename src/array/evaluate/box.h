/* Samples of a box of an array. */
#ifndef CVOL_ARRAY_EVALUATE_BOX_H
#define CVOL_ARRAY_EVALUATE_BOX_H

#include "array/core/array.h"

/* Checks a box. Errors: ARGUMENT. */
int cvol_array_check_box(cvol_context *context, const cvol_array *array, const size_t begin[3],
                         const size_t end[3]);
/* The same as cvol_array_evaluate_real, but samples without a value have a finite one, within the
 * range or near it, instead of their fill. */
int cvol_array_evaluate_unmasked(cvol_context *context, float *out, const cvol_array *array,
                                 const size_t begin[3], const size_t end[3]);
/* That less the array's offset: single precision suffices then for values far from 0. */
int cvol_array_evaluate_less_offset(cvol_context *context, float *out, const cvol_array *array,
                                    const size_t begin[3], const size_t end[3]);
/* cvol_array_evaluate_unmasked in double precision: the terms in single precision, and the offset.
 * Arrays with a residual: the decoded samples, exactly. */
int cvol_array_evaluate_doubles(cvol_context *context, double *out, const cvol_array *array,
                                const size_t begin[3], const size_t end[3]);
/* A box of a whole array in the grid's type; arguments checked. */
int cvol_whole_evaluate_stored(cvol_context *context, void *out, const cvol_array *array,
                               const size_t begin[3], const size_t end[3]);
/* Real values of a box; arguments checked. */
int cvol_whole_evaluate(cvol_context *context, float *out, const cvol_array *array,
                        const size_t begin[3], const size_t end[3]);
int cvol_blocks_evaluate(cvol_context *context, float *out, const cvol_array *array,
                         const size_t begin[3], const size_t end[3]);

#endif
