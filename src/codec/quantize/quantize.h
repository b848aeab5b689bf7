/* Uniform quantizer:  |q| = floor(|c| / step + 1/2),  c' = q step. */
#ifndef CVOL_CODEC_QUANTIZE_QUANTIZE_H
#define CVOL_CODEC_QUANTIZE_QUANTIZE_H

#include <stdint.h>

/* The largest magnitude that the coder codes. */
#define CVOL_VALUE_LIMIT (INT32_C(1) << 30)

/* Returns one past the last of c[0 .. count) whose magnitude reaches the threshold, at least 1. */
int cvol_quantise_extent(const float *c, int count, float threshold);

/* Returns 1 if all of c[0 .. count) become values within the limit, with a small margin. */
int cvol_quantise_fits(const float *c, int count, double step);

#endif
