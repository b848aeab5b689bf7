/* Vectors of doubles, as long as the instruction set's own: every element is computed
 * independently, so the length does not change a result. */
#ifndef CVOL_BASE_VECTOR_DOUBLE_H
#define CVOL_BASE_VECTOR_DOUBLE_H

#include "base/vector.h"

#define CVOL_VD_LANES (CVOL_LANES / 2)

typedef double cvol_vd __attribute__((vector_size(4 * CVOL_LANES)));
typedef int64_t cvol_vl __attribute__((vector_size(4 * CVOL_LANES)));
typedef float cvol_vd_floats __attribute__((vector_size(2 * CVOL_LANES)));
typedef int32_t cvol_vd_ints __attribute__((vector_size(2 * CVOL_LANES)));

CVOL_INLINE cvol_vd cvol_vd_splat(double value)
{
    return value - (cvol_vd){0};
}

/* a > b ? a : b, so b where a is NaN */
CVOL_INLINE cvol_vd cvol_vd_above(cvol_vd a, cvol_vd b)
{
#if defined(__AVX512F__)
    return (cvol_vd)_mm512_max_pd((__m512d)a, (__m512d)b);
#elif defined(__AVX2__)
    return (cvol_vd)_mm256_max_pd((__m256d)a, (__m256d)b);
#else
    const cvol_vl mask = a > b;
    return (cvol_vd)((mask & (cvol_vl)a) | (~mask & (cvol_vl)b));
#endif
}

/* a < b ? a : b */
CVOL_INLINE cvol_vd cvol_vd_below(cvol_vd a, cvol_vd b)
{
#if defined(__AVX512F__)
    return (cvol_vd)_mm512_min_pd((__m512d)a, (__m512d)b);
#elif defined(__AVX2__)
    return (cvol_vd)_mm256_min_pd((__m256d)a, (__m256d)b);
#else
    const cvol_vl mask = a < b;
    return (cvol_vd)((mask & (cvol_vl)a) | (~mask & (cvol_vl)b));
#endif
}

CVOL_INLINE cvol_vd cvol_vd_size(cvol_vd a)
{
    return (cvol_vd)((cvol_vl)a & INT64_MAX);
}

/* floor of numbers below 2^51: adding 3 2^51 rounds to a whole number. */
CVOL_INLINE cvol_vd cvol_vd_floor(cvol_vd a)
{
    const cvol_vd near = (a + 0x3p51) - 0x3p51;
    const cvol_vl over = near > a;
    return near - (cvol_vd)(over & (cvol_vl)cvol_vd_splat(1));
}

CVOL_INLINE cvol_vd cvol_vd_load(const double *from)
{
    cvol_vd v;
    memcpy(&v, from, sizeof v);
    return v;
}

CVOL_INLINE void cvol_vd_store(double *to, cvol_vd v)
{
    memcpy(to, &v, sizeof v);
}

CVOL_INLINE cvol_vd cvol_vd_load_floats(const float *from)
{
    cvol_vd_floats v;
    memcpy(&v, from, sizeof v);
    return __builtin_convertvector(v, cvol_vd);
}

/* The first and the last lanes of floats in double precision. */
CVOL_INLINE void cvol_vd_widen(cvol_vd *first, cvol_vd *last, cvol_vf v)
{
#if defined(__AVX512F__)
    *first = (cvol_vd)_mm512_cvtps_pd(_mm512_castps512_ps256((__m512)v));
    *last = (cvol_vd)_mm512_cvtps_pd(_mm512_extractf32x8_ps((__m512)v, 1));
#elif defined(__AVX2__)
    *first = (cvol_vd)_mm256_cvtps_pd(_mm256_castps256_ps128((__m256)v));
    *last = (cvol_vd)_mm256_cvtps_pd(_mm256_extractf128_ps((__m256)v, 1));
#elif defined(__SSE2__)
    *first = (cvol_vd)_mm_cvtps_pd((__m128)v);
    *last = (cvol_vd)_mm_cvtps_pd(_mm_movehl_ps((__m128)v, (__m128)v));
#else
    cvol_vd_floats half[2];
    memcpy(half, &v, sizeof v);
    *first = __builtin_convertvector(half[0], cvol_vd);
    *last = __builtin_convertvector(half[1], cvol_vd);
#endif
}

/* Loads numbers of another type; integers of less than 32 bits are widened to 32 first. */
#define CVOL_VD_LOAD_SMALL(to, from, type)                                                      \
    do {                                                                                        \
        typedef type small_lanes __attribute__((vector_size(CVOL_VD_LANES * sizeof(type))));    \
        small_lanes lanes_;                                                                     \
        memcpy(&lanes_, from, sizeof lanes_);                                                   \
        (to) = __builtin_convertvector(__builtin_convertvector(lanes_, cvol_vd_ints), cvol_vd); \
    } while (0)
#define CVOL_VD_LOAD_TYPE(to, from, type)                                                    \
    do {                                                                                     \
        typedef type large_lanes __attribute__((vector_size(CVOL_VD_LANES * sizeof(type)))); \
        large_lanes lanes_;                                                                  \
        memcpy(&lanes_, from, sizeof lanes_);                                                \
        (to) = __builtin_convertvector(lanes_, cvol_vd);                                     \
    } while (0)

/* Rounds half up, within lo .. hi; NaN becomes lo. */
CVOL_INLINE cvol_vd cvol_vd_as_integers(cvol_vd real, double lo, double hi)
{
    return cvol_vd_floor(
        cvol_vd_below(cvol_vd_above(real + 0.5, cvol_vd_splat(lo)), cvol_vd_splat(hi)));
}

#endif
