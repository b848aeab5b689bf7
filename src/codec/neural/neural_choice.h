/* Chooses a brick's indices again for the neural coder, with bits from its networks. The first
 * choice (trellis.h) used the tables, which have less context.
 *
 * It walks through the brick in coding order and records the costs of each coefficient's four
 * nearest indices in each kind of state, and of its sign. Then each sub-block takes the path
 * through the states with the least error plus lambda times bits. Contexts come from the previous
 * choice, so there are two rounds. */
#ifndef CVOL_CODEC_NEURAL_NEURAL_CHOICE_H
#define CVOL_CODEC_NEURAL_NEURAL_CHOICE_H

#include "codec/neural/neural_code.h"
#include "codec/quantize/rd_cost.h"

/* The memory for one brick. */
typedef struct cvol_neural_chooser cvol_neural_chooser;
cvol_neural_chooser *cvol_neural_chooser_create(void);
void cvol_neural_chooser_free(cvol_neural_chooser *chooser);

/* Keeps a sub-block's coefficients, divided by twice the step, in scan order. values: the place of
 * its indices in the brick. */
void cvol_neural_chooser_keep(cvol_neural_chooser *chooser, int values, const float *scaled,
                              int count);
/* Chooses for all sub-blocks. costs: of the tokens before the coefficients. Returns the increase of
 * the squared error, in steps squared. */
double cvol_neural_choose_again(cvol_neural_chooser *chooser, cvol_neural_brick *brick,
                                const cvol_token_costs *costs, cvol_brick_context *context);

#endif
