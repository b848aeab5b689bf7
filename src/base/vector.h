/* Vectors of CVOL_LANES floats in plain C, as long as the instruction set's own: 16, 8 or 4.
 * Kernels compute every element independently, so the length does not change a result. */
#ifndef CVOL_BASE_VECTOR_H
#define CVOL_BASE_VECTOR_H

#include <stdint.h>
#include <string.h>

#if defined(__AVX2__) || defined(__AVX512F__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h> /* immintrin.h takes 0.25 s to compile */
#elif defined(__wasm_simd128__)
#include <wasm_simd128.h>
#elif defined(__aarch64__) && defined(__ARM_NEON) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#include <arm_neon.h>
#define CVOL_NEON 1
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
#if defined(__wasm_simd128__)
    return (cvol_vf)wasm_v128_bitselect((v128_t)a, (v128_t)b, (v128_t)mask);
#elif defined(CVOL_NEON)
    return (cvol_vf)vbslq_f32((uint32x4_t)mask, (float32x4_t)a, (float32x4_t)b);
#else
    return (cvol_vf)((mask & (cvol_vi)a) | (~mask & (cvol_vi)b));
#endif
}

CVOL_INLINE cvol_vf cvol_min(cvol_vf a, cvol_vf b)
{
#if defined(__AVX512F__)
    return (cvol_vf)_mm512_min_ps((__m512)a, (__m512)b);
#elif defined(__AVX2__)
    return (cvol_vf)_mm256_min_ps((__m256)a, (__m256)b);
#elif defined(__SSE2__)
    return (cvol_vf)_mm_min_ps((__m128)a, (__m128)b);
#elif defined(__wasm_simd128__)
    return (cvol_vf)wasm_f32x4_pmin((v128_t)b, (v128_t)a); /* a < b ? a : b */
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
#elif defined(__SSE2__)
    return (cvol_vf)_mm_max_ps((__m128)a, (__m128)b);
#elif defined(__wasm_simd128__)
    return (cvol_vf)wasm_f32x4_pmax((v128_t)b, (v128_t)a); /* a > b ? a : b */
#else
    return cvol_select(a > b, a, b);
#endif
}

CVOL_INLINE cvol_vf cvol_sqrt(cvol_vf v)
{
#if defined(__AVX512F__)
    return (cvol_vf)_mm512_sqrt_ps((__m512)v);
#elif defined(__AVX2__)
    return (cvol_vf)_mm256_sqrt_ps((__m256)v);
#elif defined(__SSE2__)
    return (cvol_vf)_mm_sqrt_ps((__m128)v);
#elif defined(__wasm_simd128__)
    return (cvol_vf)wasm_f32x4_sqrt((v128_t)v);
#elif defined(CVOL_NEON)
    return (cvol_vf)vsqrtq_f32((float32x4_t)v);
#else
    for (int lane = 0; lane < CVOL_LANES; lane++)
        v[lane] = __builtin_sqrtf(v[lane]);
    return v;
#endif
}

/* 1 if any bit is set. */
CVOL_INLINE int cvol_any(cvol_vi mask)
{
#if defined(__AVX512F__)
    return _mm512_test_epi32_mask((__m512i)mask, (__m512i)mask) != 0;
#elif defined(__AVX2__)
    return !_mm256_testz_si256((__m256i)mask, (__m256i)mask);
#elif defined(__SSE2__)
    return _mm_movemask_epi8(_mm_cmpeq_epi32((__m128i)mask, _mm_setzero_si128())) != 0xffff;
#elif defined(__wasm_simd128__)
    return wasm_v128_any_true((v128_t)mask);
#elif defined(CVOL_NEON)
    return vmaxvq_u32((uint32x4_t)mask) != 0;
#else
    int64_t parts[2];
    memcpy(parts, &mask, sizeof parts);
    return (parts[0] | parts[1]) != 0;
#endif
}

