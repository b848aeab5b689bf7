/* The filter across the faces of blocks on a layer's samples, and the clamp of samples that lack
 * it.
 *
 * The result for a sample does not depend on the samples that are filtered with it: vectors that
 * reach beyond a line's end are computed in the same way, and not stored there. */
#include "base/vector_int16.h"
#include "render/sheet/frame/frame.h"

typedef float quad __attribute__((vector_size(16)));
typedef double midpoints __attribute__((vector_size(16))); /* the same four, in pairs */

/* The quad a0 a1 | a2 a3 and its mirror image have the differences w1 w0 -w0 -w1. */
void CVOL_SIMD(cvol_sheet_lap_lanes)(float *a2, ptrdiff_t row_stride, ptrdiff_t sheet_stride,
                                     int rows, int sheets, const float h[4])
{
    const quad near = {h[3], h[0], h[0], h[3]}, far = {h[2], h[1], h[1], h[2]};
    for (int z = 0; z < sheets; z++)
        for (int r = 0; r < rows; r++) {
            /* In two halves: a2 often begins a cache line, and loads that straddle two are slow. */
            float *at = a2 + z * sheet_stride + r * row_stride;
            double low, high;
            memcpy(&low, at - 2, sizeof low);
            memcpy(&high, at, sizeof high);
            quad a = (quad)(midpoints){low, high};
            const quad own = a - (quad){a[3], a[2], a[1], a[0]};
            const quad other = {own[1], own[0], own[3], own[2]};
            a += near * own + far * other;
            const midpoints done = (midpoints)a;
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

void CVOL_SIMD(cvol_sheet_lap_across)(float *const a[4], ptrdiff_t stride, int columns, int lines,
                                      const float h[4])
{
    for (ptrdiff_t line = 0; line < lines; line++)
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

void CVOL_SIMD(cvol_sheet_clamp)(float *samples, ptrdiff_t row_stride, ptrdiff_t sheet_stride,
                                 int columns, int rows, int sheets, float lo, float hi)
{
    for (int z = 0; z < sheets; z++)
        for (int r = 0; r < rows; r++)
            for (int i = 0; i < columns; i += CVOL_LANES) {
                float *at = samples + z * sheet_stride + r * row_stride + i;
                const cvol_vf v = cvol_min(cvol_max(cvol_load(at), cvol_splat(lo)), cvol_splat(hi));
                store_up_to(at, v, columns - i);
            }
}

/* ---- int16 samples, rounded once ------------------------------------------------------------- */

#if CVOL_LANES == 16
/* Four rows together, of four samples each. */
CVOL_INLINE __m512 lap_four_rows(__m512 a, __m512 near, __m512 far)
{
    const __m512 own = _mm512_sub_ps(a, _mm512_permute_ps(a, 0x1b));
    const __m512 other = _mm512_permute_ps(own, 0xb1);
    return _mm512_fmadd_ps(near, own, _mm512_fmadd_ps(far, other, a));
}
#endif

CVOL_INLINE void lap_row(int16_t *a2, const float h[4])
{
    const float w0 = (float)(a2[-1] - a2[0]), w1 = (float)(a2[-2] - a2[1]);
    const float d0 = h[0] * w0 + h[1] * w1, d1 = h[2] * w0 + h[3] * w1;
    const cvol_vf done = {a2[-2] + d1, a2[-1] + d0, a2[0] - d0, a2[1] - d1};
    cvol_store_int16(a2 - 2, done, 4);
}

void CVOL_SIMD(cvol_sheet_lap_lanes_int16)(int16_t *a2, ptrdiff_t row_stride,
                                           ptrdiff_t sheet_stride, int rows, int sheets,
                                           const float h[4])
{
#if CVOL_LANES == 16
    const __m512 near = _mm512_broadcast_f32x4(_mm_setr_ps(h[3], h[0], h[0], h[3])),
                 far = _mm512_broadcast_f32x4(_mm_setr_ps(h[2], h[1], h[1], h[2]));
#endif
    for (int z = 0; z < sheets; z++) {
        int16_t *at = a2 + z * sheet_stride - 2;
        int r = 0;
#if CVOL_LANES == 16
        for (; r + 4 <= rows; r += 4, at += 4 * row_stride) {
            int64_t quads[4];
            for (int k = 0; k < 4; k++)
                memcpy(&quads[k], at + k * row_stride, sizeof quads[k]);
            const __m256i quad_samples = _mm256_setr_epi64x(quads[0], quads[1], quads[2], quads[3]);
            const __m512 a = _mm512_cvtepi32_ps(_mm512_cvtepi16_epi32(quad_samples));
            int16_t done[16];
            cvol_store_int16(done, (cvol_vf)lap_four_rows(a, near, far), 16);
            for (int k = 0; k < 4; k++)
                memcpy(at + k * row_stride, done + 4 * k, sizeof quads[k]);
        }
#endif
        for (; r < rows; r++, at += row_stride)
            lap_row(at + 2, h);
    }
}

void CVOL_SIMD(cvol_sheet_lap_across_int16)(int16_t *const a[4], ptrdiff_t stride, int columns,
                                            int lines, const float h[4])
{
    for (ptrdiff_t line = 0; line < lines; line++)
        for (int i = 0; i < columns; i += CVOL_LANES) {
            int16_t *at[4];
            for (int k = 0; k < 4; k++)
                at[k] = a[k] + line * stride + i;
            const int lanes = columns - i < CVOL_LANES ? columns - i : CVOL_LANES;
            const cvol_vf a0 = cvol_load_int16(at[0]), a1 = cvol_load_int16(at[1]),
                          a2 = cvol_load_int16(at[2]), a3 = cvol_load_int16(at[3]);
            const cvol_vf w0 = a1 - a2, w1 = a0 - a3;
            const cvol_vf d0 = h[0] * w0 + h[1] * w1, d1 = h[2] * w0 + h[3] * w1;
            cvol_store_int16_of_two(at[0], at[1], a0 + d1, a1 + d0, lanes);
            cvol_store_int16_of_two(at[2], at[3], a2 - d0, a3 - d1, lanes);
        }
}

void CVOL_SIMD(cvol_sheet_clamp_int16)(int16_t *samples, ptrdiff_t row_stride,
                                       ptrdiff_t sheet_stride, int columns, int rows, int sheets,
                                       int16_t lo, int16_t hi)
{
    for (int z = 0; z < sheets; z++)
        for (int r = 0; r < rows; r++) {
            int16_t *at = samples + z * sheet_stride + r * row_stride;
            for (int i = 0; i < columns; i++)
                at[i] = at[i] < lo ? lo : at[i] > hi ? hi : at[i];
        }
}
