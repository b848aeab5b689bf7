/* The neural coder's arithmetic, entirely in integers. Results beyond 32 bits wrap around, in the
 * same way in every instruction set: they are only predictions. */
#ifndef CVOL_CODEC_NEURAL_NEURAL_KERNELS_H
#define CVOL_CODEC_NEURAL_NEURAL_KERNELS_H

#include <stdint.h>

#include "base/cpu.h"
#include "base/vector.h"
#include "codec/neural/neural_model.h"

/* 2^10 D, by the number of samples, frequency and sample; 0 beyond them. */
typedef struct cvol_neural_basis {
    int32_t of[17][16][16];
} cvol_neural_basis;

/* A network's weights by pairs of inputs, in the order of vector multiplications of units. */
typedef struct cvol_neural_pairs {
    int16_t first[CVOL_NEURAL_INPUTS / 2][CVOL_NEURAL_FIRST][2];
    int16_t second[CVOL_NEURAL_FIRST / 2][CVOL_NEURAL_SECOND][2];
    int16_t third[CVOL_NEURAL_SECOND / 2][CVOL_NEURAL_OUTPUTS][2];
    int32_t first_bias[CVOL_NEURAL_FIRST], second_bias[CVOL_NEURAL_SECOND],
        third_bias[CVOL_NEURAL_OUTPUTS];
} __attribute__((aligned(64))) cvol_neural_pairs;

/* Kernels; every instruction set gives the same numbers:
 * void cvol_neural_evaluate(int16_t out[], const cvol_neural_pairs *network, const int16_t *x,
 *                           int inputs)
 *   all outputs (neural_model.h);
 * void cvol_neural_evaluate_kinds(int16_t out[][], const cvol_neural_pairs *network, int16_t *x)
 *   the outputs of all kinds of states; x keeps the inputs of the last kind;
 * void cvol_neural_inverse(int32_t *samples, const int32_t *known, const int n[3], int cube, basis)
 *   a sub-block's samples in sixteenths, from its frequencies below cube;
 * void cvol_neural_face(int32_t *level, int32_t *slope, const int32_t *near, const int32_t *far,
 *                       const int stride[2], const int n[2], basis)
 *   the DCT of the plane near, times 2^8, and the DCT of near minus far. */

/* Subtracts the known value at frequency at[] from the faces' predictions. In 2^-12. */
CVOL_INLINE void cvol_neural_subtract_known(int32_t level[6][256], int32_t slope[6][256],
                                            const uint8_t n[3], const int at[3], int32_t value,
                                            const cvol_neural_basis *basis)
{
    for (int a = 0; a < 3; a++) {
        const int other = a == 0   ? at[1] + 16 * at[2]
                          : a == 1 ? at[0] + 16 * at[2]
                                   : at[0] + 16 * at[1];
        const int32_t *wave = basis->of[n[a]][at[a]];
        const uint32_t own = 4 * (uint32_t)value, turn = at[a] & 1 ? UINT32_MAX : 1;
        const uint32_t edge = own * (uint32_t)wave[0];
        const uint32_t inner = n[a] > 1 ? own * (uint32_t)(wave[1] - wave[0]) : 0;
        level[a][other] = (int32_t)((uint32_t)level[a][other] - edge);
        slope[a][other] = (int32_t)((uint32_t)slope[a][other] - inner);
        level[3 + a][other] = (int32_t)((uint32_t)level[3 + a][other] - turn * edge);
        slope[3 + a][other] = (int32_t)((uint32_t)slope[3 + a][other] - turn * inner);
    }
}

#endif
