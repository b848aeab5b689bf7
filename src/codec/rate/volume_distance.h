/* The distance between the samples of two volumes of the same shape. */
#ifndef CVOL_CODEC_RATE_VOLUME_DISTANCE_H
#define CVOL_CODEC_RATE_VOLUME_DISTANCE_H

#include "array/core/array.h"

typedef struct cvol_volume_distance {
    double real_l2, real_most; /* of floats, neither rounded nor clamped; the largest difference */
    double stored_l2, most;    /* in the samples' own type; the largest difference of a sample */
} cvol_volume_distance;

/* Evaluates both volumes, a few slices at a time. The result does not depend on the number of
 * threads. Errors: MEMORY, CANCELLED. */
int cvol_volume_distance_between(cvol_context *context, cvol_volume_distance *out,
                                 const cvol_array *a, const cvol_array *b);

#endif
