/* Costs in bits of a sub-block's tokens. */
#ifndef CVOL_CODEC_QUANTIZE_RD_COST_H
#define CVOL_CODEC_QUANTIZE_RD_COST_H

#include "codec/quantize/sub_block_code.h"

/* Bits of each token: -log2 of its probability. */
typedef struct cvol_token_costs {
    float of[CVOL_ROWS][CVOL_TOKENS];
    float weight; /* the factor in them */
} cvol_token_costs;
void cvol_token_costs_set(cvol_token_costs *costs, const cvol_token_tables *tables);
/* Multiplies all costs: a larger weight gives coarser choices. */
void cvol_token_costs_weigh(cvol_token_costs *costs, double weight);

/* Bits of a value 0. */
CVOL_INLINE float cvol_bits_of_zero(const cvol_token_costs *costs, cvol_place_code code)
{
    return costs->of[code.row][0] + (float)code.shift;
}

/* Bits of a magnitude >= 1 and its sign. */
CVOL_INLINE float cvol_bits_of_value(const cvol_token_costs *costs, cvol_place_code code,
                                     uint32_t magnitude)
{
    const float *row = costs->of[code.row];
    const uint32_t high = magnitude >> code.shift;
    float bits = 1 + (float)code.shift;
    if (high < 15)
        return bits + row[high];
    const int more = cvol_bit_length(high - 14) - 1;
    bits += row[15] + (float)more + (more < 15 ? 0 : 4);
    return bits + costs->of[code.escape_row][more < 15 ? more : 15];
}

/* Bits of the sign and magnitude of a sub-block's last value. */
CVOL_INLINE float cvol_bits_of_last_value(const cvol_token_costs *costs, cvol_place_code code,
                                          uint32_t magnitude)
{
    if (magnitude == 1)
        return 1 + cvol_bits_of_zero(costs, code);
    return cvol_bits_of_value(costs, code, magnitude - 1);
}

/* Bits of a last index after its bit length. */
CVOL_INLINE float cvol_bits_of_last(const cvol_token_costs *costs, int size_class, uint32_t last)
{
    const int length = cvol_bit_length(last);
    const float *row = costs->of[cvol_more_row(size_class, length)];
    if (length == 1)
        return 0;
    if (length == 2)
        return row[last & 1];
    return row[last >> (length - 3) & 3] + (float)(length - 3);
}

#endif
