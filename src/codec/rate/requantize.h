/* Codes an array's terms with a coarser step; cells keep their splits and lapping.
 *
 * It chooses values as the compressor does (rd_choice.h), but from the coefficients that the terms
 * stand for instead of samples. It knows the distance of the two arrays' coefficients exactly. */
#ifndef CVOL_CODEC_RATE_REQUANTIZE_H
#define CVOL_CODEC_RATE_REQUANTIZE_H

#include "codec/brick/bricks.h"

/* The new step, and the weight of a bit relative to compression: 1 or more. The weight reaches
 * sizes between two steps if a small change of step moves many terms at once. */
typedef struct cvol_coarseness {
    double step, weight;
} cvol_coarseness;

/* Hands the bricks to the sink, in order. *error: the squared distance of all coefficients, in the
 * samples' units. counts: the counts of all tokens. The result does not depend on the numbers
 * of threads and processes; those of a team code the bricks of their shares, and all get all.
 * Errors: MEMORY, CANCELLED, the sink's. */
int cvol_requantise(cvol_context *context, double *error, cvol_token_counts *counts,
                    const cvol_array *array, cvol_coarseness coarseness,
                    const cvol_token_tables *tables, const cvol_brick_sink *sink);

#endif
