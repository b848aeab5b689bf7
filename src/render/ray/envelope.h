/* The least and the largest colour and density of a transfer function over an interval of values.
 */
#ifndef CVOL_RENDER_RAY_ENVELOPE_H
#define CVOL_RENDER_RAY_ENVELOPE_H

#include "render/transfer/transfer.h"

/* Bounds of r, g, b and the optical depth per mean spacing, -log(1 - opacity), which may be
 * infinite. */
typedef struct cvol_ray_extremes {
    double lo[4], hi[4];
} cvol_ray_extremes;

/* Extremes of one interval, so that joining two takes the smaller of each: the four least values,
 * and the negative of the four largest. */
typedef struct cvol_ray_run {
    float least[8];
} cvol_ray_run;

#define CVOL_RAY_BINS 16384
#define CVOL_RAY_BIN_LEVELS 15

/* Level k, entry i: the bins i .. i + 2^k - 1. */
typedef struct cvol_ray_envelope {
    double lo, scale;   /* bin i begins at lo + i / scale */
    cvol_ray_run *runs; /* CVOL_RAY_BIN_LEVELS times CVOL_RAY_BINS */
} cvol_ray_envelope;

/* Makes the envelope of a transfer function over the values min .. max, min < max. Memory: 8 MB.
 * The caller frees it, also after an error. */
int cvol_ray_envelope_make(cvol_context *context, cvol_ray_envelope *envelope,
                           const cvol_transfer *transfer, double min, double max);
void cvol_ray_envelope_free(cvol_ray_envelope *envelope);

/* The bin of a value; values outside of min .. max have the first or the last bin. */
static inline size_t cvol_ray_envelope_bin(const cvol_ray_envelope *envelope, double value)
{
    const double place = (value - envelope->lo) * envelope->scale;
    if (!(place > 0))
        return 0;
    return place < CVOL_RAY_BINS - 1 ? (size_t)place : CVOL_RAY_BINS - 1;
}

/* Bounds over the values a .. b, a <= b, within min .. max, both sides of jumps included. They
 * contain every result of linear interpolation there in double precision. They may include values
 * one bin away. The least depth is infinite if the function is opaque all over these bins. */
static inline void cvol_ray_envelope_over(cvol_ray_extremes *out, const cvol_ray_envelope *envelope,
                                          double a, double b)
{
    const size_t first = cvol_ray_envelope_bin(envelope, a),
                 last = cvol_ray_envelope_bin(envelope, b);
    const int level = 31 - __builtin_clz((unsigned)(last - first + 1));
    const cvol_ray_run *runs = envelope->runs + (size_t)level * CVOL_RAY_BINS;
    const cvol_ray_run *p = &runs[first], *q = &runs[last + 1 - ((size_t)1 << level)];
    for (int c = 0; c < 4; c++) {
        out->lo[c] = (double)(p->least[c] < q->least[c] ? p->least[c] : q->least[c]);
        out->hi[c] = -(double)(p->least[c + 4] < q->least[c + 4] ? p->least[c + 4]
                                                                 : q->least[c + 4]);
    }
}

#endif
