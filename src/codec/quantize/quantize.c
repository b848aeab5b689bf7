/* Tests of coefficients before quantization. */
#include "codec/quantize/quantize.h"

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
    /* 256: floats near 2^30 are 64 apart. Infinity and NaN must fail. */
    const float limit = (float)((CVOL_VALUE_LIMIT - 256) * step);
    int fits = 1;
    for (int i = 0; i < count; i++)
        fits &= fabsf(c[i]) < limit;
    return fits;
}
