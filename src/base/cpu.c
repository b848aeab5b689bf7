/* Processor detection. */
#include "base/cpu.h"
#include "base/cpu_force.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

static const char *const names[] = {"base", "avx2", "avx512"};

static cvol_cpu best;
static pthread_once_t best_once = PTHREAD_ONCE_INIT;

static cvol_cpu detect(void)
{
#if defined(__x86_64__) && !defined(CVOL_BASE_SET_ONLY)
    __builtin_cpu_init();
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma"))
        return CVOL_CPU_BASE;
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        return CVOL_CPU_AVX512;
    return CVOL_CPU_AVX2;
#else
    return CVOL_CPU_BASE;
#endif
}

static void choose(void)
{
    best = detect();
    const char *forced = getenv("CVOL_CPU");
    for (int cpu = CVOL_CPU_BASE; forced && cpu <= (int)best; cpu++)
        if (!strcmp(forced, names[cpu])) {
            best = (cvol_cpu)cpu;
            return;
        }
}

cvol_cpu cvol_cpu_best(void)
{
    pthread_once(&best_once, choose);
    return best;
}

void cvol_cpu_force(int cpu)
{
    pthread_once(&best_once, choose);
    best = (cvol_cpu)cpu;
}

const char *cvol_cpu_name(cvol_cpu cpu)
{
    return names[cpu];
}
