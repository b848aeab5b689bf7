/* Plans of transforms, kept by key behind one lock. A plan in use is never destroyed: if the cache
 * is full of them, a new plan lives for one execution only. */
#ifndef CVOL_TRANSFORM_FFT_CACHE_H
#define CVOL_TRANSFORM_FFT_CACHE_H

#include <stddef.h>

/* How the plans of a backend are made, under the lock, from a key; NULL without memory. */
typedef struct cvol_fft_maker {
    size_t key_bytes;
    void *(*create)(const void *key, void *user);
    void (*destroy)(void *plan);
    size_t (*bytes)(const void *plan);
} cvol_fft_maker;

typedef struct cvol_fft_entry cvol_fft_entry;

/* The key's entry, counted as in use; NULL without memory. Keys are compared as bytes. One maker a
 * process. `user` is passed on to create. */
cvol_fft_entry *cvol_fft_cache_acquire(const cvol_fft_maker *maker, const void *key, void *user);
void cvol_fft_cache_release(cvol_fft_entry *entry);
void *cvol_fft_entry_plan(const cvol_fft_entry *entry);

#endif
