/* What operations on blocks keep when nothing is said: as coarse as what the inputs have lost comes
 * out of the operation; to keep more is to keep noise.
 *
 * What an input has lost is taken for white noise, which the operation multiplies by a weight:
 *
 *     add       |alpha|, |beta|
 *     multiply  the root mean square of the other operand, where it is loud
 *     filter    the L2 norm of its taps
 *
 * The input whose l2_error times its weight is the larger one decides: its step (the codec's
 * arrays, threshold 0, which are quantized and nothing else: STEP) or its threshold (THRESHOLD),
 * times its weight. Inputs without terms say nothing. The steps are never so fine that a result
 * could not be held.
 */
#ifndef CVOL_ARRAY_TRUNCATE_BLOCKS_KEEP_H
#define CVOL_ARRAY_TRUNCATE_BLOCKS_KEEP_H

#include "array/core/array.h"

/* Each gives *keep itself unless its rule is LIKE_INPUTS. out->error_bound.max_abs must be set. */
cvol_keep cvol_blocks_keep_for_add(const cvol_array *out, const cvol_keep *keep, double alpha,
                                   const cvol_array *a, double beta, const cvol_array *b);
cvol_keep cvol_blocks_keep_for_multiply(const cvol_array *out, const cvol_keep *keep,
                                        const cvol_array *a, const cvol_array *b);
cvol_keep cvol_blocks_keep_for_filter(const cvol_array *out, const cvol_keep *keep, double gain,
                                      const cvol_array *a);

/* Sets out->error_bound to what is expected of the result, unless the caller already has: the
 * builder takes its step from it. */
void cvol_blocks_expect(cvol_array *out, cvol_error_bound error_bound);

#endif
