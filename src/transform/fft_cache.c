/* The plans that the last transforms used (fft_cache.h). */
#include "transform/fft_cache.h"

#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Limits of unused plans, by number and bytes; the last one always stays. */
#define MAX_PLANS 256
#define MAX_BYTES ((size_t)128 << 20)
/* Larger scratch is freed: its allocation takes little time compared with the transform. */
#define MAX_SCRATCH ((size_t)64 << 10)

struct cvol_fft_entry {
    const cvol_fft_maker *maker;
    void *key, *plan, *scratch;
    size_t bytes, users; /* executions in progress */
    uint64_t last_used;  /* time of the last use, counted in calls */
    int cached;
};

static pthread_mutex_t cache_lock = PTHREAD_MUTEX_INITIALIZER;
static cvol_fft_entry *cache[MAX_PLANS];
static size_t cache_count, cache_bytes;
static uint64_t cache_calls;
static pthread_once_t fork_once = PTHREAD_ONCE_INIT;

static void lock_cache(void)
{
    pthread_mutex_lock(&cache_lock);
}

static void unlock_cache(void)
{
    pthread_mutex_unlock(&cache_lock);
}

/* A child of fork must not inherit a lock that a thread of its parent holds. */
static void register_locks(void)
{
    (void)pthread_atfork(lock_cache, unlock_cache, unlock_cache);
}

/* ---- functions under the lock --------------------------------------------------------------- */

static cvol_fft_entry *find_entry(const cvol_fft_maker *maker, const void *key)
{
    for (size_t i = 0; i < cache_count; i++)
        if (!memcmp(cache[i]->key, key, maker->key_bytes))
            return cache[i];
    return NULL;
}

static void destroy_entry(cvol_fft_entry *entry)
{
    if (entry->plan)
        entry->maker->destroy(entry->plan);
    free(entry->scratch);
    free(entry->key);
    free(entry);
}

static cvol_fft_entry *create_entry(const cvol_fft_maker *maker, const void *key, void *user)
{
    cvol_fft_entry *entry = calloc(1, sizeof *entry);
    if (!entry)
        return NULL;
    entry->maker = maker;
    entry->key = malloc(maker->key_bytes);
    if (entry->key)
        memcpy(entry->key, key, maker->key_bytes);
    entry->plan = entry->key ? maker->create(key, user) : NULL;
    if (entry->plan) {
        entry->bytes = maker->bytes(entry->plan);
        return entry;
    }
    destroy_entry(entry);
    return NULL;
}

/* Destroys the entry whose last use is the longest ago; 0 if all are in use. */
static int drop_oldest(void)
{
    size_t at = cache_count;
    for (size_t i = 0; i < cache_count; i++)
        if (!cache[i]->users && (at == cache_count || cache[i]->last_used < cache[at]->last_used))
            at = i;
    if (at == cache_count)
        return 0;
    cache_bytes -= cache[at]->bytes;
    destroy_entry(cache[at]);
    cache[at] = cache[--cache_count];
    return 1;
}

static void keep_entry(cvol_fft_entry *entry)
{
    while (cache_count == MAX_PLANS || (cache_count && cache_bytes + entry->bytes > MAX_BYTES))
        if (!drop_oldest())
            break;
    if (cache_count == MAX_PLANS)
        return;
    entry->cached = 1;
    cache_bytes += entry->bytes;
    cache[cache_count++] = entry;
}

/* ---- entries -------------------------------------------------------------------------------- */

cvol_fft_lease cvol_fft_cache_acquire(const cvol_fft_maker *maker, const void *key, void *user)
{
    cvol_fft_lease lease = {.entry = NULL};
    pthread_once(&fork_once, register_locks);
    lock_cache();
    cvol_fft_entry *entry = find_entry(maker, key);
    if (!entry) {
        entry = create_entry(maker, key, user);
        if (entry)
            keep_entry(entry);
    }
    if (entry) {
        entry->users++;
        entry->last_used = ++cache_calls;
        lease = (cvol_fft_lease){entry, entry->plan, entry->scratch};
        entry->scratch = NULL;
    }
    unlock_cache();
    return lease;
}

void cvol_fft_cache_release(const cvol_fft_lease *lease, size_t scratch_bytes)
{
    cvol_fft_entry *entry = lease->entry;
    void *unused = lease->scratch;
    lock_cache();
    entry->users--;
    if (!entry->cached) {
        destroy_entry(entry);
    } else if (!entry->scratch && scratch_bytes <= MAX_SCRATCH) {
        entry->scratch = unused;
        unused = NULL;
    }
    unlock_cache();
    free(unused);
}
