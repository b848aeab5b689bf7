/* Making corrections of an array whose terms are settled, and measuring what comes of them. */
#ifndef CVOL_CODEC_RESIDUAL_MAKE_RESIDUAL_H
#define CVOL_CODEC_RESIDUAL_MAKE_RESIDUAL_H

#include "codec/residual/residual_array.h"

/* What is to be corrected, and to what. The array may have a mask. */
typedef struct cvol_correcting {
    const cvol_array *array;
    const void *samples;
    int fraction;
    cvol_residual_rule rule;
    double bound;
    const cvol_token_tables *tables;
} cvol_correcting;

/* Fills fraction and rule. bound 0: exact. Errors: TARGET (the coefficients are too many or too
 * large for exact evaluation: the step must be larger; no message). */
int cvol_correcting_start(cvol_correcting *out, const cvol_array *array, const void *samples,
                          double bound);
/* Codes all bricks: counts tokens, adds up bytes, keeps the bytes; each may be NULL. Errors:
 * MEMORY, CANCELLED, TARGET (a sample cannot be held). */
int cvol_correcting_run(cvol_context *context, const cvol_correcting *job,
                        cvol_token_counts *counts, uint64_t *bytes, cvol_corrected *kept);

/* What an array evaluates to in its own type, against the samples: over those that are not masked;
 * masked ones must be the same to the bit. Sets measured, psnr_db and max_error. *same: all samples
 * are, to the bit. Errors: MEMORY, CANCELLED, those of evaluating. */
int cvol_measure_stored(cvol_context *context, cvol_array *array, const void *samples, int *same);

#endif
