/* One compression to a target, and the search for its step: what in-memory compressing (compress.c)
 * and that of streams (compress_stream.c) share.
 *
 * A miss (search.h) is a difference of logarithms: of the ratio and the asked one, of the errors,
 * or of PSNR in units of a factor e.
 */
#ifndef CVOL_CODEC_RATE_STEP_SEARCH_H
#define CVOL_CODEC_RATE_STEP_SEARCH_H

#include "codec/rate/encode_attempt.h"
#include "codec/rate/search.h"

/* What the searches aim at within what is allowed: 2 % of ratio, 0.1 dB, 2 % of step. */
#define CVOL_RATIO_AIM 1.006
#define CVOL_RATIO_ACCEPTED 1.016
#define CVOL_RATIO_MOST 1.02
#define CVOL_PSNR_AIM 0.03
#define CVOL_PSNR_ACCEPTED 0.08
/* In haste the first encode attempt is to be within these. */
#define CVOL_PSNR_FAST_AIM 0.2
#define CVOL_PSNR_FAST_MORE 0.5
#define CVOL_DB_PER_E (20 / 2.302585092994046)

typedef struct cvol_compression {
    cvol_context *context;
    cvol_attempt attempt;
    const cvol_compress_options *options;
    cvol_target target;
    double value;
    uint64_t raw_bytes, file_bytes;
    double least_step, most_step;
    double slope;       /* of misses over log step, as far as samples tell; 0: not known */
    double best_step;   /* the best that keeps the target, 0: none yet */
    double best_weight; /* and its bits' weight; 0: 1 */
    double reached;     /* the best PSNR or error found, for the message if none keeps it */
} cvol_compression;

/* Errors: ARGUMENT, UNSUPPORTED. */
int cvol_compress_options_check(cvol_context *context, const cvol_compress_options *options);
/* Whether what a ratio or bits a sample leave is no less than options->least_psnr. Errors: TARGET.
 */
int cvol_compress_check_least(cvol_context *context, const cvol_compress_options *options,
                              double psnr_db);
/* Bits a sample, as the ratio that they are. Errors: ARGUMENT. */
int cvol_ratio_of_bits(cvol_context *context, double *ratio, double bits, cvol_type type);

/* Sets the steps that make sense: from exact (integers) or what float arithmetic can hold, to all
 * zero. */
void cvol_compression_limits(cvol_compression *c);
/* How far the last sampled encode attempt (cvol_attempt_sample, cvol_attempt_estimate) misses. */
double cvol_compression_sample_miss(const cvol_compression *c);
/* By samples of the volume: about the step that a ratio or a PSNR needs, whether to lap, tables,
 * and the slope. Errors: those of cvol_attempt_sample. */
int cvol_compression_prepare(cvol_compression *c, double *step);

#endif
