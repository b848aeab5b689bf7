/* What operations on blocks keep when nothing is said: as coarse as what the
 * coarsest input has lost comes out of the operation: to keep more is to keep noise.
 *
 * Inputs that are quantised and nothing else (the codec's: threshold 0) give STEP, others
 * THRESHOLD, each with the largest of the inputs' own times what the operation makes of it:
 *
 *     add       max(|alpha| step_a, |beta| step_b)
 *     multiply  max(max|b| step_a, max|a| step_b)
 *     filter    gain step_a, gain: what it makes of white noise (the L2 norm of its taps)
 *
 * Inputs without terms say nothing. The steps are never so fine that a result could not be held.
 */
#ifndef CVOL_ARRAY_BLOCKS_KEEP_H
#define CVOL_ARRAY_BLOCKS_KEEP_H

#include "array/array.h"

/* Each gives *keep itself unless its rule is LIKE_INPUTS. out->ledger.max_abs must be set. */
cvol_keep cvol_blocks_keep_for_add(const cvol_array *out, const cvol_keep *keep, double alpha,
                                   const cvol_array *a, double beta, const cvol_array *b);
cvol_keep cvol_blocks_keep_for_multiply(const cvol_array *out, const cvol_keep *keep,
                                        const cvol_array *a, const cvol_array *b);
cvol_keep cvol_blocks_keep_for_filter(const cvol_array *out, const cvol_keep *keep, double gain,
                                      const cvol_array *a);

/* Sets out->ledger to what is expected of the result, unless the caller already has: the builder
 * takes its step from it. */
void cvol_blocks_expect(cvol_array *out, cvol_ledger ledger);

#endif
