/* Which values a part's coefficients are coded as: greedy rate-distortion optimised quantization.
 *
 * Of each coefficient c, in scan order, the value is chosen that makes (c / step - value)^2 +
 * lambda bits least, among the two nearest magnitudes and 0; bits are those of the coder's tables
 * in the context that the values before it make. Then the part ends where it best ends.
 */
#ifndef CVOL_CODEC_QUANTIZE_RD_CHOICE_H
#define CVOL_CODEC_QUANTIZE_RD_CHOICE_H

#include "codec/quantize/context.h"
#include "codec/quantize/rd_cost.h"

/* What a bit is worth, in steps squared. */
#define CVOL_LAMBDA 0.12f

typedef struct cvol_sub_block_choice {
    int used;    /* one past the last value that is not 0, at least 1 */
    float error; /* squared, in steps squared */
    float cost;  /* error and lambda bits together */
} cvol_sub_block_choice;

/* Chooses values[0 .. used) for coefficients in scan order, divided by the step. `plain`: the
 * nearest values, whatever they cost. scatter: all zero, and so again after it. used is 0 where a
 * value would be beyond CVOL_VALUE_LIMIT. */
cvol_sub_block_choice cvol_sub_block_choose(int32_t *values, const float *scaled,
                                            const cvol_scan *scan, const cvol_token_costs *costs,
                                            const cvol_sub_block_context *context, int plain,
                                            uint16_t *scatter);

/* Its parts: the DC's value, with *cost and its squared error; a sum of squares. */
int32_t cvol_sub_block_choose_dc(float *cost, float *squared, float scaled,
                                 const cvol_token_costs *costs,
                                 const cvol_sub_block_context *context, int plain);
double cvol_sub_block_squares(const float *c, int begin, int end);

#endif
