/* Masks of results (array/core/mask.h), from the masks of the operands.
 *
 * A sample of a result that has no value in an operand has no value. A sample that is background in
 * both operands is background of the result. Behind the background, the terms of an operand hold
 * values that continue the other samples smoothly. So the operation can use these terms wherever
 * the result is background too. Elsewhere it must first replace them by the background's value:
 * there the operand's own mask holds, less the mask of the result. */
#ifndef CVOL_ARRAY_ALGEBRA_RESULT_MASK_H
#define CVOL_ARRAY_ALGEBRA_RESULT_MASK_H

#include "array/core/array.h"

/* The mask of alpha a + beta, as out's. Errors: MEMORY. */
int cvol_result_mask_scale(cvol_context *context, cvol_array *out, const cvol_array *a,
                           double alpha, double beta);

/* The mask of a filter's result: samples without a value stay so. Samples whose neighbours up to
 * `radius` along each axis are all background are background, with its value times `factor`, the
 * filter's response to a constant 1. The other background becomes samples like others. Errors:
 * MEMORY. */
int cvol_result_mask_filter(cvol_context *context, cvol_array *out, const cvol_array *a,
                            const size_t radius[3], double factor);

/* The mask of half or twice the samples: a sample has a value if all samples that it is made of
 * have one. There is no background. Errors: MEMORY. */
int cvol_result_mask_resample(cvol_context *context, cvol_array *out, const cvol_array *a);

/* Two operands, and where their background must be replaced. */
typedef struct cvol_masked_operands {
    cvol_array a, b;     /* shallow copies, whose masks are these; not to be freed */
    cvol_mask *masks[2]; /* or NULL: nowhere */
} cvol_masked_operands;

/* The mask of a sum or product, as out's; `value`: of its background. In a product, a background of
 * zero stays, whatever the other operand has. Errors: MEMORY. */
int cvol_result_mask_combine(cvol_context *context, cvol_array *out, cvol_masked_operands *operands,
                             const cvol_array *a, const cvol_array *b, int is_product,
                             double value);
void cvol_masked_operands_free(cvol_masked_operands *operands);

/* Returns 1 if background must be replaced in block `index` or up to `margin` samples around it. */
int cvol_masked_operands_differ(const cvol_masked_operands *operands, size_t index, size_t margin);

#endif
