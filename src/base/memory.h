/* Aligned memory and size arithmetic that detects overflow. */
#ifndef CVOL_BASE_MEMORY_H
#define CVOL_BASE_MEMORY_H

#include <stddef.h>
#include <stdlib.h>

/* Vectors of 16 floats are the widest loads of kernels. */
#define CVOL_ALIGNMENT 64
/* Of allocated memory; less on Windows (windows/posix.h). Sizes are multiples of CVOL_ALIGNMENT. */
#ifndef CVOL_ALLOCATED_ALIGNMENT
#define CVOL_ALLOCATED_ALIGNMENT CVOL_ALIGNMENT
#endif

/* *out = a b; 1 if it fits into a size_t, 0 (and *out = 0) if not. */
static inline int cvol_size_multiply(size_t *out, size_t a, size_t b)
{
    if (__builtin_mul_overflow(a, b, out)) {
        *out = 0;
        return 0;
    }
    return 1;
}

/* *out = a + b; 1 if it fits into a size_t, 0 (and *out = 0) if not. */
static inline int cvol_size_add(size_t *out, size_t a, size_t b)
{
    if (__builtin_add_overflow(a, b, out)) {
        *out = 0;
        return 0;
    }
    return 1;
}

/* count elements of `size` bytes, CVOL_ALLOCATED_ALIGNMENT aligned; NULL on overflow or lack of
 * memory. Never NULL for count 0. Freed with free(). */
void *cvol_allocate(size_t count, size_t size);
/* The same, all zero. */
void *cvol_allocate_zero(size_t count, size_t size);
/* Grows *memory (a pointer to any object pointer) to `count` elements, all zero; the old content is
 * lost. 0 without memory. */
int cvol_ensure(void *memory, size_t *capacity, size_t count, size_t size);

#endif
