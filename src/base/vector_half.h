/* Loads and stores of floats as half floats (IEEE 754 binary16), 16 at a time on every instruction
 * set. */
#ifndef CVOL_BASE_VECTOR_HALF_H
#define CVOL_BASE_VECTOR_HALF_H

#include <stddef.h>

#include "base/vector.h"

typedef float cvol_floats16 __attribute__((vector_size(64)));
typedef int32_t cvol_bits16 __attribute__((vector_size(64)));
typedef uint16_t cvol_halves16 __attribute__((vector_size(32)));

/* Loads 16. Exponents differ by 112, those of subnormal numbers too. */
CVOL_INLINE cvol_floats16 cvol_load_half(const uint16_t *from)
{
#if defined(__AVX512F__)
    return (cvol_floats16)_mm512_cvtph_ps(_mm256_loadu_si256((const __m256i *)(const void *)from));
#elif defined(__F16C__)
    const __m256 parts[2] = {
        _mm256_cvtph_ps(_mm_loadu_si128((const __m128i *)(const void *)from)),
        _mm256_cvtph_ps(_mm_loadu_si128((const __m128i *)(const void *)(from + 8)))};
    cvol_floats16 row;
    memcpy(&row, parts, sizeof row);
    return row;
#else
    cvol_halves16 halves;
    memcpy(&halves, from, sizeof halves);
    const cvol_bits16 bits = __builtin_convertvector(halves, cvol_bits16);
    const cvol_floats16 magnitude = (cvol_floats16)((bits & 0x7fff) << 13) * 0x1p112f;
    return (cvol_floats16)((cvol_bits16)magnitude | (bits & 0x8000) << 16);
#endif
}

/* Rounds to nearest, ties to even; numbers out of range, and NaN, become the largest half. */
CVOL_INLINE uint16_t cvol_half_of(float value)
{
    uint32_t bits, sign;
    memcpy(&bits, &value, sizeof bits);
    sign = bits >> 16 & 0x8000;
    bits &= 0x7fffffff;
    if (bits >= 0x477fe000) /* 65504, the largest half */
        return (uint16_t)(sign | 0x7bff);
    if (bits < 0x38800000) { /* below 2^-14: the sum has units of 2^-24 */
        float small;
        memcpy(&small, &bits, sizeof small);
        small += 0.5f;
        memcpy(&bits, &small, sizeof bits);
        return (uint16_t)(sign | (bits - 0x3f000000));
    }
    bits += 0xfff + (bits >> 13 & 1);
    return (uint16_t)(sign | (bits - 0x38000000) >> 13);
}

/* Stores in[0 .. count) times scale. */
CVOL_INLINE void cvol_store_half(uint16_t *out, const float *in, size_t count, float scale)
{
    size_t i = 0;
#if defined(__F16C__)
    for (; i + 8 <= count; i += 8)
        _mm_storeu_si128(
            (__m128i *)(void *)(out + i),
            _mm256_cvtps_ph(_mm256_mul_ps(_mm256_loadu_ps(in + i), _mm256_set1_ps(scale)),
                            _MM_FROUND_TO_NEAREST_INT));
#endif
    for (; i < count; i++)
        out[i] = cvol_half_of(in[i] * scale);
}

#endif
