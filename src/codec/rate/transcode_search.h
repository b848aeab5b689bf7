/* The search for the coarsest step, and weight of bits, that keep the target of a transcoding. */
#ifndef CVOL_CODEC_RATE_TRANSCODE_SEARCH_H
#define CVOL_CODEC_RATE_TRANSCODE_SEARCH_H

#include "codec/quantize/coding.h"
#include "codec/rate/requantize.h"
#include "cvol/codec.h"

typedef struct cvol_transcoding {
    cvol_context *context;
    const cvol_array *from;
    cvol_target target; /* a PSNR or a ratio */
    double value;
    cvol_token_tables *tables;
    cvol_token_counts *counts;
    cvol_array *shape; /* result of the last try, without terms */
    double error;      /* of the last try: squared */
    double slack_db;   /* known surplus of the measured PSNR over the tries' promise */
    double tried_db;   /* the tries' promise for the last committed step */
    uint64_t file_bytes, other_bytes;
    int count;
} cvol_transcoding;

/* The step of the source's encoding. */
double cvol_transcoding_own_step(const cvol_transcoding *t);
/* Raw bytes / file bytes of the last try. */
double cvol_transcoding_ratio(const cvol_transcoding *t);
/* Makes an array of the source's shape and properties, without terms, with this step. The caller
 * frees it. */
int cvol_transcoding_make_like(cvol_context *context, cvol_array **out, const cvol_array *from,
                               double step);
/* Sets the bounds of a result: they follow from the source's bounds and the distance of the
 * coefficients (t->error); its norm is at most the sum of the two norms. */
void cvol_transcoding_account(const cvol_transcoding *t, cvol_array *array);
/* Finds the coarsest step that keeps a PSNR, or the finest that keeps a ratio; *reached is 0 if no
 * step does. Errors: TARGET (the target is finer than the source), MEMORY, CANCELLED. */
int cvol_transcoding_search(cvol_transcoding *t, cvol_coarseness *out, int *reached);

#endif
