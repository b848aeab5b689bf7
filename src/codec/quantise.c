/* Uniform quantiser. */
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

int cvol_quantise_extent(const float *c, int count, float threshold)
{
    while (count >= LANES && !any_reaches(c + count - LANES, threshold))
        count -= LANES;
    while (count > 1 && fabsf(c[count - 1]) < threshold)
        count--;
    return count < 1 ? 1 : count;
}

int cvol_quantise_fits(const float *c, int count, double step)
{
    float most = 0;
    for (int i = 0; i < count; i++)
        most = fabsf(c[i]) > most ? fabsf(c[i]) : most;
    /* 256: floats near 2^30 are 64 apart. Written so that an infinity fails. */
    return (double)most / step < CVOL_VALUE_LIMIT - 256;
}

int cvol_quantise(int32_t *values, const float *coefficients, int count, double step)
{
    const float inverse = (float)(1 / step);
    /* Slightly less than what becomes 1, lest rounding of the product loses it. */
    int used = cvol_quantise_extent(coefficients, count, (float)(0.499 * step));
    if (!cvol_quantise_fits(coefficients, used, step))
        return 0;
    for (int i = 0; i < used; i++) {
        int32_t magnitude = (int32_t)(fabsf(coefficients[i]) * inverse + 0.5f);
        values[i] = coefficients[i] < 0 ? -magnitude : magnitude;
    }
    while (used > 1 && values[used - 1] == 0)
        used--;
    return used;
}
