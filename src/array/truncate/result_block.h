/* Blocks of a result from its samples, for producers: pads, pre-filters (lapped results), splits
 * and transforms.
 *
 * A block of 16^3 is split as the fast encoder splits it (codec/quantize/split_fast.h), by the
 * weights of coefficients at the step that the builder expects. */
#ifndef CVOL_ARRAY_TRUNCATE_RESULT_BLOCK_H
#define CVOL_ARRAY_TRUNCATE_RESULT_BLOCK_H

#include "array/core/array.h"
#include "array/truncate/producer.h"

/* The box of samples from which block `index` is made: the block, and with a lapped shape two
 * samples on either side, which may lie beyond the volume. Returns the number of samples. */
size_t cvol_result_box(ptrdiff_t begin[3], size_t size[3], const cvol_array *shape, size_t index);
/* The most samples of such a box, a multiple of 16. */
size_t cvol_result_box_room(const cvol_array *shape);
/* Floats of scratch for the other functions, a multiple of 16. */
size_t cvol_result_scratch(const cvol_array *shape);

/* About the step of quantization that loses this L2 norm, before any coefficient is known. */
double cvol_result_expected_step(const cvol_array *shape, double loss);

/* Makes *out from the samples of the box, without the offset; overwrites them. Sets max_abs.
 * Samples and scratch are 64-byte aligned. */
void cvol_result_put(cvol_dense_block *out, float *samples, float *scratch, const cvol_array *shape,
                     size_t index);
/* Makes *out from the block's samples, padded, and pre-filtered in a lapped shape. */
void cvol_result_transform(cvol_dense_block *out, const float *samples, float *scratch,
                           const cvol_array *shape);

#endif
