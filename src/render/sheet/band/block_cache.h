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
    cvol_stored_kind *stored;
    cvol_block_exchange *exchange;
} cvol_block_cache;

/* How much a cache may hold. */
typedef struct cvol_block_cache_limits {
    size_t blocks;    /* of the array */
    double megabytes; /* for the next pictures; 0: nothing is stored for them */
    int threads;      /* that draw bands */
    size_t spare;     /* bytes for blocks that bands exchange */
} cvol_block_cache_limits;

/* The cache of a plan that is about to be drawn. */
cvol_block_cache cvol_block_cache_open(cvol_block_cache_memory *memory, const cvol_sheet_plan *plan,
                                       const cvol_block_cache_limits *limits);
void cvol_block_cache_free(cvol_block_cache_memory *memory);

/* A block of a layer, as the cache finds it. */
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

/* Copies a block to where a view wants it, strides in samples; 0 if it is not cached. */
int cvol_block_cache_take(const cvol_block_cache *cache, const cvol_cached_block *block, void *out,
                          long row_stride, long sheet_stride);
/* Puts in a block that was evaluated. Any number of threads may take and put. */
void cvol_block_cache_put(const cvol_block_cache *cache, const cvol_cached_block *block,
                          const void *samples, long row_stride, long sheet_stride);
/* Asks for a block that will be taken soon; 0 if no earlier picture left it. */
int cvol_block_cache_prefetch(const cvol_block_cache *cache, size_t index);

#endif
