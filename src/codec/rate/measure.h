/* What must be known of dense samples after compressing them. */
#ifndef CVOL_CODEC_RATE_MEASURE_H
#define CVOL_CODEC_RATE_MEASURE_H

#include "array/block/brick.h"

/* How far an array is from the samples that it was made of. */
typedef struct cvol_distance {
    double max_error, l2_error;     /* in the samples' own type: rounded and clamped */
    double real_l2_error;           /* of what evaluates, neither rounded nor clamped */
    double real_norm, real_max_abs; /* L2 norm and largest magnitude of that */
} cvol_distance;

/* Sets measured, max_error and psnr_db. */
void cvol_array_set_measured(cvol_array *array, const cvol_distance *distance);

/* Compares sheets begin .. end - 1 with those of a slab, and adds squares and largest errors to
 * *sum. Of volumes in cells of 16. The same result for any number of threads. what: for progress,
 * or NULL. Errors: MEMORY, CANCELLED. */
int cvol_measure_sheets(cvol_context *context, cvol_distance *sum, const cvol_array *array,
                        const cvol_slab *slab, size_t begin, size_t end, const char *what);
/* What rounding may lose when the array is evaluated in another way than it was measured: terms and
 * the offset may be much larger than what they add up to. */
double cvol_distance_rounding(const cvol_array *array, const cvol_distance *distance);
/* Norms of sums of squares. */
void cvol_distance_finish(cvol_distance *sum);

/* Evaluates all blocks and compares. The same result for any number of threads. Errors: MEMORY,
 * CANCELLED. */
int cvol_measure_distance(cvol_context *context, cvol_distance *out, const cvol_array *array,
                          const void *samples);

#endif
