/* The filter across cells' faces on a layer's samples, and what keeps samples that lack it in
 * range.
 *
 * What becomes of a sample does not depend on which others are filtered with it: vectors that
 * reach beyond a line's end are computed alike, and not stored there.
 */
#include "render/sheet.h"

typedef float quad __attribute__((vector_size(16)));
typedef double halves __attribute__((vector_size(16))); /* the same four, two by two */

/* The quad a0 a1 | a2 a3 and its mirror image have the differences w1 w0 -w0 -w1. */
void CVOL_SIMD(cvol_sheet_lap_lanes)(float *a2, long row_stride, long sheet_stride, int rows,
                                     int sheets, const float h[4])
{
    const quad near = {h[3], h[0], h[0], h[3]}, far = {h[2], h[1], h[1], h[2]};
    for (int z = 0; z < sheets; z++)
        for (int r = 0; r < rows; r++) {
            /* In two halves: a2 often begins a line of the cache, and what straddles two is slow.
             */
            float *at = a2 + z * sheet_stride + r * row_stride;
            double low, high;
            memcpy(&low, at - 2, sizeof low);
            memcpy(&high, at, sizeof high);
            quad a = (quad)(halves){low, high};
            const quad own = a - (quad){a[3], a[2], a[1], a[0]};
            const quad other = {own[1], own[0], own[3], own[2]};
            a += near * own + far * other;
            const halves done = (halves)a;
            low = done[0];
            high = done[1];
            memcpy(at - 2, &low, sizeof low);
            memcpy(at, &high, sizeof high);
        }
}

CVOL_INLINE void store_up_to(float *to, cvol_vf v, int lanes)
{
    if (lanes >= CVOL_LANES)
        cvol_store(to, v);
    else
        cvol_store_first(to, v, lanes);
}

void CVOL_SIMD(cvol_sheet_lap_across)(float *const a[4], long stride, int columns, int lines,
                                      const float h[4])
{
    for (long line = 0; line < lines; line++)
        for (int i = 0; i < columns; i += CVOL_LANES) {
            float *at[4];
            for (int k = 0; k < 4; k++)
                at[k] = a[k] + line * stride + i;
            const cvol_vf a0 = cvol_load(at[0]), a1 = cvol_load(at[1]), a2 = cvol_load(at[2]),
                          a3 = cvol_load(at[3]);
            const cvol_vf w0 = a1 - a2, w1 = a0 - a3;
            const cvol_vf d0 = h[0] * w0 + h[1] * w1, d1 = h[2] * w0 + h[3] * w1;
            store_up_to(at[0], a0 + d1, columns - i);
            store_up_to(at[1], a1 + d0, columns - i);
            store_up_to(at[2], a2 - d0, columns - i);
            store_up_to(at[3], a3 - d1, columns - i);
        }
}

void CVOL_SIMD(cvol_sheet_clamp)(float *samples, long row_stride, long sheet_stride, int columns,
                                 int rows, int sheets, float lo, float hi)
{
    for (int z = 0; z < sheets; z++)
        for (int r = 0; r < rows; r++)
            for (int i = 0; i < columns; i += CVOL_LANES) {
                float *at = samples + z * sheet_stride + r * row_stride + i;
                const cvol_vf v = cvol_min(cvol_max(cvol_load(at), cvol_splat(lo)), cvol_splat(hi));
                store_up_to(at, v, columns - i);
            }
}
