/* Which indices a part's coefficients are coded as under trellis quantization (trellis_states.h):
 * the path through the states that makes error and lambda bits least (Viterbi 1967).
 *
 * What a token costs depends on the magnitudes before it, which differ from path to path. All paths
 * take the contexts of the one that is best so far.
 */
#ifndef CVOL_CODEC_QUANTIZE_TRELLIS_H
#define CVOL_CODEC_QUANTIZE_TRELLIS_H

#include "codec/quantize/rd_choice.h"

/* What a bit is worth, in squares of twice the step. */
#define CVOL_LAMBDA_TRELLIS 0.075f

/* One thread's memory. */
typedef struct cvol_trellis cvol_trellis;
cvol_trellis *cvol_trellis_create(void);
void cvol_trellis_free(cvol_trellis *trellis);

/* Chooses indices[0 .. used) for coefficients in scan order, divided by twice the step, of parts in
 * cells of 16^3. Errors and costs are in squares of twice the step. As cvol_sub_block_choose else.
 */
cvol_sub_block_choice cvol_trellis_choose(cvol_trellis *trellis, int32_t *indices,
                                          const float *scaled, const cvol_scan *scan,
                                          const cvol_token_costs *costs,
                                          const cvol_sub_block_context *context, uint16_t *scatter);

#endif
