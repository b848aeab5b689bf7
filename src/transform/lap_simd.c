/* The filter across faces: d = H (a1 - a2, a0 - a3); a1 += d0, a2 -= d0, a0 += d1, a3 -= d1.
 *
 * If the lines of a face are adjacent in memory, lanes are lines. If the four samples are adjacent
 * instead, they are one vector of four, and the differences come from it and its mirror image: (w1,
 * w0, -w0, -w1). Both compute the same products and sums.
 */
#include "base/cpu.h"
#include "base/vector.h"
#include "transform/lap_faces.h"

typedef float quad __attribute__((vector_size(16)));

void CVOL_SIMD(cvol_lap_filter)(float *samples, const cvol_lap_faces *faces, const float h[4]);

CVOL_INLINE void filter_one(float *a, int64_t stride, const float h[4])
{
    const float w0 = a[stride] - a[2 * stride], w1 = a[0] - a[3 * stride];
    const float d0 = h[0] * w0 + h[1] * w1, d1 = h[2] * w0 + h[3] * w1;
    a[0] += d1;
    a[stride] += d0;
    a[2 * stride] -= d0;
    a[3 * stride] -= d1;
}

CVOL_INLINE void filter_lanes(float *at, int64_t stride, const float h[4])
{
    cvol_vf a0 = cvol_load(at), a1 = cvol_load(at + stride), a2 = cvol_load(at + 2 * stride),
            a3 = cvol_load(at + 3 * stride);
    cvol_vf w0 = a1 - a2, w1 = a0 - a3;
    cvol_vf d0 = h[0] * w0 + h[1] * w1, d1 = h[2] * w0 + h[3] * w1;
    cvol_store(at, a0 + d1);
    cvol_store(at + stride, a1 + d0);
    cvol_store(at + 2 * stride, a2 - d0);
    cvol_store(at + 3 * stride, a3 - d1);
}

/* near and far: weights of the differences of a sample's own pair and of the other one. */
CVOL_INLINE void filter_quad(float *at, quad near, quad far)
{
    quad a;
    memcpy(&a, at, sizeof a);
    quad own = a - (quad){a[3], a[2], a[1], a[0]};
    quad other = {own[1], own[0], own[3], own[2]};
    a += near * own + far * other;
    memcpy(at, &a, sizeof a);
}

void CVOL_SIMD(cvol_lap_filter)(float *samples, const cvol_lap_faces *faces, const float h[4])
{
    const quad near = {h[3], h[0], h[0], h[3]}, far = {h[2], h[1], h[1], h[2]};
    const int64_t stride = faces->stride, count = faces->lines[0];
    for (int64_t j = 0; j < faces->lines[1]; j++) {
        float *sheet = samples + j * faces->line_stride[1];
        if (stride == 1) {
            for (int64_t i = 0; i < count; i++)
                for (int64_t f = 0; f < faces->count; f++)
                    filter_quad(sheet + i * faces->line_stride[0] + f * faces->face_stride, near,
                                far);
            continue;
        }
        for (int64_t f = 0; f < faces->count; f++) {
            float *face = sheet + f * faces->face_stride;
            int64_t i = 0;
            if (faces->line_stride[0] == 1)
                for (; i + CVOL_LANES <= count; i += CVOL_LANES)
                    filter_lanes(face + i, stride, h);
            for (; i < count; i++)
                filter_one(face + i * faces->line_stride[0], stride, h);
        }
    }
}
