/* Which indices a brick of the neural coder is coded as, once more: by what its networks say bits
 * cost. First (trellis.h) tables had said it, which know less.
 *
 * The brick is gone through as it is coded. The costs of each coefficient's four nearest indices in
 * each kind of state, and of its sign, are noted, and then each part takes the path through the
 * states that makes error and lambda bits least. What is around a coefficient is taken from what
 * was chosen before; so this is done twice.
 */
#ifndef CVOL_CODEC_NEURAL_NEURAL_CHOICE_H
#define CVOL_CODEC_NEURAL_NEURAL_CHOICE_H

#include "codec/neural/neural_code.h"
#include "codec/quantize/rd_cost.h"

/* One brick's memory for it. */
typedef struct cvol_neural_chooser cvol_neural_chooser;
cvol_neural_chooser *cvol_neural_chooser_create(void);
void cvol_neural_chooser_free(cvol_neural_chooser *chooser);

/* Keeps a part's coefficients, divided by twice the step, in scan order. values: where its indices
 * are in the brick. */
void cvol_neural_chooser_keep(cvol_neural_chooser *chooser, int values, const float *scaled,
                              int count);
/* Chooses for all parts. costs: of what stands before the coefficients. By how much the squared
 * error grows, in steps squared. */
double cvol_neural_choose_again(cvol_neural_chooser *chooser, cvol_neural_brick *brick,
                                const cvol_token_costs *costs, cvol_brick_context *context);

#endif
