/* The background: the most frequent sample value, if it lies behind sharp edges, such as the air
 * around a skull-stripped brain. A mask stores it exactly, and the edges need no terms.
 * cvol_background_fills searches for it. A mask pays if the value holds a twentieth of all samples,
 * if the steps to it are at least three times the steps between other samples (root mean squares),
 * and if the faces between background and other samples number at most a tenth of all samples.
 * Noisy backgrounds almost never pass this test. If one passes, a mask halves the bytes. With
 * quantizer steps below a sixteenth of the steps between other samples, a mask no longer pays: the
 * filled-in background then takes the bits that the edges took. */
#ifndef CVOL_CODEC_RATE_BACKGROUND_H
#define CVOL_CODEC_RATE_BACKGROUND_H

#include "array/core/mask.h"
#include "cvol/codec.h"

/* Finds the background's fills that the options ask for; fills->count is 0 if there is none. With a
 * quantizer step below *least_step, a mask saves no bytes. Errors: ARGUMENT (a value that the type
 * cannot hold), MEMORY. */
int cvol_background_fills(cvol_context *context, cvol_fills *fills, double *least_step,
                          const void *samples, const cvol_grid *grid,
                          const cvol_compress_options *options);

#endif
