/* Encode attempts for one volume: encoding with a given step, and measuring the result. */
#ifndef CVOL_CODEC_RATE_ENCODE_ATTEMPT_H
#define CVOL_CODEC_RATE_ENCODE_ATTEMPT_H

#include "array/core/summary.h"
#include "codec/brick/coded.h"
#include "codec/brick/encode_pass.h"
#include "codec/quantize/split_sample.h"
#include "codec/rate/sampler.h"
#include "cvol/codec.h"

/* The assumed size of the neural coder's output relative to the usual coder's, until samples give a
 * measured value: for ten volumes at ratio 30 it is 0.85 to 0.97. */
#define CVOL_NEURAL_BYTES 0.92

typedef struct cvol_attempt {
    cvol_slab_source source;
    const void *samples; /* all samples, or NULL if a source reads them */
    const void *truth;   /* the reference for errors: the original samples, also where `samples`
                            is filled */
    void *filled;        /* with a background: filled samples, owned */
    cvol_array *shape;   /* grid, block, lapped, offset, range of values, mask; no terms. Arrays
                            of encode attempts borrow its mask */
    int may_end;         /* true length (true_length.h) is allowed at the volume's ends */
    int may_lap;         /* options and block allow shape->lapped */
    cvol_split_choice split;
    int fast;      /* a rough step suffices, and lapping is not questioned */
    int lap_known; /* sampled bricks are only needed as shape->lapped says */
    int uncounted; /* no tables will be fitted to an encoding of all bricks */
    int is_packed; /* the file will be small, and its front packed (section_pack.h) */
    int plain;     /* round to nearest, for the least error; else the least squared error at
                      equal bytes */
    double step;   /* of the last encode attempt */
    cvol_split_bias split_bias; /* as for cvol_chooser_options */
    /* The neural coder's bytes and squared error relative to the usual coder's: a guess, until
     * cvol_attempt_choose_split_bias measures them on samples. */
    double neural_bytes, neural_error;
    double weight; /* of bits, when all bricks are encoded; 0 means 1 */
    cvol_token_tables *tables;
    cvol_token_counts *counts;   /* of the last encode attempt */
    cvol_encode_result result;   /* of the last encode attempt */
    double least_step;           /* with a background: finer steps do better without a mask; 0:
                                    no step does */
    uint64_t mask_bytes;         /* of the background's mask, in the front */
    uint64_t front_bytes, bytes; /* of a file before its subbands (an estimate until the search
                                    knows a file's size), and of the file */
    cvol_sampler *sampler;
    cvol_cell_sample *cells;
    cvol_coded *coded;  /* of the last cvol_attempt_encode */
    cvol_array *kept;   /* terms of the array, if they need no decoding, until it is measured */
    cvol_array *array;  /* of the last cvol_attempt_decode */
    double error_share; /* the share of coefficients' squared error that samples have */
    uint64_t inside;    /* samples of the last encode attempt that lie within the volume */
    cvol_tally *tally;  /* of samples that a source reads and one more pass must count, or NULL */
    int count;          /* encodings so far */
} cvol_attempt;

/* Widens the range of the samples by that of the original ones, if the options have it. */
void cvol_attempt_widen_range(double *least, double *largest, cvol_type type,
                              const cvol_compress_options *options);
/* Makes shape and tables; uses the options for blocks and bricks only. Samples are all in memory,
 * or come from a source. It scans their statistics. The encode attempt must not move in memory.
 * Errors: the errors of array creation and of the source, DATA, MEMORY, CANCELLED. */
int cvol_attempt_start(cvol_context *context, cvol_attempt *attempt, const void *samples,
                       const cvol_grid *grid, const cvol_compress_options *options);
/* Does the same, and stores a background separately if the options and the samples ask for it.
 * Errors: the errors of cvol_background_fills too. */
int cvol_attempt_start_with_background(cvol_context *context, cvol_attempt *attempt,
                                       const void *samples, const cvol_grid *grid,
                                       const cvol_compress_options *options);
int cvol_attempt_start_source(cvol_context *context, cvol_attempt *attempt,
                              const cvol_slab_source *source, const cvol_grid *grid,
                              const cvol_compress_options *options);
/* Sets the shape's summary once all samples are counted. */
int cvol_attempt_finish_tally(cvol_context *context, cvol_attempt *attempt);
/* Takes the other options; call it before the first encode attempt. */
void cvol_attempt_set_options(cvol_attempt *attempt, const cvol_compress_options *options);
void cvol_attempt_free(cvol_attempt *attempt);

/* Sets the step of the next encode attempt, and the members of shape that depend on it. Each encode
 * attempt calls it. */
void cvol_attempt_set_step(cvol_attempt *attempt, double step);
/* Encodes some bricks with this step and the usual coder, which takes a thirtieth of the neural
 * coder's time; attempt->bytes is then an estimate for the whole file. Errors: MEMORY, CANCELLED,
 * TARGET (step too small for the coder's numbers; no message). */
int cvol_attempt_sample(cvol_context *context, cvol_attempt *attempt, double step);
/* Does the same by a pass over about one brick in `every`: a better sample of large volumes. */
int cvol_attempt_estimate(cvol_context *context, cvol_attempt *attempt, double step, size_t every);
/* Chooses lapping if it lowers error plus lambda times bits on a sample with this step. */
int cvol_attempt_choose_lap(cvol_context *context, cvol_attempt *attempt, double step);
/* For the neural coder: chooses on a sample how strongly splits prefer sub-blocks to whole cells.
 * In some volumes the networks predict small sub-blocks better than tables do. */
int cvol_attempt_choose_split_bias(cvol_context *context, cvol_attempt *attempt, double step);
/* Measures error_share on a sample with this step. In effort fast, it also counts the sample's
 * tokens. */
int cvol_attempt_measure_error_share(cvol_context *context, cvol_attempt *attempt, double step);
/* Measures the error with this step on one in `every` kept cells from all over the volume. For
 * volumes in memory and cells of 16 that use CVOL_SPLIT_FAST. */
int cvol_attempt_estimate_error(cvol_context *context, cvol_attempt *attempt, double step,
                                size_t every);
/* Encodes all bricks into a sink; after (which may be NULL) as in encode_pass.h. Errors: the errors
 * of cvol_attempt_sample, of the sink and of the source. */
int cvol_attempt_pass(cvol_context *context, cvol_attempt *attempt, double step,
                      const cvol_brick_sink *sink, cvol_strip_callback *after, void *user);
/* Encodes all bricks into attempt->coded. Errors: as cvol_attempt_sample. */
int cvol_attempt_encode(cvol_context *context, cvol_attempt *attempt, double step);
/* Fits the tables to the last encoding. Errors: MEMORY. */
int cvol_attempt_fit(cvol_context *context, cvol_attempt *attempt);
/* Moves attempt->array, with its mask, to the caller. */
cvol_array *cvol_attempt_take_array(cvol_attempt *attempt);
/* Decodes the last encoding into attempt->array, and measures it. If all bricks use
 * CVOL_SPLIT_FAST, it takes the encoder's terms and does not read the bytes again. */
int cvol_attempt_decode(cvol_context *context, cvol_attempt *attempt);
/* Returns the PSNR that follows from an encode attempt's error. */
double cvol_attempt_psnr(const cvol_attempt *attempt);

#endif
