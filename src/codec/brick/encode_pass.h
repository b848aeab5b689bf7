/* One pass over a volume's samples that encodes its bricks with one step.
 *
 * Samples are fetched one layer of bricks at a time (64 sheets, and two more at either end where
 * the volume is lapped), so that a volume need not be in memory. Bricks of a layer are encoded in
 * parallel; bytes, counts and errors are the same for any number of threads.
 */
#ifndef CVOL_CODEC_BRICK_ENCODE_PASS_H
#define CVOL_CODEC_BRICK_ENCODE_PASS_H

#include "codec/brick/brick_samples.h"
#include "codec/brick/bricks.h"
#include "codec/brick/slab_source.h"

/* Called after layers layer .. end - 1 were encoded and handed on, with the slab that they were
 * encoded from. */
typedef int cvol_layer_hook(cvol_context *context, void *user, const cvol_slab *slab, size_t layer,
                            size_t end);

typedef struct cvol_encode_pass {
    const cvol_array *shape; /* dims, block, lapped, offset */
    const cvol_slab_source *source;
    const cvol_token_tables *tables;
    cvol_chooser_options options;
    double weight;               /* of bits, as a factor; 0: 1 */
    const cvol_brick_sink *sink; /* gets the bytes, or NULL */
    size_t every; /* 0: all bricks; n: one of about n, spread evenly, to know about what all are */
    cvol_layer_hook *after;    /* or NULL */
    void *user;                /* its */
    cvol_token_counts *counts; /* set to those of all tokens, or NULL */
    cvol_array *kept; /* gets the terms that are coded, or NULL: CVOL_SPLIT_FAST, cells of 16, all
                         bricks, an array of the shape that has no terms yet */
    double progress_from, progress_to;
} cvol_encode_pass;

typedef struct cvol_encode_result {
    uint64_t bytes;   /* of all subbands */
    uint64_t samples; /* that they have, those beyond the volume too */
    double error;     /* squared error of all coefficients, in the samples' units */
} cvol_encode_result;

/* Errors: those of the source and the sink, MEMORY, CANCELLED, TARGET (the step is too small for
 * the coder's numbers; no message). */
int cvol_encode_pass_run(cvol_context *context, cvol_encode_result *out,
                         const cvol_encode_pass *pass);

#endif
