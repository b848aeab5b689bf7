/* Chooses a sub-block's indices under trellis quantization (trellis_states.h): the path through the
 * states with the least error plus lambda times bits (Viterbi 1967).
 *
 * The cost of a token depends on earlier magnitudes, which differ between paths. All paths use the
 * contexts of the path that is best so far. */
#ifndef CVOL_CODEC_QUANTIZE_TRELLIS_H
#define CVOL_CODEC_QUANTIZE_TRELLIS_H

#include "codec/quantize/rd_choice.h"

/* The weight of a bit, in squares of twice the step. */
#define CVOL_LAMBDA_TRELLIS 0.075f

/* One thread's memory. */
typedef struct cvol_trellis cvol_trellis;
cvol_trellis *cvol_trellis_create(void);
void cvol_trellis_free(cvol_trellis *trellis);

/* Chooses indices[0 .. used) for coefficients in scan order, divided by twice the step, of
 * sub-blocks in cells of 16^3. Errors and costs are in squares of twice the step. Otherwise as
 * cvol_sub_block_choose. */
cvol_sub_block_choice cvol_trellis_choose(cvol_trellis *trellis, int32_t *indices,
                                          const float *scaled, const cvol_scan *scan,
                                          const cvol_token_costs *costs,
                                          const cvol_sub_block_context *context, uint16_t *scatter);

#endif
