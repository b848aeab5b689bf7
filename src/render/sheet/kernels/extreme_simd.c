/* The values of tiles (render/sheet/band/extreme.h). */
#include <math.h>

#include "base/vector.h"
#include "render/sheet/band/extreme.h"

#define PARTS (CVOL_TILE / CVOL_LANES)

/* After all pixels of a tile have a value, they are not tested for emptiness again. */
CVOL_INLINE float find_least(const float *at, int width, int count, float sign, int all_hold)
{
    const cvol_vf identity = cvol_splat(-INFINITY);
    cvol_vf least = -identity;
    for (int j = 0; j < count; j++, at += (ptrdiff_t)CVOL_LINES * width)
        for (int k = 0; k < PARTS; k++) {
            const float *values = at + k * CVOL_LANES;
            const cvol_vf value = sign * cvol_load(values);
            least = cvol_min(
                least,
                all_hold ? value : cvol_select(cvol_load(values + width) > 0, value, identity));
        }
    float out = least[0];
    for (int i = 1; i < CVOL_LANES; i++)
        out = least[i] < out ? least[i] : out;
    return out;
}

void CVOL_SIMD(cvol_extremes_accumulate)(float *held, const float *lines, int width, int count,
                                         int sign)
{
    for (int tile = 0; tile < width / CVOL_TILE; tile++) {
        const float *at = lines + (ptrdiff_t)tile * CVOL_TILE;
        held[tile] = held[tile] > -INFINITY ? find_least(at, width, count, (float)sign, 1)
                                            : find_least(at, width, count, (float)sign, 0);
    }
}
