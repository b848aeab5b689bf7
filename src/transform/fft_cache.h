/* Plans of transforms, cached by key behind one lock. A plan in use is never destroyed: if the
 * cache is full of them, a new plan is freed after one execution. */
#ifndef CVOL_TRANSFORM_FFT_CACHE_H
#define CVOL_TRANSFORM_FFT_CACHE_H

#include <stddef.h>

/* Makes plans of a backend from a key, under the lock; NULL without memory. */
typedef struct cvol_fft_maker {
    size_t key_bytes;
    void *(*create)(const void *key, void *user);
    void (*destroy)(void *plan);
    size_t (*bytes)(const void *plan);
} cvol_fft_maker;

typedef struct cvol_fft_entry cvol_fft_entry;

/* A plan in use, and the scratch memory that its last user left, from malloc, or NULL. */
typedef struct cvol_fft_lease {
    cvol_fft_entry *entry; /* NULL without memory */
    void *plan, *scratch;
} cvol_fft_lease;

/* The key's plan, counted as in use. Keys are compared as bytes. One maker per process. `user` is
 * passed on to create. */
cvol_fft_lease cvol_fft_cache_acquire(const cvol_fft_maker *maker, const void *key, void *user);
/* Frees lease->scratch, or, if it is small, keeps it for the next user of the plan. */
void cvol_fft_cache_release(const cvol_fft_lease *lease, size_t scratch_bytes);

#endif
