/* Chooses if a result is lapped, whose producer can make both (result_block.h).
 *
 * A lapped transform takes fewer bits for smooth samples, and more for sharp edges. The choice
 * compares the weights of the coefficients (array/block/cell_weight.h) of some blocks, at the step
 * that is expected. */
#ifndef CVOL_ARRAY_TRUNCATE_RESULT_LAP_H
#define CVOL_ARRAY_TRUNCATE_RESULT_LAP_H

#include "array/core/array.h"
#include "array/truncate/producer.h"

/* Returns 1 if arrays of this shape can be lapped. */
int cvol_result_may_lap(const cvol_array *shape);

/* Sets shape->lapped, which the producer must obey; its scratch must suffice for a lapped shape.
 * Rules other than CVOL_KEEP_LOSS, and shapes that cannot be lapped, take `otherwise`. Errors:
 * MEMORY, the producer's. */
int cvol_result_choose_lap(cvol_context *context, cvol_array *shape, const cvol_producer *producer,
                           const cvol_keep *keep, int otherwise);

#endif
