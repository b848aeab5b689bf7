/* Vectors of CVOL_LANES floats in plain C, as long as the instruction set's own: 16, 8 or 4.
 * Kernels written on them compute every element by itself, so the length does not change a result.
 */
#ifndef CVOL_BASE_VECTOR_H
#define CVOL_BASE_VECTOR_H

#include <stdint.h>
#include <string.h>

#if defined(__AVX2__) || defined(__AVX512F__)
#include <immintrin.h>
#endif

#if defined(__AVX512F__)
#define CVOL_LANES 16
#elif defined(__AVX2__)
#define CVOL_LANES 8
#else
#define CVOL_LANES 4
#endif

typedef float cvol_vf __attribute__((vector_size(4 * CVOL_LANES)));
typedef int32_t cvol_vi __attribute__((vector_size(4 * CVOL_LANES)));

#define CVOL_INLINE static inline __attribute__((always_inline))

/* Loads and stores at any address. */
CVOL_INLINE cvol_vf cvol_load(const float *from)
{
    cvol_vf v;
    memcpy(&v, from, sizeof v);
    return v;
}

CVOL_INLINE void cvol_store(float *to, cvol_vf v)
{
    memcpy(to, &v, sizeof v);
}

/* Stores the first `lanes` lanes, 0 <= lanes <= CVOL_LANES. */
CVOL_INLINE void cvol_store_first(float *to, cvol_vf v, int lanes)
{
#if defined(__AVX512F__)
    _mm512_mask_storeu_ps(to, (__mmask16)((1u << lanes) - 1), (__m512)v);
#else
    for (int lane = 0; lane < lanes; lane++)
        to[lane] = v[lane];
#endif
}

/* All lanes the same. */
CVOL_INLINE cvol_vf cvol_splat(float value)
{
    return value - (cvol_vf){0};
}

/* 0, 1, 2, ... */
CVOL_INLINE cvol_vf cvol_iota(void)
{
#if CVOL_LANES == 16
    return (cvol_vf){0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
#elif CVOL_LANES == 8
    return (cvol_vf){0, 1, 2, 3, 4, 5, 6, 7};
#else
    return (cvol_vf){0, 1, 2, 3};
#endif
}

/* mask ? a : b, for masks of 0 and -1 as comparisons give them. */
CVOL_INLINE cvol_vf cvol_select(cvol_vi mask, cvol_vf a, cvol_vf b)
{
    return (cvol_vf)((mask & (cvol_vi)a) | (~mask & (cvol_vi)b));
}

CVOL_INLINE cvol_vf cvol_min(cvol_vf a, cvol_vf b)
{
#if defined(__AVX512F__)
    return (cvol_vf)_mm512_min_ps((__m512)a, (__m512)b);
#elif defined(__AVX2__)
    return (cvol_vf)_mm256_min_ps((__m256)a, (__m256)b);
#else
    return cvol_select(a < b, a, b);
#endif
}

CVOL_INLINE cvol_vf cvol_max(cvol_vf a, cvol_vf b)
{
#if defined(__AVX512F__)
    return (cvol_vf)_mm512_max_ps((__m512)a, (__m512)b);
#elif defined(__AVX2__)
    return (cvol_vf)_mm256_max_ps((__m256)a, (__m256)b);
#else
    return cvol_select(a > b, a, b);
#endif
}

/* 1 if any lane of a comparison's mask is set. */
CVOL_INLINE int cvol_any(cvol_vi mask)
{
#if defined(__AVX512F__)
    return _mm512_test_epi32_mask((__m512i)mask, (__m512i)mask) != 0;
#elif defined(__AVX2__)
    return !_mm256_testz_si256((__m256i)mask, (__m256i)mask);
#else
    int64_t parts[2];
    memcpy(parts, &mask, sizeof parts);
    return (parts[0] | parts[1]) != 0;
#endif
}

/* Integers below 2^31 from floats, towards zero, and back. */
CVOL_INLINE cvol_vi cvol_to_int(cvol_vf v)
{
    return __builtin_convertvector(v, cvol_vi);
}

CVOL_INLINE cvol_vf cvol_to_float(cvol_vi v)
{
    return __builtin_convertvector(v, cvol_vf);
}

/* table[index[lane]], words of 32 bits */
CVOL_INLINE cvol_vi cvol_lookup(const void *table, cvol_vi index)
{
#if defined(__AVX512F__)
    return (cvol_vi)_mm512_i32gather_epi32((__m512i)index, table, 4);
#elif defined(__AVX2__)
    return (cvol_vi)_mm256_i32gather_epi32((const int *)table, (__m256i)index, 4);
#else
    cvol_vi result;
    for (int lane = 0; lane < CVOL_LANES; lane++)
        result[lane] = ((const int32_t *)table)[index[lane]];
    return result;
#endif
}

/* lane k of the result: lane index[k] of the 2 CVOL_LANES that a and b make */
CVOL_INLINE cvol_vf cvol_shuffle(cvol_vf a, cvol_vf b, cvol_vi index)
{
#if defined(__AVX512F__)
    return (cvol_vf)_mm512_permutex2var_ps((__m512)a, (__m512i)index, (__m512)b);
#elif defined(__AVX2__)
    __m256 from_a = _mm256_permutevar8x32_ps((__m256)a, (__m256i)index);
    __m256 from_b = _mm256_permutevar8x32_ps((__m256)b, (__m256i)index);
    return cvol_select(index > 7, (cvol_vf)from_b, (cvol_vf)from_a);
#else
    float both[2 * CVOL_LANES];
    cvol_vf result;
    memcpy(both, &a, sizeof a);
    memcpy(both + CVOL_LANES, &b, sizeof b);
    for (int lane = 0; lane < CVOL_LANES; lane++)
        result[lane] = both[index[lane]];
    return result;
#endif
}

#endif
