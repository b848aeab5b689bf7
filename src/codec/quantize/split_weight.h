/* About how many bits coefficients take, so far as ways of splitting a cell differ by it.
 *
 * A coefficient weighs what it will add to error and lambda bits, in steps squared: its square if
 * it is dropped, or some bits and log2 of its square, as far as a float's bits say that: linear
 * between powers of two. */
#ifndef CVOL_CODEC_QUANTIZE_SPLIT_WEIGHT_H
#define CVOL_CODEC_QUANTIZE_SPLIT_WEIGHT_H

#include <stdint.h>
#include <string.h>

#include "codec/quantize/rd_choice.h"

/* The least that a coefficient costs which is kept, and each bit of a float beyond those of 1. */
#define CVOL_WEIGHT_KEPT 0.6f
#define CVOL_WEIGHT_BIT (CVOL_LAMBDA * 0x1p-23f)
#define CVOL_WEIGHT_ONE INT32_C(0x3f800000)

/* Splitting costs at least about this many bits. */
#define CVOL_SPLIT_BITS_LEAST 12.0f

/* What a cell's or octant's finer parts cost by being many. */
#define CVOL_CELL_COST 3.0f
#define CVOL_OCTANT_COST 2.0f
#define CVOL_SUB_BLOCK_COST 0.7f

static inline float cvol_cell_weight(float coefficient, float inverse)
{
    const float scaled = coefficient * inverse, square = scaled * scaled, power = square + 1;
    int32_t bits;
    memcpy(&bits, &power, sizeof bits);
    const float coded = CVOL_WEIGHT_KEPT + CVOL_WEIGHT_BIT * (float)(bits - CVOL_WEIGHT_ONE);
    return square < coded ? square : coded;
}

/* The sum of each octant's weights but those of its DCs, which are at places below `dcs` on every
 * axis. An octant's places are those of its parities. inverse: of the step. */
void cvol_cell_weigh(float weights[8], const float *coefficients, float inverse, int dcs);

#endif
