/* One trial of compressing with a given step: encode, decode, measure. */
#ifndef CVOL_CODEC_TRIAL_H
#define CVOL_CODEC_TRIAL_H

#include "codec/coefficients.h"
#include "codec/group.h"
#include "cvol/codec.h"

/* The work on one volume. */
typedef struct cvol_trial {
    const void *samples;
    cvol_array *shape; /* grid, block, offset and range of values; no terms */
    cvol_coefficients coefficients;
    int plain; /* round to nearest: errors are least; else squared error at equal bytes is */
    double step;
    cvol_groups groups;   /* of the last step encoded */
    cvol_array *array;    /* of the last step decoded */
    uint64_t begin_bytes; /* of a file before its groups: an estimate until trial_finish */
    int count;            /* encodings so far */
} cvol_trial;

/* Makes shape and coefficients. Errors: those of array creation, DATA, MEMORY, CANCELLED. */
int cvol_trial_start(cvol_context *context, cvol_trial *trial, const void *samples,
                     const cvol_grid *grid, int block);
void cvol_trial_free(cvol_trial *trial);

/* Encodes every stride-th group with this step. Errors: MEMORY, CANCELLED, TARGET (step too small
 * for the coder's numbers; no message). */
int cvol_trial_encode(cvol_context *context, cvol_trial *trial, double step, size_t stride);
/* Decodes what was encoded last (with stride 1) into trial->array, and measures it. */
int cvol_trial_decode(cvol_context *context, cvol_trial *trial);
/* Finds the block ranges and max_abs of the decoded array; *file_bytes is the size of its file. */
int cvol_trial_finish(cvol_context *context, cvol_trial *trial, uint64_t *file_bytes);

#endif
