/* Sums the weights of a cell's octants. */
#include "array/block/cell_weight.h"

#include "base/cpu.h"
#include "transform/cell.h"

CVOL_SIMD_DECLARE(void, cvol_cell_weights, (float *, const float *, float));

void cvol_cell_weigh(float weights[8], const float *coefficients, float inverse, int dcs)
{
    CVOL_SIMD_CHOOSE(cvol_cell_weights)(weights, coefficients, inverse);
    for (int w = 0; w < dcs; w++)
        for (int v = 0; v < dcs; v++)
            for (int u = 0; u < dcs; u++)
                weights[(u & 1) + 2 * (v & 1) + 4 * (w & 1)] -= cvol_cell_weight(
                    coefficients[u + CVOL_CELL * (v + CVOL_CELL * w)], inverse);
}
