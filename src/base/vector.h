/* Vectors of 16 floats in plain C: the compiler splits them where the machine's are shorter. */
#ifndef CVOL_BASE_VECTOR_H
#define CVOL_BASE_VECTOR_H

#include <stdint.h>
#include <string.h>

#if defined(__AVX2__) || defined(__AVX512F__)
#include <immintrin.h>
#endif

typedef float cvol_v16 __attribute__((vector_size(64)));
typedef int32_t cvol_i16 __attribute__((vector_size(64)));

#define CVOL_INLINE static inline __attribute__((always_inline))

/* Loads and stores at any address. */
CVOL_INLINE cvol_v16 cvol_load16(const float *from)
{
    cvol_v16 v;
    memcpy(&v, from, sizeof v);
    return v;
}

CVOL_INLINE void cvol_store16(float *to, cvol_v16 v)
{
    memcpy(to, &v, sizeof v);
}

/* All sixteen the same. */
CVOL_INLINE cvol_v16 cvol_splat16(float value)
{
    return value - (cvol_v16){0};
}

/* 0, 1, ... 15 */
CVOL_INLINE cvol_v16 cvol_iota16(void)
{
    return (cvol_v16){0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
}

/* mask ? a : b, for masks of 0 and -1 as comparisons give them. */
CVOL_INLINE cvol_v16 cvol_select16(cvol_i16 mask, cvol_v16 a, cvol_v16 b)
{
    return (cvol_v16)((mask & (cvol_i16)a) | (~mask & (cvol_i16)b));
}

CVOL_INLINE cvol_v16 cvol_min16(cvol_v16 a, cvol_v16 b)
{
    return cvol_select16(a < b, a, b);
}

CVOL_INLINE cvol_v16 cvol_max16(cvol_v16 a, cvol_v16 b)
{
    return cvol_select16(a > b, a, b);
}

/* 1 if any lane of a comparison's mask is set. */
CVOL_INLINE int cvol_any16(cvol_i16 mask)
{
#if defined(__AVX512F__)
    return _mm512_test_epi32_mask((__m512i)mask, (__m512i)mask) != 0;
#else
    int64_t parts[8];
    memcpy(parts, &mask, sizeof parts);
    return ((parts[0] | parts[1] | parts[2] | parts[3]) |
            (parts[4] | parts[5] | parts[6] | parts[7])) != 0;
#endif
}

/* Integers below 2^31 from floats, towards zero, and back. */
CVOL_INLINE cvol_i16 cvol_to_int16(cvol_v16 v)
{
    return __builtin_convertvector(v, cvol_i16);
}

CVOL_INLINE cvol_v16 cvol_to_float16(cvol_i16 v)
{
    return __builtin_convertvector(v, cvol_v16);
}

/* table[index[lane]] */
CVOL_INLINE cvol_i16 cvol_lookup16(const void *table, cvol_i16 index)
{
#if defined(__AVX512F__)
    return (cvol_i16)_mm512_i32gather_epi32((__m512i)index, table, 4);
#elif defined(__AVX2__)
    cvol_i16 result;
    __m256i half[2];
    memcpy(half, &index, sizeof half);
    half[0] = _mm256_i32gather_epi32((const int *)table, half[0], 4);
    half[1] = _mm256_i32gather_epi32((const int *)table, half[1], 4);
    memcpy(&result, half, sizeof half);
    return result;
#else
    cvol_i16 result;
    for (int lane = 0; lane < 16; lane++)
        result[lane] = ((const int32_t *)table)[index[lane]];
    return result;
#endif
}

/* lane k of the result: lane index[k] of the 32 that a and b make, 0 <= index < 32 */
CVOL_INLINE cvol_v16 cvol_shuffle16(cvol_v16 a, cvol_v16 b, cvol_i16 index)
{
#if defined(__AVX512F__)
    return (cvol_v16)_mm512_permutex2var_ps((__m512)a, (__m512i)index, (__m512)b);
#else
    float both[32];
    cvol_v16 result;
    memcpy(both, &a, sizeof a);
    memcpy(both + 16, &b, sizeof b);
    for (int lane = 0; lane < 16; lane++)
        result[lane] = both[index[lane]];
    return result;
#endif
}

#endif
