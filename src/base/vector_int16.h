/* Loads and stores of int16, and of floats as int16: rounded to nearest, 0 to 32767.
 *
 * Only kernel files include this file: each compiles it for its instruction set.
 */
#ifndef CVOL_BASE_VECTOR_INT16_H
#define CVOL_BASE_VECTOR_INT16_H

#include <math.h>

#include "base/vector.h"

#define CVOL_INT16_LARGEST 32767.0f

CVOL_INLINE cvol_vf cvol_load_int16(const int16_t *from)
{
#if CVOL_LANES == 16
    return (cvol_vf)_mm512_cvtepi32_ps(
        _mm512_cvtepi16_epi32(_mm256_loadu_si256((const __m256i *)from)));
#elif defined(__wasm_simd128__)
    return (cvol_vf)wasm_f32x4_convert_i32x4(wasm_i32x4_load16x4(from));
#else
    cvol_vf v = {0}; /* not needed; GCC warns with -O2 */
    for (int i = 0; i < CVOL_LANES; i++)
        v[i] = from[i];
    return v;
#endif
}

#if CVOL_LANES == 16
/* 32 at any address. */
CVOL_INLINE __m512i cvol_load_32_int16(const int16_t *from)
{
    return _mm512_loadu_si512(from);
}

/* 16 at one address, then 16 at another. */
CVOL_INLINE __m512i cvol_load_two_int16(const int16_t *first, const int16_t *second)
{
    return _mm512_inserti64x4(_mm512_castsi256_si512(_mm256_loadu_si256((const __m256i *)first)),
                              _mm256_loadu_si256((const __m256i *)second), 1);
}

/* A vector of int16: a, then b. */
CVOL_INLINE __m512i cvol_int16_of(cvol_vf a, cvol_vf b)
{
    const __m512 most = _mm512_set1_ps(CVOL_INT16_LARGEST);
    const __m512i low = _mm512_cvtps_epi32(_mm512_min_ps((__m512)a, most)),
                  high = _mm512_cvtps_epi32(_mm512_min_ps((__m512)b, most));
    return _mm512_permutexvar_epi64(_mm512_set_epi64(7, 5, 3, 1, 6, 4, 2, 0),
                                    _mm512_packus_epi32(low, high));
}
#endif

#if defined(__wasm_simd128__)
/* The int16 of a vector, twice. */
CVOL_INLINE v128_t cvol_wasm_int16_of(cvol_vf v)
{
    const v128_t most = wasm_f32x4_splat(CVOL_INT16_LARGEST), zero = wasm_f32x4_splat(0);
    const v128_t within = wasm_f32x4_pmax(zero, wasm_f32x4_pmin(most, (v128_t)v));
    const v128_t rounded = wasm_i32x4_trunc_sat_f32x4(wasm_f32x4_nearest(within));
    return wasm_u16x8_narrow_i32x4(rounded, rounded);
}
#endif

/* Stores the first `lanes` of a vector. */
CVOL_INLINE void cvol_store_int16(int16_t *to, cvol_vf v, int lanes)
{
#if CVOL_LANES == 16
    const __m512i rounded = _mm512_cvtps_epi32(
        _mm512_min_ps((__m512)v, _mm512_set1_ps(CVOL_INT16_LARGEST)));
    const __m256i words = _mm512_cvtusepi32_epi16(
        _mm512_max_epi32(rounded, _mm512_setzero_si512()));
    if (lanes >= CVOL_LANES)
        _mm256_storeu_si256((__m256i *)to, words);
    else
        _mm256_mask_storeu_epi16(to, (__mmask16)((1u << lanes) - 1), words);
#elif defined(__wasm_simd128__)
    const v128_t words = cvol_wasm_int16_of(v);
    int16_t all[8];
    if (lanes >= CVOL_LANES) {
        wasm_v128_store64_lane(to, words, 0);
        return;
    }
    wasm_v128_store(all, words);
    for (int i = 0; i < lanes; i++)
        to[i] = all[i];
#else
    for (int i = 0; i < CVOL_LANES && i < lanes; i++)
        to[i] = (int16_t)lrintf(v[i] < 0                    ? 0
                                : v[i] > CVOL_INT16_LARGEST ? CVOL_INT16_LARGEST
                                                            : v[i]);
#endif
}

/* For two vectors. */
CVOL_INLINE void cvol_store_int16_of_two(int16_t *to_a, int16_t *to_b, cvol_vf a, cvol_vf b,
                                         int lanes)
{
#if CVOL_LANES == 16
    const __m512i words = cvol_int16_of(a, b);
    const __m256i low = _mm512_castsi512_si256(words), high = _mm512_extracti64x4_epi64(words, 1);
    if (lanes >= CVOL_LANES) {
        _mm256_storeu_si256((__m256i *)to_a, low);
        _mm256_storeu_si256((__m256i *)to_b, high);
    } else {
        const __mmask16 first = (__mmask16)((1u << lanes) - 1);
        _mm256_mask_storeu_epi16(to_a, first, low);
        _mm256_mask_storeu_epi16(to_b, first, high);
    }
#else
    cvol_store_int16(to_a, a, lanes);
    cvol_store_int16(to_b, b, lanes);
#endif
}

#endif
