/* The instruction set of the kernels. A kernel file (*_simd.c) is compiled once per set.
 * CVOL_SIMD(name) gives its functions the set's suffix, CVOL_SIMD_DECLARE declares them, and
 * CVOL_SIMD_CHOOSE selects one; CVOL_SIMD_SETS lists all sets, by cvol_cpu. The environment
 * variable CVOL_CPU (base, avx2, avx512) forces a set that the processor has. */
#ifndef CVOL_BASE_CPU_H
#define CVOL_BASE_CPU_H

typedef enum cvol_cpu { CVOL_CPU_BASE = 0, CVOL_CPU_AVX2 = 1, CVOL_CPU_AVX512 = 2 } cvol_cpu;

/* The best set of this processor, or the forced one. */
cvol_cpu cvol_cpu_best(void);
/* "base", "avx2", "avx512". */
const char *cvol_cpu_name(cvol_cpu cpu);

#define CVOL_SIMD_PASTE2(name, set) name##_##set
#define CVOL_SIMD_PASTE(name, set) CVOL_SIMD_PASTE2(name, set)
#define CVOL_SIMD(name) CVOL_SIMD_PASTE(name, CVOL_SIMD_SET)

#if !defined(__x86_64__) || \
    defined(CVOL_BASE_SET_ONLY) /* the latter on Windows, cmake/flags.cmake */
#define CVOL_SIMD_DECLARE(result, name, arguments) result name##_base arguments
#define CVOL_SIMD_CHOOSE(name) (name##_base)
#define CVOL_SIMD_SETS(name) \
    {                        \
        name##_base          \
    }
#elif defined(CVOL_WITHOUT_AVX2) /* as sanitized, cmake/flags.cmake */
#define CVOL_SIMD_DECLARE(result, name, arguments) \
    result name##_base arguments;                  \
    result name##_avx512 arguments
#define CVOL_SIMD_CHOOSE(name) (cvol_cpu_best() == CVOL_CPU_AVX512 ? name##_avx512 : name##_base)
#define CVOL_SIMD_SETS(name)                    \
    {                                           \
        name##_base, name##_base, name##_avx512 \
    }
#elif defined(CVOL_WITHOUT_AVX512) /* the same */
#define CVOL_SIMD_DECLARE(result, name, arguments) \
    result name##_base arguments;                  \
    result name##_avx2 arguments
#define CVOL_SIMD_CHOOSE(name) (cvol_cpu_best() >= CVOL_CPU_AVX2 ? name##_avx2 : name##_base)
#define CVOL_SIMD_SETS(name)                  \
    {                                         \
        name##_base, name##_avx2, name##_avx2 \
    }
#else
#define CVOL_SIMD_DECLARE(result, name, arguments) \
    result name##_base arguments;                  \
    result name##_avx2 arguments;                  \
    result name##_avx512 arguments
#define CVOL_SIMD_CHOOSE(name)                          \
    (cvol_cpu_best() == CVOL_CPU_AVX512 ? name##_avx512 \
     : cvol_cpu_best() == CVOL_CPU_AVX2 ? name##_avx2   \
                                        : name##_base)
#define CVOL_SIMD_SETS(name)                    \
    {                                           \
        name##_base, name##_avx2, name##_avx512 \
    }
#endif

#endif
