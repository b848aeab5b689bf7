/* Random numbers of tests: small, the same everywhere, from a seed that a failing test prints. */
#ifndef CVOL_TESTS_RANDOM_H
#define CVOL_TESTS_RANDOM_H

#include <stdint.h>

typedef struct random_state {
    uint64_t state;
} random_state;

/* splitmix64 (Steele, Lea and Flood 2014) */
static inline uint64_t random_u64(random_state *r)
{
    uint64_t z = r->state += UINT64_C(0x9E3779B97F4A7C15);
    z = (z ^ z >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ z >> 27) * UINT64_C(0x94D049BB133111EB);
    return z ^ z >> 31;
}

/* 0 .. below - 1 */
static inline uint32_t random_below(random_state *r, uint32_t below)
{
    return (uint32_t)((random_u64(r) >> 32) * below >> 32);
}

/* -1 .. 1 */
static inline double random_signed(random_state *r)
{
    return (double)(int64_t)random_u64(r) / 9223372036854775808.0;
}

#endif
