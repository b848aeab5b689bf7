/* Kernels on the coefficients of a cell of 16^3, by place (transform/cell.h). */
#ifndef CVOL_CODEC_QUANTIZE_SPLIT_KERNELS_H
#define CVOL_CODEC_QUANTIZE_SPLIT_KERNELS_H

#include <stdint.h>

/* Rounding of coefficients: magnitudes are floor(|c| / step + up), but 0 if |c| / step is below low
 * + alone / (1 + n), with n the sum of the magnitudes / step at the three places `apart` before it
 * along an axis (1 for a missing one). */
typedef struct cvol_cell_rounding {
    float inverse; /* of the step */
    float up, low, alone;
    int apart;
} cvol_cell_rounding;

/* The result. */
typedef struct cvol_cell_quantised {
    int32_t values[16 * 16 * 16] __attribute__((aligned(64)));
    uint64_t found[64]; /* a bit for every place with a nonzero value */
    double error;       /* squared, in steps squared */
    float most;         /* the largest magnitude; values are invalid unless it is below
                           CVOL_VALUE_LIMIT - 256 */
} cvol_cell_quantised;

/* Kernels; every instruction set gives the same bits:
 * void cvol_cell_quantise(cvol_cell_quantised *out, const float *coefficients,
 *                         const cvol_cell_rounding *how) */

#endif
