/* The least and the largest colour and opacity of a transfer function over an interval of values.
 */
#ifndef CVOL_RENDER_RAY_ENVELOPE_H
#define CVOL_RENDER_RAY_ENVELOPE_H

#include "render/transfer/transfer.h"

/* Bounds of r, g, b and the opacity per mean spacing. */
typedef struct cvol_ray_extremes {
    double lo[4], hi[4];
} cvol_ray_extremes;

/* Extremes over runs of points: level k, entry i is over the points i .. i + 2^k - 1. */
typedef struct cvol_ray_envelope {
    const cvol_transfer *transfer;
    cvol_ray_extremes *runs; /* levels of `count` entries each */
} cvol_ray_envelope;

/* Makes the envelope of a transfer function, which it refers to. Memory: 64 bytes times n (1 + log2
 * n) for n points. The caller frees it, also after an error. */
int cvol_ray_envelope_make(cvol_context *context, cvol_ray_envelope *envelope,
                           const cvol_transfer *transfer);
void cvol_ray_envelope_free(cvol_ray_envelope *envelope);

/* Bounds over the values a .. b, a <= b, both sides of jumps included. They contain every result of
 * linear interpolation there in double precision. Where a channel is constant, both its bounds have
 * exactly its value. Cost: two binary searches. */
cvol_ray_extremes cvol_ray_envelope_over(const cvol_ray_envelope *envelope, double a, double b);

#endif
