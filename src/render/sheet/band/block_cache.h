/* The block cache of a frame: blocks of earlier pictures, and blocks that other bands evaluated.
 *
 * Lock-free: on a miss the thread evaluates the block itself, and puts it in for the others. It
 * changes speed, never pixels.
 */
#ifndef CVOL_RENDER_SHEET_BAND_BLOCK_CACHE_H
#define CVOL_RENDER_SHEET_BAND_BLOCK_CACHE_H

#include "render/sheet/band/block_exchange.h"
#include "render/sheet/band/block_store.h"

/* The memory of a renderer's cache; all zero is empty. */
typedef struct cvol_block_cache_memory {
    cvol_block_store store;
    cvol_block_exchange exchange;
} cvol_block_cache_memory;

/* A frame's: either may be NULL. */
typedef struct cvol_block_cache {
    cvol_block_set *stored;
    cvol_block_exchange *exchange;
} cvol_block_cache;

/* Limits of a cache. */
typedef struct cvol_block_cache_limits {
    size_t blocks;    /* of the array */
    double megabytes; /* for later pictures; 0: stores nothing for them */
    int threads;      /* that draw bands */
    size_t spare;     /* bytes for blocks that bands exchange */
} cvol_block_cache_limits;

/* Opens the cache of a plan before it is drawn. */
cvol_block_cache cvol_block_cache_open(cvol_block_cache_memory *memory, const cvol_sheet_plan *plan,
                                       const cvol_block_cache_limits *limits);
void cvol_block_cache_free(cvol_block_cache_memory *memory);

/* A block of a layer, as a key of the cache. */
typedef struct cvol_cached_block {
    size_t index, place; /* in the array; among those that bands exchange */
    int is_shared;       /* another band needs it, too */
} cvol_cached_block;

static inline cvol_cached_block cvol_cached_block_of(const cvol_block_cache *cache, size_t index,
                                                     size_t lane, size_t row, size_t layer,
                                                     int is_shared)
{
    return (cvol_cached_block){index, cvol_block_exchange_place(cache->exchange, lane, row, layer),
                               is_shared};
}

/* Copies a block into a view's memory, strides in samples; 0 if it is not cached. */
int cvol_block_cache_take(const cvol_block_cache *cache, const cvol_cached_block *block, void *out,
                          ptrdiff_t row_stride, ptrdiff_t sheet_stride);
/* Stores an evaluated block. Any number of threads may take and put. */
void cvol_block_cache_put(const cvol_block_cache *cache, const cvol_cached_block *block,
                          const void *samples, ptrdiff_t row_stride, ptrdiff_t sheet_stride);
/* Prefetches a block that will soon be taken; 0 if it is not stored from an earlier picture. */
int cvol_block_cache_prefetch(const cvol_block_cache *cache, size_t index);

#endif
