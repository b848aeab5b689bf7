/* The background: samples of one value behind sharp edges, air around a body that was cut out, say.
 * Kept apart as a mask, they are exact and the edges need no terms.
 *
 * It is looked for: the value that most samples have. It is worth a mask where it holds a twentieth
 * of all samples, where the steps to it are at least three times those between others (root mean
 * squares), and where at most a tenth as many faces as samples lie between the two. On volumes with
 * a noisy background that is hardly ever so; where it is, a mask halves the bytes. It is no longer
 * worth it where steps are so fine that what stands in for the background takes as many bits as the
 * edges did: below a sixteenth of the steps between other samples.
 */
#ifndef CVOL_CODEC_RATE_BACKGROUND_H
#define CVOL_CODEC_RATE_BACKGROUND_H

#include "array/core/mask.h"
#include "cvol/codec.h"

/* The fills of the background that the options ask for; none: fills->count 0. *least_step: with
 * finer ones it is not worth a mask. Errors: ARGUMENT (a value that the type has not), MEMORY. */
int cvol_background_fills(cvol_context *context, cvol_fills *fills, double *least_step,
                          const void *samples, const cvol_grid *grid,
                          const cvol_compress_options *options);

#endif
