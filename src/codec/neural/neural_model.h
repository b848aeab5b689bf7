/* Probabilities of magnitudes and signs, from two small neural networks with fixed integer weights
 * (tables/README.md) in integer arithmetic, so that every machine gives the same result.
 *
 * With inputs x[] of -128 .. 127, W and b the trained numbers, and >> rounding down,
 *     h[j] = (b1[j] + sum of W1[j][i] x[i]) >> 11, clamped to 0 .. 255
 *     g[k] = (b2[k] + sum of W2[k][j] h[j]) >> 12, clamped to 0 .. 255
 *     o[t] = (b3[t] + sum of W3[t][k] g[k]) >> 10, clamped to -2047 .. 2047
 * and log(p / (1 - p)) is o / 256. */
#ifndef CVOL_CODEC_NEURAL_NEURAL_MODEL_H
#define CVOL_CODEC_NEURAL_NEURAL_MODEL_H

#include <stdint.h>

#include "codec/entropy/token_tables.h"

enum {
    CVOL_NEURAL_INPUTS = 80,
    CVOL_NEURAL_FIRST = 96,
    CVOL_NEURAL_SECOND = 48,
    CVOL_NEURAL_OUTPUTS = 16,
    CVOL_NEURAL_KINDS = 4, /* of states: even or odd, and first or second four */
    CVOL_NEURAL_ODD = 39,  /* inputs for the kind of state */
    CVOL_NEURAL_LATE = 40,
    CVOL_NEURAL_SIGN_INPUTS = 32,
    CVOL_NEURAL_LOGIT_MAX = 2047
};

typedef struct cvol_neural_network {
    int16_t first[CVOL_NEURAL_FIRST][CVOL_NEURAL_INPUTS];
    int32_t first_bias[CVOL_NEURAL_FIRST];
    int16_t second[CVOL_NEURAL_SECOND][CVOL_NEURAL_FIRST];
    int32_t second_bias[CVOL_NEURAL_SECOND];
    int16_t third[CVOL_NEURAL_OUTPUTS][CVOL_NEURAL_SECOND];
    int32_t third_bias[CVOL_NEURAL_OUTPUTS];
} cvol_neural_network;

/* Network of magnitudes: output t is for a magnitude above t, given that it is not below. */
extern const cvol_neural_network cvol_neural_magnitudes;
/* Codes of rows (token_tables.h) CVOL_NEURAL_ROWS .. CVOL_NEURAL_ROWS_END - 1, for the tokens
 * before the coefficients: the neural coder splits cells more often than the usual coder. */
enum { CVOL_NEURAL_ROWS = CVOL_ROW_DC, CVOL_NEURAL_ROWS_END = CVOL_ROW_RESIDUAL };
extern const uint8_t cvol_neural_rows[CVOL_NEURAL_ROWS_END - CVOL_NEURAL_ROWS][CVOL_TOKEN_CODES];
/* Network of signs: output 0 is for the sign that equals the sign of the faces' summed
 * prediction. */
extern const cvol_neural_network cvol_neural_signs;

#endif
