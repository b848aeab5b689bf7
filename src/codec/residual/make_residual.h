/* Makes the residual of an array whose terms are final, and measures the result. */
#ifndef CVOL_CODEC_RESIDUAL_MAKE_RESIDUAL_H
#define CVOL_CODEC_RESIDUAL_MAKE_RESIDUAL_H

#include "codec/residual/residual_array.h"

/* The array, its target samples and the coding rule. The array may have a mask. */
typedef struct cvol_residual_job {
    const cvol_array *array;
    const void *samples;
    int fraction;
    cvol_residual_rule rule;
    double bound;
    const cvol_token_tables *tables;
} cvol_residual_job;

/* Fills fraction and rule. bound 0: exact. Errors: TARGET (the coefficients are too many or too
 * large for exact evaluation: the step must be larger; no message). */
int cvol_residual_job_start(cvol_residual_job *out, const cvol_array *array, const void *samples,
                            double bound);
/* Codes all bricks: counts tokens, adds up bytes, keeps the bytes; each of the three may be NULL.
 * Errors: MEMORY, CANCELLED, TARGET (a sample cannot be represented). */
int cvol_residual_job_run(cvol_context *context, const cvol_residual_job *job,
                          cvol_token_counts *counts, uint64_t *bytes, cvol_residual_data *kept);

/* Compares the array's evaluated samples, in its own type, with the samples. Masked samples do not
 * count, but must match to the bit. Sets measured, psnr_db and max_error, and widens the L2 bound,
 * which is that of the terms, to the decoded samples. *same: all samples match to the bit. Errors:
 * MEMORY, CANCELLED, the errors of evaluation. */
int cvol_measure_stored(cvol_context *context, cvol_array *array, const void *samples, int *same);

#endif