/* One bit per lane of a comparison's mask. */
CVOL_INLINE uint32_t cvol_mask_bits(cvol_vi mask)
{
#if defined(__AVX512F__)
    return (uint32_t)_mm512_test_epi32_mask((__m512i)mask, (__m512i)mask);
#elif defined(__AVX2__)
    return (uint32_t)_mm256_movemask_ps((__m256)mask);
#elif defined(__SSE2__)
    return (uint32_t)_mm_movemask_ps((__m128)mask);
#elif defined(__wasm_simd128__)
    return wasm_i32x4_bitmask((v128_t)mask);
#else
    uint32_t bits = 0;
    for (int lane = 0; lane < CVOL_LANES; lane++)
        bits |= ((uint32_t)mask[lane] & 1) << lane;
    return bits;
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

/* Two table entries of 32 bits that are looked up together: one gather of 64 bits costs half of two
 * gathers of 32. */
typedef struct cvol_pair {
    float first;
    uint32_t second;
} cvol_pair;

/* table[index[lane]] */
CVOL_INLINE void cvol_lookup(cvol_vf *first, cvol_vi *second, const cvol_pair *table, cvol_vi index)
{
#if defined(__AVX512F__)
    const __m512i even = _mm512_set_epi32(30, 28, 26, 24, 22, 20, 18, 16, 14, 12, 10, 8, 6, 4, 2,
                                          0);
    const __m512i odd = _mm512_set_epi32(31, 29, 27, 25, 23, 21, 19, 17, 15, 13, 11, 9, 7, 5, 3, 1);
    __m512i low = _mm512_i32gather_epi64(_mm512_castsi512_si256((__m512i)index), table, 8);
    __m512i high = _mm512_i32gather_epi64(_mm512_extracti64x4_epi64((__m512i)index, 1), table, 8);
    *first = (cvol_vf)_mm512_permutex2var_epi32(low, even, high);
    *second = (cvol_vi)_mm512_permutex2var_epi32(low, odd, high);
#elif defined(__AVX2__)
    const long long *words = (const long long *)table;
    __m128i index_low = _mm256_castsi256_si128((__m256i)index);
    __m128i index_high = _mm256_extracti128_si256((__m256i)index, 1);
    __m256 low = (__m256)_mm256_i32gather_epi64(words, index_low, 8);
    __m256 high = (__m256)_mm256_i32gather_epi64(words, index_high, 8);
    __m256i even = (__m256i)_mm256_shuffle_ps(low, high, _MM_SHUFFLE(2, 0, 2, 0));
    __m256i odd = (__m256i)_mm256_shuffle_ps(low, high, _MM_SHUFFLE(3, 1, 3, 1));
    *first = (cvol_vf)_mm256_permute4x64_epi64(even, _MM_SHUFFLE(3, 1, 2, 0));
    *second = (cvol_vi)_mm256_permute4x64_epi64(odd, _MM_SHUFFLE(3, 1, 2, 0));
#elif defined(__wasm_simd128__)
    const v128_t low = wasm_v128_load64_lane(&table[index[1]],
                                             wasm_v128_load64_zero(&table[index[0]]), 1);
    const v128_t high = wasm_v128_load64_lane(&table[index[3]],
                                              wasm_v128_load64_zero(&table[index[2]]), 1);
    *first = (cvol_vf)wasm_i32x4_shuffle(low, high, 0, 2, 4, 6);
    *second = (cvol_vi)wasm_i32x4_shuffle(low, high, 1, 3, 5, 7);
#elif defined(CVOL_NEON)
    uint64_t pairs[4];
    for (int lane = 0; lane < 4; lane++)
        memcpy(&pairs[lane], &table[index[lane]], sizeof pairs[lane]);
    const uint32x4_t low = (uint32x4_t)(uint64x2_t){pairs[0], pairs[1]},
                     high = (uint32x4_t)(uint64x2_t){pairs[2], pairs[3]};
    *first = (cvol_vf)vuzp1q_u32(low, high);
    *second = (cvol_vi)vuzp2q_u32(low, high);
#else
    for (int lane = 0; lane < CVOL_LANES; lane++) {
        (*first)[lane] = table[index[lane]].first;
        (*second)[lane] = (int32_t)table[index[lane]].second;
    }
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
#elif defined(__wasm_simd128__)
    /* Of bytes: a number beyond 15 gives 0. */
    const v128_t bytes = (v128_t)(index * 0x04040404 + 0x03020100);
    return (cvol_vf)wasm_v128_or(
        wasm_i8x16_swizzle((v128_t)a, bytes),
        wasm_i8x16_swizzle((v128_t)b, wasm_i8x16_sub(bytes, wasm_i8x16_splat(16))));
#elif defined(CVOL_NEON)
    const uint8x16x2_t both = {{(uint8x16_t)a, (uint8x16_t)b}};
    return (cvol_vf)vqtbl2q_u8(both, (uint8x16_t)(index * 0x04040404 + 0x03020100));
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

/* Four floats, on every machine: the samples of one pixel. */
typedef float cvol_four __attribute__((vector_size(16)));

CVOL_INLINE cvol_four cvol_load_four(const float *from)
{
    cvol_four v;
    memcpy(&v, from, sizeof v);
    return v;
}

/* Two floats from each of two places. */
CVOL_INLINE cvol_four cvol_load_pairs(const float *low, const float *high)
{
#if defined(__SSE2__)
    double pairs[2]; /* may lie at any address */
    memcpy(&pairs[0], low, sizeof pairs[0]);
    memcpy(&pairs[1], high, sizeof pairs[1]);
    return (cvol_four)_mm_set_pd(pairs[1], pairs[0]);
#elif defined(__wasm_simd128__)
    return (cvol_four)wasm_v128_load64_lane(high, wasm_v128_load64_zero(low), 1);
#elif defined(CVOL_NEON)
    return (cvol_four)vcombine_f32(vld1_f32(low), vld1_f32(high));
#else
    return (cvol_four){low[0], low[1], high[0], high[1]};
#endif
}

/* The middle two of four floats, of two vectors. */
CVOL_INLINE cvol_four cvol_middle_of_fours(cvol_four a, cvol_four b)
{
#if defined(__SSE2__)
    return (cvol_four)_mm_shuffle_ps((__m128)a, (__m128)b, _MM_SHUFFLE(2, 1, 2, 1));
#else
    return (cvol_four){a[1], a[2], b[1], b[2]};
#endif
}

/* out[k], lane i: number k of in[i], for CVOL_LANES vectors `in`. */
CVOL_INLINE void cvol_transpose_fours(cvol_vf out[4], const cvol_four in[CVOL_LANES])
{
#if CVOL_LANES == 8
    __m256 pairs[4];
    for (int i = 0; i < 4; i++)
        pairs[i] = _mm256_insertf128_ps(_mm256_castps128_ps256((__m128)in[i]), (__m128)in[i + 4],
                                        1);
    const __m256 low[2] = {_mm256_unpacklo_ps(pairs[0], pairs[1]),
                           _mm256_unpacklo_ps(pairs[2], pairs[3])},
                 high[2] = {_mm256_unpackhi_ps(pairs[0], pairs[1]),
                            _mm256_unpackhi_ps(pairs[2], pairs[3])};
    out[0] = (cvol_vf)_mm256_shuffle_ps(low[0], low[1], _MM_SHUFFLE(1, 0, 1, 0));
    out[1] = (cvol_vf)_mm256_shuffle_ps(low[0], low[1], _MM_SHUFFLE(3, 2, 3, 2));
    out[2] = (cvol_vf)_mm256_shuffle_ps(high[0], high[1], _MM_SHUFFLE(1, 0, 1, 0));
    out[3] = (cvol_vf)_mm256_shuffle_ps(high[0], high[1], _MM_SHUFFLE(3, 2, 3, 2));
#elif CVOL_LANES == 16
    __m512 fours[4];
    for (int i = 0; i < 4; i++) {
        fours[i] = _mm512_castps128_ps512((__m128)in[i]);
        fours[i] = _mm512_insertf32x4(fours[i], (__m128)in[i + 4], 1);
        fours[i] = _mm512_insertf32x4(fours[i], (__m128)in[i + 8], 2);
        fours[i] = _mm512_insertf32x4(fours[i], (__m128)in[i + 12], 3);
    }
    const __m512 low[2] = {_mm512_unpacklo_ps(fours[0], fours[1]),
                           _mm512_unpacklo_ps(fours[2], fours[3])},
                 high[2] = {_mm512_unpackhi_ps(fours[0], fours[1]),
                            _mm512_unpackhi_ps(fours[2], fours[3])};
    out[0] = (cvol_vf)_mm512_shuffle_ps(low[0], low[1], _MM_SHUFFLE(1, 0, 1, 0));
    out[1] = (cvol_vf)_mm512_shuffle_ps(low[0], low[1], _MM_SHUFFLE(3, 2, 3, 2));
    out[2] = (cvol_vf)_mm512_shuffle_ps(high[0], high[1], _MM_SHUFFLE(1, 0, 1, 0));
    out[3] = (cvol_vf)_mm512_shuffle_ps(high[0], high[1], _MM_SHUFFLE(3, 2, 3, 2));
#elif defined(__SSE2__)
    const __m128 low[2] = {_mm_unpacklo_ps((__m128)in[0], (__m128)in[1]),
                           _mm_unpacklo_ps((__m128)in[2], (__m128)in[3])},
                 high[2] = {_mm_unpackhi_ps((__m128)in[0], (__m128)in[1]),
                            _mm_unpackhi_ps((__m128)in[2], (__m128)in[3])};
    out[0] = (cvol_vf)_mm_movelh_ps(low[0], low[1]);
    out[1] = (cvol_vf)_mm_movehl_ps(low[1], low[0]);
    out[2] = (cvol_vf)_mm_movelh_ps(high[0], high[1]);
    out[3] = (cvol_vf)_mm_movehl_ps(high[1], high[0]);
#elif defined(CVOL_NEON)
    const float32x4x2_t low = vzipq_f32((float32x4_t)in[0], (float32x4_t)in[2]),
                        high = vzipq_f32((float32x4_t)in[1], (float32x4_t)in[3]);
    const float32x4x2_t first = vzipq_f32(low.val[0], high.val[0]),
                        last = vzipq_f32(low.val[1], high.val[1]);
    out[0] = (cvol_vf)first.val[0];
    out[1] = (cvol_vf)first.val[1];
    out[2] = (cvol_vf)last.val[0];
    out[3] = (cvol_vf)last.val[1];
#else
    for (int k = 0; k < 4; k++)
        out[k] = (cvol_vf){in[0][k], in[1][k], in[2][k], in[3][k]};
#endif
}

/* Integers within least .. most. */
CVOL_INLINE cvol_vi cvol_clamp_int(cvol_vi v, int least, int most)
{
    const cvol_vi below = v < least;
    v = (below & least) | (~below & v);
    const cvol_vi above = v > most;
    return (above & most) | (~above & v);
}

#endif
