/* The block cache of a frame: block_cache.h. */
#include "render/sheet/band/block_cache.h"

cvol_block_cache cvol_block_cache_open(cvol_block_cache_memory *memory, const cvol_sheet_plan *plan,
                                       const cvol_block_cache_limits *limits)
{
    /* A level's samples are copied with their covers, which are not stored. */
    const int has_cover = plan->level && plan->masked == CVOL_SHEET_SOME_VOID;
    return (cvol_block_cache){.stored = has_cover ? NULL
                                                  : cvol_block_store_open(&memory->store, plan,
                                                                          limits->blocks,
                                                                          limits->megabytes),
                              .exchange = cvol_block_exchange_open(&memory->exchange, plan,
                                                                   limits->threads, limits->spare)};
}

void cvol_block_cache_free(cvol_block_cache_memory *memory)
{
    cvol_block_store_free(&memory->store);
    cvol_block_exchange_free(&memory->exchange);
}

int cvol_block_cache_take(const cvol_block_cache *cache, const cvol_cached_block *block, void *out,
                          ptrdiff_t row_stride, ptrdiff_t sheet_stride)
{
    return cvol_block_store_take(cache->stored, block->index, out, row_stride, sheet_stride) ||
           (block->is_shared &&
            cvol_block_exchange_take(cache->exchange, block->place, block->index, out, row_stride,
                                     sheet_stride));
}

void cvol_block_cache_put(const cvol_block_cache *cache, const cvol_cached_block *block,
                          const void *samples, ptrdiff_t row_stride, ptrdiff_t sheet_stride)
{
    cvol_block_store_put(cache->stored, block->index, samples, row_stride, sheet_stride);
    if (block->is_shared)
        cvol_block_exchange_put(cache->exchange, block->place, block->index, samples, row_stride,
                                sheet_stride);
}

int cvol_block_cache_prefetch(const cvol_block_cache *cache, size_t index)
{
    return cvol_block_store_prefetch(cache->stored, index);
}
