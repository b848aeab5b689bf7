/* Rate-distortion optimised quantisation, greedy (after Karczewicz, Ye and Chong 2008).
 *
 * Each coefficient takes the value m that minimises (|c| / step - m)^2 + lambda bits(m), where
 * bits() is what the coder would spend in its present state; then the block ends where the whole
 * sum is least. At high rates dD/dR = -2 ln 2 D with D = step^2 / 12, so lambda is about 0.115.
 */
#ifndef CVOL_CODEC_RATE_DISTORTION_H
#define CVOL_CODEC_RATE_DISTORTION_H

#include "codec/block_code.h"

#define CVOL_LAMBDA 0.11f

/* Quantises block `place` of the group that `coder` is about to code; results as cvol_quantise.
 * coder->scatter is used and left zero. */
int cvol_quantise_optimally(int32_t *values, const float *coefficients, cvol_block_coder *coder,
                            size_t place, double step);

#endif
