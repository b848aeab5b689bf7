/* Chooses the step of a base that gets a residual. */
#ifndef CVOL_CODEC_RATE_RESIDUAL_STEP_H
#define CVOL_CODEC_RATE_RESIDUAL_STEP_H

#include "array/core/mask.h"
#include "cvol/codec.h"

/* The input of the choice. */
typedef struct cvol_residual_step_input {
    const cvol_compress_options *options;
    const cvol_grid *grid;
    const void *samples;     /* filled where they are masked */
    const cvol_mask *mask;   /* NULL: none */
    double bound;            /* of every sample */
    const cvol_array *whole; /* knows the range of all samples */
} cvol_residual_step_input;

/* Finds the step with which base and residual together have about the fewest bytes. */
int cvol_residual_step(cvol_context *context, double *step, const cvol_residual_step_input *input);

#endif
