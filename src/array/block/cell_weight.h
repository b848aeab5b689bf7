/* Estimates the bits of coefficients, for comparing splits of a cell.
 *
 * The weight of a coefficient is its contribution to error plus lambda times bits, in steps
 * squared: its square if it is dropped, or a constant plus log2 of its square, read from the bits
 * of the float and so linear between powers of two. */
#ifndef CVOL_ARRAY_BLOCK_CELL_WEIGHT_H
#define CVOL_ARRAY_BLOCK_CELL_WEIGHT_H

#include <stdint.h>
#include <string.h>

/* The weight of a bit, in steps squared. */
#define CVOL_LAMBDA 0.12f

/* The least cost of a coefficient that is kept, and the cost per unit of a float's bits above the
 * bits of 1. */
#define CVOL_WEIGHT_KEPT 0.6f
#define CVOL_WEIGHT_BIT (CVOL_LAMBDA * 0x1p-23f)
#define CVOL_WEIGHT_ONE INT32_C(0x3f800000)

/* The approximate least number of bits of a split. */
#define CVOL_SPLIT_BITS_MIN 12.0f

/* Costs of a cell's, an octant's and a sub-block's side information. */
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

/* Sums the weights of each octant without its DCs, which are at places below `dcs` on every axis.
 * The parities of a place give its octant. inverse: of the step. */
void cvol_cell_weigh(float weights[8], const float *coefficients, float inverse, int dcs);

#endif
