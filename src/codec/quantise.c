/* Dead-zone quantiser. */
#include "codec/quantise.h"

#include <math.h>

#include "base/vector.h"

#define LANES 16

/* 1 if any of 16 magnitudes reaches the threshold. */
CVOL_INLINE int any_reaches(const float *coefficients, float threshold)
{
    int reached = 0;
    for (int i = 0; i < LANES; i++)
        reached |= fabsf(coefficients[i]) >= threshold;
    return reached;
}

/* One past the last of c[0 .. count) whose magnitude reaches the threshold, at least 1. */
static int find_used(const float *c, int count, float threshold)
{
    while (count >= LANES && !any_reaches(c + count - LANES, threshold))
        count -= LANES;
    while (count > 1 && fabsf(c[count - 1]) < threshold)
        count--;
    return count < 1 ? 1 : count;
}

static int32_t quantise_one(float coefficient, float inverse, float low, float high)
{
    float scaled = fabsf(coefficient) * inverse;
    int32_t magnitude = (int32_t)(scaled + (scaled < 1.5f ? low : high));
    return coefficient < 0 ? -magnitude : magnitude;
}

static float largest(const float *c, int count)
{
    float most = 0;
    for (int i = 0; i < count; i++)
        most = fabsf(c[i]) > most ? fabsf(c[i]) : most;
    return most;
}

int cvol_quantise(int32_t *values, const float *coefficients, int count, double step,
                  const cvol_rounding *rounding)
{
    const float inverse = (float)(1 / step);
    /* Slightly less than what becomes 1, lest rounding of the product loses it. */
    int used = find_used(coefficients, count, (float)((1 - (double)rounding->low) * step * 0.999));
    if (!(largest(coefficients, used) * inverse < (float)CVOL_VALUE_LIMIT - 256))
        return 0;
    for (int i = 0; i < used; i++)
        values[i] = quantise_one(coefficients[i], inverse, rounding->low, rounding->high);
    values[0] = quantise_one(coefficients[0], inverse, rounding->dc, rounding->dc);
    while (used > 1 && values[used - 1] == 0)
        used--;
    return used;
}
