/* One pass over a volume's samples that encodes its bricks with one step.
 *
 * It fetches samples strip by strip (slab_source.h), so that a volume need not be in memory.
 * Threads encode a strip's bricks in parallel; bytes, counts and errors do not depend on their
 * number.
 *
 * Processes of a team (cvol_slab_source) encode one strip each in turn, then each gives the bytes
 * of all to its sink, in the same order. */
#ifndef CVOL_CODEC_BRICK_ENCODE_PASS_H
#define CVOL_CODEC_BRICK_ENCODE_PASS_H

#include "codec/brick/brick_samples.h"
#include "codec/brick/bricks.h"
#include "codec/brick/slab_source.h"

/* Called after a strip was encoded and passed on, with the slab that it was encoded from. In a
 * team, all processes call it after each turn, each for its own strip; NULL: this process had none.
 */
typedef int cvol_strip_callback(cvol_context *context, void *user, const cvol_slab *slab,
                                const cvol_strip *strip);

typedef struct cvol_encode_pass {
    const cvol_array *shape; /* dims, block, lapped, offset */
    const cvol_slab_source *source;
    const cvol_token_tables *tables;
    cvol_chooser_options options;
    double weight;               /* of bits, as a factor; 0 means 1 */
    const cvol_brick_sink *sink; /* receives the bytes, or NULL */
    size_t every; /* 0: all bricks; n: about one in n, evenly spread, as an estimate for all */
    cvol_strip_callback *after; /* or NULL */
    void *user;                 /* for after */
    cvol_token_counts *counts;  /* set to the counts of all tokens, or NULL */
    cvol_array *kept; /* receives the coded terms, or NULL: CVOL_SPLIT_FAST, cells of 16, all
                         bricks, an array of the shape without terms */
    double progress_from, progress_to;
} cvol_encode_pass;

typedef struct cvol_encode_result {
    uint64_t bytes;   /* of all subbands */
    uint64_t samples; /* of these subbands, padding included */
    double error;     /* squared error of all coefficients, in the samples' units */
} cvol_encode_result;

/* Errors: the source's and the sink's, MEMORY, CANCELLED, TARGET (the step is too small for the
 * coder's numbers; no message). */
int cvol_encode_pass_run(cvol_context *context, cvol_encode_result *out,
                         const cvol_encode_pass *pass);

#endif
