/* Trials of compressing one volume: how it is coded with a given step, and what comes of it. */
#ifndef CVOL_CODEC_RATE_ENCODE_ATTEMPT_H
#define CVOL_CODEC_RATE_ENCODE_ATTEMPT_H

#include "array/core/summary.h"
#include "codec/brick/coded.h"
#include "codec/brick/encode_pass.h"
#include "codec/quantize/split_sample.h"
#include "codec/rate/sampler.h"
#include "cvol/codec.h"

/* What the small coder is taken to make of the usual one's bytes, until samples tell: of ten
 * volumes at ratio 30 it takes 0.85 to 0.97 of them. */
#define CVOL_SMALL_BYTES 0.92

/* The work on one volume. */
typedef struct cvol_trial {
    cvol_slab_source source;
    const void *samples; /* all of them, or NULL where they are read */
    const void *truth;   /* what to measure against: samples, but those of the background */
    void *filled;        /* with a background: samples, owned */
    cvol_array *shape;   /* grid, block, lapped, offset, range of values, mask; no terms. Arrays of
                            trials borrow its mask */
    int may_end;         /* whether the volume's ends may be coded so (true_length.h) */
    int may_lap;         /* whether the options and the block allow shape->lapped */
    cvol_split_choice split;
    int hasty;     /* a step found roughly will do, and lapping is not questioned */
    int lap_known; /* sampled bricks are only needed as shape->lapped says */
    int uncounted; /* no tables will be fitted to an encoding of all */
    int is_packed; /* the file will be small, and its front is (section_pack.h) */
    int plain;     /* round to nearest: errors are least; else squared error at equal bytes is */
    double step;   /* of the last trial */
    cvol_coarse_shares coarse; /* as for cvol_chooser_options */
    /* What the small coder makes of bytes and squared error, as samples show them that are coded
     * as usual: a guess, until cvol_trial_choose_share has measured it. */
    double small_bytes, small_error;
    double weight; /* of bits, where all are encoded; 0: 1 */
    cvol_token_tables *tables;
    cvol_token_counts *counts;   /* of the last trial */
    cvol_encode_result result;   /* of the last trial */
    double least_step;           /* with a background: finer ones do better without; 0: none do */
    uint64_t mask_bytes;         /* of the background's mask, in the front */
    uint64_t front_bytes, bytes; /* of a file before its shells (an estimate until trial_finish),
                                    and of the file */
    cvol_sampler *sampler;
    cvol_cell_sample *cells;
    cvol_coded *coded;  /* of the last cvol_trial_encode */
    cvol_array *kept;   /* its terms, where they need not be decoded, until they are measured */
    cvol_array *array;  /* of the last cvol_trial_decode */
    double error_share; /* of coefficients' squared error that samples have */
    uint64_t inside;    /* samples of the last trial within the volume */
    cvol_tally *tally;  /* of samples that are read and must be counted in one more pass, or NULL */
    int count;          /* encodings so far */
} cvol_trial;

/* Makes shape and tables; of the options those about blocks and bricks count. All samples are in
 * memory, or come from a source, and are surveyed. The trial must stay where it is. Errors: those
 * of array creation and of the source, DATA, MEMORY, CANCELLED. */
int cvol_trial_start(cvol_context *context, cvol_trial *trial, const void *samples,
                     const cvol_grid *grid, const cvol_compress_options *options);
/* The same, with a background kept apart if the options and the samples ask for it. Errors: those
 * of cvol_background_fills too. */
int cvol_trial_start_with_background(cvol_context *context, cvol_trial *trial, const void *samples,
                                     const cvol_grid *grid, const cvol_compress_options *options);
int cvol_trial_start_source(cvol_context *context, cvol_trial *trial,
                            const cvol_slab_source *source, const cvol_grid *grid,
                            const cvol_compress_options *options);
/* All samples were counted: the shape's summary becomes known. */
int cvol_trial_end_tally(cvol_context *context, cvol_trial *trial);
/* How options say that it is to be coded; before the first trial. */
void cvol_trial_set_options(cvol_trial *trial, const cvol_compress_options *options);
void cvol_trial_free(cvol_trial *trial);

/* The step of the next trial, which each sets itself: shape is as it is coded with it. */
void cvol_trial_set_step(cvol_trial *trial, double step);
/* Encodes some bricks with this step, in the usual way, which takes a thirtieth of the small
 * coder's time; trial->bytes is about what the whole file would have. Errors: MEMORY, CANCELLED,
 * TARGET (step too small for the coder's numbers; no message). */
int cvol_trial_sample(cvol_context *context, cvol_trial *trial, double step);
/* The same by a pass over about one brick of so many: of large volumes a better sample. */
int cvol_trial_estimate(cvol_context *context, cvol_trial *trial, double step, size_t every);
/* Whether lapping makes error and lambda bits less, judged by a sample with this step. */
int cvol_trial_choose_lap(cvol_context *context, cvol_trial *trial, double step);
/* Of what is coded smallest, whether parts are favoured beside whole cells, judged likewise: what
 * the networks foretell, and tables do not, is worth more of small parts in some volumes. */
int cvol_trial_choose_share(cvol_context *context, cvol_trial *trial, double step);
/* How much of the coefficients' error samples show, by a sample with this step. In haste
 * its tokens are counted. */
int cvol_trial_find_share(cvol_context *context, cvol_trial *trial, double step);
/* The error with this step, by cells from all over the volume: one of `every` that are kept. Of
 * volumes in memory and cells of 16, coded with CVOL_SPLIT_FAST. */
int cvol_trial_guess_error(cvol_context *context, cvol_trial *trial, double step, size_t every);
/* Encodes all bricks into a sink; after (which may be NULL) as in encode_pass.h. Errors: as
 * cvol_trial_sample, and those of the sink and the source. */
int cvol_trial_pass(cvol_context *context, cvol_trial *trial, double step,
                    const cvol_brick_sink *sink, cvol_layer_hook *after, void *user);
/* Encodes all bricks into trial->coded. Errors: as cvol_trial_sample. */
int cvol_trial_encode(cvol_context *context, cvol_trial *trial, double step);
/* Fits the tables to what was encoded last. Errors: MEMORY. */
int cvol_trial_fit(cvol_context *context, cvol_trial *trial);
/* Hands over trial->array, with its mask. */
cvol_array *cvol_trial_take_array(cvol_trial *trial);
/* Decodes what was encoded last into trial->array, and measures it. Where all was encoded with
 * CVOL_SPLIT_FAST, terms are those that were coded, and bytes are not read again. */
int cvol_trial_decode(cvol_context *context, cvol_trial *trial);
/* The PSNR that a trial's error means. */
double cvol_trial_psnr(const cvol_trial *trial);

#endif
