/* Common code of tests of kernels (support_kernels.h). */
#include "test.h"

#include "base/memory.h"
#include "support_kernels.h"

enum { GUARD = 128, ALIGNMENT = 64 };

static uint64_t seed = 1;

void kernels_print_sets(void)
{
#if defined(__x86_64__)
    const int last = CVOL_CPU_AVX512;
#else
    const int last = CVOL_CPU_BASE;
    print_message("this processor has one instruction set: %s\n", cvol_cpu_name(CVOL_CPU_BASE));
#endif
    for (int set = (int)cvol_cpu_best() + 1; set <= last; set++)
        print_message("skipped: %s, which this processor does not have (or CVOL_CPU turns off)\n",
                      cvol_cpu_name((cvol_cpu)set));
#if defined(CVOL_WITHOUT_AVX2)
    print_message("skipped: avx2, which this build does not have\n");
#elif defined(CVOL_WITHOUT_AVX512)
    print_message("skipped: avx512, which this build does not have\n");
#endif
}

void kernels_begin(void)
{
    const char *chosen = getenv("CVOL_TEST_SEED");
    if (chosen)
        seed = strtoull(chosen, NULL, 10);
    print_message("seed %llu\n", (unsigned long long)seed);
    kernels_print_sets();
}

random_state kernels_random(uint64_t number)
{
    random_state r = {seed * UINT64_C(0x9E3779B97F4A7C15) + number};
    r.state = random_u64(&r);
    return r;
}

int kernels_count(size_t count)
{
    const size_t has = (size_t)cvol_cpu_best() + 1;
    return (int)(count < has ? count : has);
}

/* ---- guarded memory ------------------------------------------------------------------------- */

/* Stored before the first guard. */
typedef struct header {
    size_t bytes;
    unsigned char *allocated;
} header;

static header *header_of(const void *memory)
{
    return (header *)(void *)((unsigned char *)(uintptr_t)memory - GUARD - ALIGNMENT);
}

static void fill(unsigned char *bytes, size_t count)
{
    random_state r = kernels_random(count);
    for (size_t i = 0; i < count; i++)
        bytes[i] = (unsigned char)(random_u64(&r) >> 32);
}

void *kernels_memory(size_t bytes)
{
    unsigned char *allocated = cvol_allocate(bytes + 2 * GUARD + 2 * ALIGNMENT, 1);
    assert_non_null(allocated);
    unsigned char *memory = allocated + ALIGNMENT + GUARD;
    *header_of(memory) = (header){bytes, allocated};
    fill(memory - GUARD, bytes + 2 * GUARD);
    return memory;
}

void kernels_refill(void *memory)
{
    fill((unsigned char *)memory - GUARD, header_of(memory)->bytes + 2 * GUARD);
}

void kernels_check_guards(const void *memory, const char *what, int set)
{
    const size_t bytes = header_of(memory)->bytes;
    unsigned char *expected = malloc(bytes + 2 * GUARD);
    const unsigned char *found = (const unsigned char *)memory - GUARD;
    assert_non_null(expected);
    fill(expected, bytes + 2 * GUARD);
    for (size_t i = 0; i < bytes + 2 * GUARD; i++)
        if (found[i] != expected[i] && (i < GUARD || i >= GUARD + bytes))
            fail_msg("%s, %s: byte %ld of %zu was overwritten", what, cvol_cpu_name((cvol_cpu)set),
                     (long)i - GUARD, bytes);
    free(expected);
}

void kernels_free(void *memory)
{
    free(header_of(memory)->allocated);
}

/* ---- comparisons ---------------------------------------------------------------------------- */

void kernels_expect_same(const void *found, const void *expected, size_t bytes, const char *what,
                         int set)
{
    const unsigned char *a = found, *b = expected;
    for (size_t i = 0; i < bytes; i++)
        if (a[i] != b[i])
            fail_msg("%s, %s: byte %zu of %zu is %d, not %d", what, cvol_cpu_name((cvol_cpu)set), i,
                     bytes, a[i], b[i]);
}

void kernels_expect_near(const float *found, const double *expected, const double *error,
                         size_t count, const char *what, int set)
{
    for (size_t i = 0; i < count; i++)
        if (!(fabs((double)found[i] - expected[i]) <= error[i]))
            fail_msg("%s, %s: number %zu of %zu is %.9g, not %.9g, at most %.3g off", what,
                     cvol_cpu_name((cvol_cpu)set), i, count, (double)found[i], expected[i],
                     error[i]);
}
