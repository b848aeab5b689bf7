/* Weights of the coefficients of a cell, one row of 16 at a time. Every instruction set gives the
 * same bits. */
#include "array/block/cell_weight.h"

#include "base/cpu.h"
#include "base/vector.h"

enum { SIDE = 16, VECTORS = SIDE / CVOL_LANES };

void CVOL_SIMD(cvol_cell_weights)(float weights[8], const float *coefficients, float inverse);

/* cvol_cell_weight of each lane. */
CVOL_INLINE cvol_vf weights_of(cvol_vf coefficients, float inverse)
{
    const cvol_vf scaled = coefficients * inverse, square = scaled * scaled, power = square + 1;
    const cvol_vi bits = (cvol_vi)power - CVOL_WEIGHT_ONE;
    return cvol_min(square, CVOL_WEIGHT_KEPT + CVOL_WEIGHT_BIT * cvol_to_float(bits));
}

void CVOL_SIMD(cvol_cell_weights)(float weights[8], const float *coefficients, float inverse)
{
    for (int parity = 0; parity < 4; parity++) {
        cvol_vf sums[VECTORS] = {{0}};
        float lanes[SIDE];
        for (int w = parity >> 1; w < SIDE; w += 2)
            for (int v = parity & 1; v < SIDE; v += 2)
                for (int k = 0; k < VECTORS; k++)
                    sums[k] += weights_of(
                        cvol_load(coefficients + SIDE * (v + SIDE * w) + k * CVOL_LANES), inverse);
        memcpy(lanes, sums, sizeof lanes);
        weights[2 * parity] = weights[2 * parity + 1] = 0;
        for (int u = 0; u < SIDE; u++)
            weights[2 * parity + (u & 1)] += lanes[u];
    }
}
