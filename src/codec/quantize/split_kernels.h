/* Kernels on the coefficients of a cell of 16^3, by place (transform/cell.h). */
#ifndef CVOL_CODEC_QUANTIZE_SPLIT_KERNELS_H
#define CVOL_CODEC_QUANTIZE_SPLIT_KERNELS_H

#include <stdint.h>

/* How coefficients become values: magnitudes are floor(|c| / step + up), but 0 where |c| / step is
 * below low + alone / (1 + n), n the sum of the magnitudes / step of the three places `apart`
 * before it along an axis (1 where there is none). */
typedef struct cvol_cell_rounding {
    float inverse; /* of the step */
    float up, low, alone;
    int apart;
} cvol_cell_rounding;

/* What came of them. */
typedef struct cvol_cell_quantised {
    int32_t values[16 * 16 * 16] __attribute__((aligned(64)));
    uint64_t found[64]; /* a bit for every place whose value is not 0 */
    double error;       /* squared, in steps squared */
    float most;         /* the largest magnitude; values are worthless where that is not below
                           CVOL_VALUE_LIMIT - 256 */
} cvol_cell_quantised;

/* Kernels of the same bits from every instruction set:
 *
 * void cvol_cell_weights(float weights[8], const float *coefficients, float inverse)
 *   each octant's sum of cvol_cell_weight (split_weight.h);
 * void cvol_cell_quantize(cvol_cell_quantized *out, const float *coefficients,
 *                         const cvol_cell_rounding *how) */

#endif
