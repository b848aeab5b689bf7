/* Coding an array's terms with a coarser step: cells stay split and lapped as they are.
 *
 * Values are chosen as when compressing (rd_choice.h), from the coefficients that the terms stand
 * for instead of samples. How far the two arrays' coefficients are apart is known exactly.
 */
#ifndef CVOL_CODEC_RATE_REQUANTIZE_H
#define CVOL_CODEC_RATE_REQUANTIZE_H

#include "codec/brick/bricks.h"

/* How coarse: the step, and what a bit is worth in comparison to when compressing: 1 or more. Where
 * steps are of the kind that few terms fall between, sizes in between are had by that. */
typedef struct cvol_coarseness {
    double step, weight;
} cvol_coarseness;

/* Hands the bricks to the sink, in order; *error: the squared distance of all coefficients, in the
 * samples' units; counts are set to those of all tokens. The same for any number of threads.
 * Errors: MEMORY, CANCELLED, the sink's. */
int cvol_requantise(cvol_context *context, double *error, cvol_token_counts *counts,
                    const cvol_array *array, cvol_coarseness coarseness,
                    const cvol_token_tables *tables, const cvol_brick_sink *sink);

#endif
