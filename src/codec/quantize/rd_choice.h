/* Chooses the values of a sub-block's coefficients: greedy rate-distortion optimised quantization.
 *
 * For each coefficient c, in scan order, the encoder chooses among the two nearest magnitudes and 0
 * the value that minimises (c / step - value)^2 + lambda bits; the bits come from the coder's
 * tables in the context of earlier values. Then it chooses the end of the sub-block with the least
 * cost. */
#ifndef CVOL_CODEC_QUANTIZE_RD_CHOICE_H
#define CVOL_CODEC_QUANTIZE_RD_CHOICE_H

#include "array/block/cell_weight.h"
#include "codec/quantize/context.h"
#include "codec/quantize/rd_cost.h"

typedef struct cvol_sub_block_choice {
    int used;    /* one past the last nonzero value, at least 1 */
    float error; /* squared, in steps squared */
    float cost;  /* error plus lambda times bits */
} cvol_sub_block_choice;

/* Chooses values[0 .. used) for coefficients in scan order, divided by the step. `plain`: the
 * nearest values, regardless of bits. scatter: zero on entry and on return. used is 0 if a value
 * would exceed CVOL_VALUE_LIMIT. */
cvol_sub_block_choice cvol_sub_block_choose(int32_t *values, const float *scaled,
                                            const cvol_scan *scan, const cvol_token_costs *costs,
                                            const cvol_sub_block_context *context, int plain,
                                            uint16_t *scatter);

/* Parts of the choice: the DC's value, with *cost and its squared error; a sum of squares. */
int32_t cvol_sub_block_choose_dc(float *cost, float *squared, float scaled,
                                 const cvol_token_costs *costs,
                                 const cvol_sub_block_context *context, int plain);
double cvol_sub_block_squares(const float *c, int begin, int end);

#endif
