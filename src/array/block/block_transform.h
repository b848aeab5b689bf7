/* The transform of one block, of any rank and transform: B^rank samples and B^rank slots
 * (transform/whole.h), u or x fastest. Both 64-byte aligned, not overlapping. It does not allocate
 * or lock, so any thread may call it. Same bits on every processor.
 *
 * Rank 3 under DCT: cvol_block_forward. All others: one dense matrix along each axis. Under DHT and
 * DFT that is cas(2 pi u x / B), and
 *     cas(a + b)     = (C(a, b) + C(-a, b) + C(a, -b) - C(-a, -b)) / 2,           C = cas a cas b
 *     cas(a + b + c) = (C(-a, b, c) + C(a, -b, c) + C(a, b, -c) - C(-a, -b, -c)) / 2
 * makes the transform of rank 2 and 3 from the separable one (Bracewell et al. 1986). */
#ifndef CVOL_ARRAY_BLOCK_BLOCK_TRANSFORM_H
#define CVOL_ARRAY_BLOCK_BLOCK_TRANSFORM_H

#include "array/core/array.h"

/* The place with the frequency along the axes of `field` (the place bits of one axis) negated. */
static inline uint32_t cvol_block_mirror(uint32_t place, uint32_t field)
{
    return (0 - (place & field)) & field;
}

/* It reads rank, transform and block of `shape`. */
void cvol_block_to_slots(float *slots, const float *samples, const cvol_array *shape);
/* In place. */
void cvol_block_from_slots(float *data, const cvol_array *shape);

/* The slots of block `index`, zero if there is no term, without the offset. */
void cvol_block_unpack(float *slots, const cvol_array *array, size_t index);

#endif
