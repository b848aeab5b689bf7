/* The probability that a sample is masked, from 50 known neighbours: a small neural network with
 * fixed integer weights (tables/README.md) in integer arithmetic, so that every machine gives the
 * same result.
 *
 * With n[k] the neighbours, 1 if masked, one of 16 hidden units i is
 *     h[i] = max(0, bias[i] + sum over k of weight[k][i] n[k]),
 * and log(p / (1 - p)) is about (out_bias + sum over i of out[i] h[i]) / 2^13, rounded to eighths
 * and clamped to -8 .. 8: one of 129 levels. Because n[k] are bits, tables give the sums of weights
 * for whole windows of neighbours in a row. */
#ifndef CVOL_CODEC_MASK_MASK_PREDICT_H
#define CVOL_CODEC_MASK_MASK_PREDICT_H

#include <stdint.h>

#include "base/vector.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

enum {
    CVOL_MASK_NEIGHBOURS = 50,
    CVOL_MASK_HIDDEN = 16,
    CVOL_MASK_WINDOWS = 11,
    CVOL_MASK_LEVELS = 129,
    CVOL_MASK_LEVEL_BITS = 10 /* the sum is divided by 2^this */
};

/* The trained numbers (tables/mask_network.inc): neighbours in order of windows, x fastest. Sums of
 * a unit's weights fit into 16 bits. */
typedef struct cvol_mask_network {
    int16_t weights[CVOL_MASK_NEIGHBOURS][CVOL_MASK_HIDDEN];
    int16_t biases[CVOL_MASK_HIDDEN];
    int16_t outs[CVOL_MASK_HIDDEN] __attribute__((aligned(16)));
    int32_t out_bias;
} cvol_mask_network;
extern const cvol_mask_network cvol_mask_trained;

/* The initial probability of a 0 bit at each level, in units of 2^-16: 1 / (1 + exp((i - 64) / 8)),
 * rounded, at least 71 and at most 65465. */
extern const uint16_t cvol_mask_probabilities[CVOL_MASK_LEVELS];

/* A window: `width` samples of one row, from (dx, dy, dz) relative to the predicted sample. The
 * rows are (-1 .. 1, -2), (-2 .. 2, -1), (-2, 0), (-1, 0), (0, 0) of y and z. */
typedef struct cvol_mask_window {
    int dx, dy, dz, width;
} cvol_mask_window;
extern const cvol_mask_window cvol_mask_windows[CVOL_MASK_WINDOWS];

/* Sums of weights for every content of a window; the sums of the last window include the biases. */
typedef struct cvol_mask_sums {
    int16_t units[CVOL_MASK_HIDDEN];
} __attribute__((aligned(32))) cvol_mask_sums;
enum { CVOL_MASK_SUMS = 3 * 8 + 6 * 32 + 128 + 16 };
/* The sums of all windows in order; static, filled by the first call. */
const cvol_mask_sums *cvol_mask_predictor(void);

typedef int16_t cvol_mask_half __attribute__((vector_size(16), may_alias));

CVOL_INLINE void cvol_mask_add(cvol_mask_half sums[2], const cvol_mask_sums *more)
{
    const cvol_mask_half *halves = (const cvol_mask_half *)more->units;
    sums[0] += halves[0];
    sums[1] += halves[1];
}

/* The network's output from the hidden units' sums, before their cut at 0. */
CVOL_INLINE int32_t cvol_mask_output(const cvol_mask_half sums[2])
{
    const cvol_mask_half *outs = (const cvol_mask_half *)cvol_mask_trained.outs;
    const cvol_mask_half first = sums[0] & (sums[0] > 0), second = sums[1] & (sums[1] > 0);
#if defined(__SSE2__)
    __m128i sum = _mm_add_epi32(_mm_madd_epi16((__m128i)first, (__m128i)outs[0]),
                                _mm_madd_epi16((__m128i)second, (__m128i)outs[1]));
    sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0x4e));
    sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0xb1));
    return cvol_mask_trained.out_bias + _mm_cvtsi128_si32(sum);
#elif defined(__wasm_simd128__)
    v128_t sum = wasm_i32x4_add(wasm_i32x4_dot_i16x8((v128_t)first, (v128_t)outs[0]),
                                wasm_i32x4_dot_i16x8((v128_t)second, (v128_t)outs[1]));
    sum = wasm_i32x4_add(sum, wasm_i32x4_shuffle(sum, sum, 2, 3, 0, 1));
    sum = wasm_i32x4_add(sum, wasm_i32x4_shuffle(sum, sum, 1, 0, 3, 2));
    return cvol_mask_trained.out_bias + wasm_i32x4_extract_lane(sum, 0);
#else
    int32_t sum = cvol_mask_trained.out_bias;
    for (int i = 0; i < CVOL_MASK_HIDDEN / 2; i++)
        sum += first[i] * outs[0][i] + second[i] * outs[1][i];
    return sum;
#endif
}

/* The level of an output: 0 (almost surely not masked) .. 128. */
CVOL_INLINE int cvol_mask_level(int32_t output)
{
    const int most = CVOL_MASK_LEVELS / 2;
    const int level = (output + (1 << (CVOL_MASK_LEVEL_BITS - 1))) >> CVOL_MASK_LEVEL_BITS;
    return (level < -most ? -most : level > most ? most : level) + most;
}

#endif
