/* The default truncation of operations on blocks: as coarse as the losses of the inputs, propagated
 * to the result, allow; a finer result would store noise. The builder (build.h) gets the loss that
 * is allowed.
 *
 * The loss of an input is modelled as white noise, which the operation multiplies by a weight:
 *
 *     add       |alpha|, |beta|
 *     multiply  the root mean square of the other operand, where it is not small
 *     filter    the L2 norm of its taps, at least 1
 *
 * The result may lose a fifth of the bound that the inputs carry to it, and half of the noise that
 * this model expects, whichever is less. (A smoothed result is less noisy than its input: its bound
 * decides, or files of smoothed volumes would be larger than their inputs.) A sum whose terms are
 * multiples of one step keeps this step, and loses nothing. */
#ifndef CVOL_ARRAY_TRUNCATE_BLOCKS_KEEP_H
#define CVOL_ARRAY_TRUNCATE_BLOCKS_KEEP_H

#include "array/core/array.h"

/* Each returns *keep itself unless its rule is LIKE_INPUTS. out->error_bound must be the
 * expected one. */
cvol_keep cvol_blocks_keep_for_add(const cvol_array *out, const cvol_keep *keep, double alpha,
                                   const cvol_array *a, double beta, const cvol_array *b);
/* Errors: MEMORY, those of other processes of a team. */
int cvol_blocks_keep_for_multiply(cvol_context *context, cvol_keep *resolved, const cvol_array *out,
                                  const cvol_keep *keep, const cvol_array *a, const cvol_array *b);
cvol_keep cvol_blocks_keep_for_filter(const cvol_array *out, const cvol_keep *keep, double gain,
                                      const cvol_array *a);

/* About the step of the default truncation of a filter's result, with out->error_bound as above. */
double cvol_blocks_filter_step(const cvol_array *out);

/* Sets out->error_bound to the expected bound of the result, unless the caller already has: the
 * builder derives its step from it. */
void cvol_blocks_set_expected_bound(cvol_array *out, cvol_error_bound error_bound);

#endif
