/* One compression to a target, and the search for its step: common to compression in memory
 * (compress.c) and of streams (compress_stream.c).
 *
 * A miss (search.h) is a difference of logarithms: of the ratio and the target ratio, of the
 * errors, or of PSNR in units of a factor e. */
#ifndef CVOL_CODEC_RATE_STEP_SEARCH_H
#define CVOL_CODEC_RATE_STEP_SEARCH_H

#include "codec/rate/encode_attempt.h"
#include "codec/rate/search.h"

/* The searches' aims within the tolerance: 2 % of ratio, 0.1 dB, 2 % of step. */
#define CVOL_RATIO_AIM 1.006
#define CVOL_RATIO_ACCEPTED 1.016
#define CVOL_RATIO_MAX 1.02
#define CVOL_PSNR_AIM 0.03
#define CVOL_PSNR_ACCEPTED 0.08
/* In effort fast, the first encode attempt should be within these. */
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
    double slope;       /* of misses over log step, estimated on samples; 0: not known */
    double best_step;   /* the best step that keeps the target, 0: none yet */
    double best_weight; /* the weight of bits at best_step; 0 means 1 */
    double reached;     /* the best PSNR or error so far, for the message if no step keeps the
                           target */
} cvol_compression;

/* Checks the PSNR of a ratio or bits per sample against options->least_psnr. Errors: TARGET. */
int cvol_compress_check_least_psnr(cvol_context *context, const cvol_compress_options *options,
                                   double psnr_db, int is_certified);
/* Converts bits per sample to a ratio. Errors: ARGUMENT. */
int cvol_ratio_of_bits(cvol_context *context, double *ratio, double bits, cvol_type type);

/* Sets the range of useful steps: from exact (integers) or the limit of float arithmetic, to all
 * terms zero. */
void cvol_compression_limits(cvol_compression *c);
/* The miss of the last sampled encode attempt (cvol_attempt_sample, cvol_attempt_estimate). */
double cvol_compression_sample_miss(const cvol_compression *c);
/* Estimates on samples of the volume: the step for a ratio or a PSNR, lapping, tables, and the
 * slope. Errors: as cvol_attempt_sample. */
int cvol_compression_prepare(cvol_compression *c, double *step);

#endif
