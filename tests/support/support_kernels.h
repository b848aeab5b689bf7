/* Common code of tests of kernels: the instruction sets, the seed, and memory between guards. */
#ifndef CVOL_TESTS_SUPPORT_KERNELS_H
#define CVOL_TESTS_SUPPORT_KERNELS_H

#include <stddef.h>
#include <stdint.h>

#include "base/cpu.h"
#include "random.h"

/* Prints the instruction sets that a test of kernels skips, and why. */
void kernels_print_sets(void);
/* The same, and the seed of random data: 1, or the environment variable CVOL_TEST_SEED. */
void kernels_begin(void);
/* Random numbers of one case: they depend only on the seed and on the case. */
random_state kernels_random(uint64_t number);
/* The number of the `count` sets, in the order of CVOL_SIMD_SETS, that this processor has. */
int kernels_count(size_t count);

/* The same for an array that CVOL_SIMD_SETS initialises. */
#define KERNELS_SETS(sets) kernels_count(sizeof(sets) / sizeof *(sets))

/* Memory of `bytes` bytes, 64-byte aligned, between guards of random bytes. Its own bytes are
 * random, too, the same in every allocation of this size. */
void *kernels_memory(size_t bytes);
/* The test fails if a byte of a guard has changed. */
void kernels_check_guards(const void *memory, const char *what, int set);
/* Fills memory with its initial bytes. */
void kernels_refill(void *memory);
void kernels_free(void *memory);

/* The test fails unless the bytes of both are the same. */
void kernels_expect_same(const void *found, const void *expected, size_t bytes, const char *what,
                         int set);
/* The test fails if a float differs from the expected one by more than the value in `error`. */
void kernels_expect_near(const float *found, const double *expected, const double *error,
                         size_t count, const char *what, int set);

#endif
