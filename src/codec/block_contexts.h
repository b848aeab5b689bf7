/* The arithmetic of contexts, for the coder and for those who ask what it would spend. */
#ifndef CVOL_CODEC_BLOCK_CONTEXTS_H
#define CVOL_CODEC_BLOCK_CONTEXTS_H

#include "codec/block_model.h"

CVOL_INLINE int cvol_bit_length(uint32_t value)
{
    return 32 - __builtin_clz(value);
}

/* The class of a scattered sum. */
CVOL_INLINE int cvol_level_of(const uint8_t *table, uint32_t sum)
{
    if (__builtin_expect(sum < CVOL_LEVEL_TABLE, 1))
        return table[sum];
    return 17 + (sum > 1600) + (sum > 3200) + (sum > 6400) + (sum > 12800);
}

/* Adds a magnitude to the nine neighbours that come later. `at` is the coefficient's place among
 * the sums, `row` and `sheet` the strides there. */
CVOL_INLINE void cvol_scatter(uint16_t *at, int row, int sheet, uint32_t magnitude)
{
    uint16_t once = (uint16_t)(magnitude < CVOL_SCATTER_LIMIT ? magnitude : CVOL_SCATTER_LIMIT);
    uint16_t twice = (uint16_t)(2 * once);
    at[1] = (uint16_t)(at[1] + twice);
    at[row] = (uint16_t)(at[row] + twice);
    at[sheet] = (uint16_t)(at[sheet] + twice);
    at[2] = (uint16_t)(at[2] + once);
    at[2 * row] = (uint16_t)(at[2 * row] + once);
    at[2 * sheet] = (uint16_t)(at[2 * sheet] + once);
    at[1 + row] = (uint16_t)(at[1 + row] + once);
    at[1 + sheet] = (uint16_t)(at[1 + sheet] + once);
    at[row + sheet] = (uint16_t)(at[row + sheet] + once);
}

CVOL_INLINE uint32_t cvol_magnitude(int32_t value)
{
    return value < 0 ? (uint32_t)-value : (uint32_t)value;
}

/* The DC tells little of the rest: it counts as 2 at most. */
CVOL_INLINE void cvol_scatter_dc(uint16_t *sums, int row, int sheet, int32_t dc)
{
    uint32_t magnitude = cvol_magnitude(dc);
    cvol_scatter(sums, row, sheet, magnitude < 2 ? magnitude : 2);
}

#endif
