/* Pixels of four floats in longer vectors. */
#ifndef CVOL_BASE_VECTOR_PIXEL_H
#define CVOL_BASE_VECTOR_PIXEL_H

#include <string.h>

#include "base/vector.h"

typedef float cvol_pixel_f __attribute__((vector_size(16)));

CVOL_INLINE cvol_pixel_f cvol_pixel_load(const float *from)
{
    cvol_pixel_f v;
    memcpy(&v, from, sizeof v);
    return v;
}

/* The sum of the pixels in a vector. */
CVOL_INLINE cvol_pixel_f cvol_pixels_add(cvol_vf v)
{
#if CVOL_LANES == 16
    const __m256 half = _mm256_add_ps(_mm512_castps512_ps256((__m512)v),
                                      _mm512_extractf32x8_ps((__m512)v, 1));
#elif CVOL_LANES == 8
    const __m256 half = (__m256)v;
#endif
#if CVOL_LANES == 4
    return (cvol_pixel_f)v;
#else
    return (cvol_pixel_f)_mm_add_ps(_mm256_castps256_ps128(half), _mm256_extractf128_ps(half, 1));
#endif
}

#endif
