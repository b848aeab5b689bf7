/* The samples of a block that count: those that reach a sample of the volume that its mask leaves.
 * An error elsewhere is no error of the array, and a block without such samples needs no terms. */
#ifndef CVOL_ARRAY_TRUNCATE_VISIBLE_H
#define CVOL_ARRAY_TRUNCATE_VISIBLE_H

#include "array/core/array.h"

/* visible[i] = 1 if sample i of evaluated block `index` (B^3, before the post-filter) reaches a
 * sample of the volume that is not masked: itself or, in a lapped volume, one that the post-filter
 * makes from it. Returns how many do; if all or none do, it need not set visible. Volumes only. */
size_t cvol_visible_find(uint8_t *visible, const cvol_array *array, size_t index);

/* Upper limits of the errors of visible samples: the squared L2 norm, and the largest. */
typedef struct cvol_visible_error {
    double squares, most;
} cvol_visible_error;

/* Those for errors of the block's coefficients (its split is set), dense; visible may be NULL: all
 * are; samples: room for a block. The post-filter's L2 norm is 1, so `squares` holds behind it,
 * too. */
cvol_visible_error cvol_visible_loss(float *samples, const float *errors, const uint8_t *visible,
                                     const cvol_array *array, size_t index);

#endif
