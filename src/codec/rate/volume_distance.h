/* How far two volumes of the same shape are apart in their samples. */
#ifndef CVOL_CODEC_RATE_VOLUME_DISTANCE_H
#define CVOL_CODEC_RATE_VOLUME_DISTANCE_H

#include "array/core/array.h"

typedef struct cvol_volume_distance {
    double real_l2;         /* as floats, neither rounded nor clamped */
    double stored_l2, most; /* as the samples' own type; the largest of a sample */
} cvol_volume_distance;

/* Evaluates both, a few sheets at a time. The same result for any number of threads. Errors:
 * MEMORY, CANCELLED. */
int cvol_volume_distance_between(cvol_context *context, cvol_volume_distance *out,
                                 const cvol_array *a, const cvol_array *b);

#endif
