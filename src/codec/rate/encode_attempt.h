/* Encode attempts of compressing one volume: how it is coded with a given step, and what comes of
 * it. */
#ifndef CVOL_CODEC_RATE_ENCODE_ATTEMPT_H
#define CVOL_CODEC_RATE_ENCODE_ATTEMPT_H

#include "array/core/summary.h"
#include "codec/brick/coded.h"
#include "codec/brick/encode_pass.h"
#include "codec/quantize/split_sample.h"
#include "codec/rate/sampler.h"
#include "cvol/codec.h"

/* What the neural coder is taken to make of the usual one's bytes, until samples tell: of ten
 * volumes at ratio 30 it takes 0.85 to 0.97 of them. */
#define CVOL_NEURAL_BYTES 0.92

/* The work on one volume. */
typedef struct cvol_attempt {
    cvol_slab_source source;
    const void *samples; /* all of them, or NULL where they are read */
    const void *truth;   /* what to measure against: samples, but those of the background */
    void *filled;        /* with a background: samples, owned */
    cvol_array *shape;   /* grid, block, lapped, offset, range of values, mask; no terms. Arrays of
                            encode attempts borrow its mask */
    int may_end;         /* whether the volume's ends may be coded so (true_length.h) */
    int may_lap;         /* whether the options and the block allow shape->lapped */
    cvol_split_choice split;
    int fast;      /* a step found roughly will do, and lapping is not questioned */
    int lap_known; /* sampled bricks are only needed as shape->lapped says */
    int uncounted; /* no tables will be fitted to an encoding of all */
    int is_packed; /* the file will be small, and its front is (section_pack.h) */
    int plain;     /* round to nearest: errors are least; else squared error at equal bytes is */
    double step;   /* of the last encode attempt */
    cvol_coarse_shares coarse; /* as for cvol_chooser_options */
    /* What the neural coder makes of bytes and squared error, as samples show them that are coded
     * as usual: a guess, until cvol_attempt_choose_share has measured it. */
    double neural_bytes, neural_error;
    double weight; /* of bits, where all are encoded; 0: 1 */
    cvol_token_tables *tables;
    cvol_token_counts *counts;   /* of the last encode attempt */
    cvol_encode_result result;   /* of the last encode attempt */
    double least_step;           /* with a background: finer ones do better without; 0: none do */
    uint64_t mask_bytes;         /* of the background's mask, in the front */
    uint64_t front_bytes, bytes; /* of a file before its subbands (an estimate until trial_finish),
                                    and of the file */
    cvol_sampler *sampler;
    cvol_cell_sample *cells;
    cvol_coded *coded;  /* of the last cvol_attempt_encode */
    cvol_array *kept;   /* its terms, where they need not be decoded, until they are measured */
    cvol_array *array;  /* of the last cvol_attempt_decode */
    double error_share; /* of coefficients' squared error that samples have */
    uint64_t inside;    /* samples of the last encode attempt within the volume */
    cvol_tally *tally;  /* of samples that are read and must be counted in one more pass, or NULL */
    int count;          /* encodings so far */
} cvol_attempt;

/* Makes shape and tables; of the options those about blocks and bricks count. All samples are in
 * memory, or come from a source, and are surveyed. The encode attempt must stay where it is.
 * Errors: those of array creation and of the source, DATA, MEMORY, CANCELLED. */
int cvol_attempt_start(cvol_context *context, cvol_attempt *attempt, const void *samples,
                       const cvol_grid *grid, const cvol_compress_options *options);
/* The same, with a background kept apart if the options and the samples ask for it. Errors: those
 * of cvol_background_fills too. */
int cvol_attempt_start_with_background(cvol_context *context, cvol_attempt *attempt,
                                       const void *samples, const cvol_grid *grid,
                                       const cvol_compress_options *options);
int cvol_attempt_start_source(cvol_context *context, cvol_attempt *attempt,
                              const cvol_slab_source *source, const cvol_grid *grid,
                              const cvol_compress_options *options);
/* All samples were counted: the shape's summary becomes known. */
int cvol_attempt_end_tally(cvol_context *context, cvol_attempt *attempt);
/* How options say that it is to be coded; before the first encode attempt. */
void cvol_attempt_set_options(cvol_attempt *attempt, const cvol_compress_options *options);
void cvol_attempt_free(cvol_attempt *attempt);

/* The step of the next encode attempt, which each sets itself: shape is as it is coded with it. */
void cvol_attempt_set_step(cvol_attempt *attempt, double step);
/* Encodes some bricks with this step, in the usual way, which takes a thirtieth of the small
 * coder's time; encode attempt->bytes is about what the whole file would have. Errors: MEMORY,
 * CANCELLED, TARGET (step too small for the coder's numbers; no message). */
int cvol_attempt_sample(cvol_context *context, cvol_attempt *attempt, double step);
/* The same by a pass over about one brick of so many: of large volumes a better sample. */
int cvol_attempt_estimate(cvol_context *context, cvol_attempt *attempt, double step, size_t every);
/* Whether lapping makes error and lambda bits less, judged by a sample with this step. */
int cvol_attempt_choose_lap(cvol_context *context, cvol_attempt *attempt, double step);
/* Of what is coded smallest, whether parts are favoured beside whole cells, judged likewise: what
 * the networks foretell, and tables do not, is worth more of small parts in some volumes. */
int cvol_attempt_choose_share(cvol_context *context, cvol_attempt *attempt, double step);
/* How much of the coefficients' error samples show, by a sample with this step. In haste
 * its tokens are counted. */
int cvol_attempt_find_share(cvol_context *context, cvol_attempt *attempt, double step);
/* The error with this step, by cells from all over the volume: one of `every` that are kept. Of
 * volumes in memory and cells of 16, coded with CVOL_SPLIT_FAST. */
int cvol_attempt_guess_error(cvol_context *context, cvol_attempt *attempt, double step,
                             size_t every);
/* Encodes all bricks into a sink; after (which may be NULL) as in encode_pass.h. Errors: as
 * cvol_attempt_sample, and those of the sink and the source. */
int cvol_attempt_pass(cvol_context *context, cvol_attempt *attempt, double step,
                      const cvol_brick_sink *sink, cvol_layer_hook *after, void *user);
/* Encodes all bricks into encode attempt->coded. Errors: as cvol_attempt_sample. */
int cvol_attempt_encode(cvol_context *context, cvol_attempt *attempt, double step);
/* Fits the tables to what was encoded last. Errors: MEMORY. */
int cvol_attempt_fit(cvol_context *context, cvol_attempt *attempt);
/* Hands over encode attempt->array, with its mask. */
cvol_array *cvol_attempt_take_array(cvol_attempt *attempt);
/* Decodes what was encoded last into encode attempt->array, and measures it. Where all was encoded
 * with CVOL_SPLIT_FAST, terms are those that were coded, and bytes are not read again. */
int cvol_attempt_decode(cvol_context *context, cvol_attempt *attempt);
/* The PSNR that a encode attempt's error means. */
double cvol_attempt_psnr(const cvol_attempt *attempt);

#endif
