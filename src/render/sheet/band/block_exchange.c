/* Exchange of blocks between bands: see block_exchange.h. */
#include "render/sheet/band/block_exchange.h"

#include <stdlib.h>

#include "base/memory.h"

/* The most rows of blocks between two bands, and the layers for which they are stored. */
#define ROWS 6
#define LAYERS 4

/* The number of layers that fit; 0: none. */
static size_t choose_places(cvol_block_exchange *exchange, const cvol_sheet_plan *plan, int threads,
                            size_t most)
{
    const size_t between = ROWS * (size_t)(threads - 1);
    exchange->shape = cvol_packed_block_of(plan);
    exchange->bytes = cvol_packed_block_bytes(&exchange->shape);
    exchange->lanes = plan->blocks_lane;
    exchange->rows = between < plan->blocks_row ? between : plan->blocks_row;
    const size_t layer = exchange->lanes * exchange->rows,
                 layers = most / (layer * (exchange->bytes + sizeof(cvol_exchanged_block)));
    exchange->layers = layers < LAYERS ? layers : LAYERS;
    return layer * exchange->layers;
}

cvol_block_exchange *cvol_block_exchange_open(cvol_block_exchange *exchange,
                                              const cvol_sheet_plan *plan, int threads, size_t most)
{
    if (threads < 2 || plan->level) /* a level's samples already exist */
        return NULL;
    const size_t count = choose_places(exchange, plan, threads, most);
    if (count == 0 ||
        !cvol_ensure(&exchange->blocks, &exchange->block_capacity, count,
                     sizeof *exchange->blocks) ||
        !cvol_ensure(&exchange->samples, &exchange->sample_capacity, count * exchange->bytes, 1))
        return NULL;
    for (size_t i = 0; i < count; i++) {
        atomic_init(&exchange->blocks[i].readers, 0);
        exchange->blocks[i].block = SIZE_MAX;
    }
    return exchange;
}

void cvol_block_exchange_free(cvol_block_exchange *exchange)
{
    free(exchange->blocks);
    free(exchange->samples);
}

int cvol_block_exchange_take(cvol_block_exchange *exchange, size_t place, size_t index, void *out,
                             ptrdiff_t row_stride, ptrdiff_t sheet_stride)
{
    if (!exchange)
        return 0;
    cvol_exchanged_block *blocks = &exchange->blocks[place];
    int readers = atomic_load_explicit(&blocks->readers, memory_order_relaxed);
    do
        if (readers < 0)
            return 0;
    while (!atomic_compare_exchange_weak_explicit(&blocks->readers, &readers, readers + 1,
                                                  memory_order_acquire, memory_order_relaxed));
    const int is_there = blocks->block == index;
    if (is_there)
        cvol_packed_block_take(out, exchange->samples + place * exchange->bytes, &exchange->shape,
                               row_stride, sheet_stride);
    atomic_fetch_sub_explicit(&blocks->readers, 1, memory_order_release);
    return is_there;
}

void cvol_block_exchange_put(cvol_block_exchange *exchange, size_t place, size_t index,
                             const void *samples, ptrdiff_t row_stride, ptrdiff_t sheet_stride)
{
    if (!exchange)
        return;
    cvol_exchanged_block *blocks = &exchange->blocks[place];
    int no_readers = 0;
    if (!atomic_compare_exchange_strong_explicit(&blocks->readers, &no_readers, -1,
                                                 memory_order_acquire, memory_order_relaxed))
        return;
    blocks->block = index;
    cvol_packed_block_put(exchange->samples + place * exchange->bytes, &exchange->shape, samples,
                          row_stride, sheet_stride);
    atomic_store_explicit(&blocks->readers, 0, memory_order_release);
}
