/* Blocks that bands lend each other: see block_exchange.h. */
#include "render/sheet/band/block_exchange.h"

#include <stdlib.h>

#include "base/memory.h"

/* So many rows of blocks lie between two bands, and are kept for so many layers. */
#define ROWS 6
#define LAYERS 4

/* As many layers as there is room for; 0: none. */
static size_t choose_places(cvol_lending *lending, const cvol_sheet_plan *plan, int threads,
                            size_t most)
{
    const size_t between = ROWS * (size_t)(threads - 1);
    lending->shape = cvol_tight_of(plan);
    lending->bytes = cvol_tight_bytes(&lending->shape);
    lending->lanes = plan->blocks_lane;
    lending->rows = between < plan->blocks_row ? between : plan->blocks_row;
    const size_t layer = lending->lanes * lending->rows,
                 layers = most / (layer * (lending->bytes + sizeof(cvol_lent)));
    lending->layers = layers < LAYERS ? layers : LAYERS;
    return layer * lending->layers;
}

cvol_lending *cvol_lending_open(cvol_lending *lending, const cvol_sheet_plan *plan, int threads,
                                size_t most)
{
    if (threads < 2 || plan->level) /* a level's samples are there */
        return NULL;
    const size_t count = choose_places(lending, plan, threads, most);
    if (count == 0 ||
        !cvol_ensure(&lending->lent, &lending->lent_capacity, count, sizeof *lending->lent) ||
        !cvol_ensure(&lending->samples, &lending->sample_capacity, count * lending->bytes, 1))
        return NULL;
    for (size_t i = 0; i < count; i++) {
        atomic_init(&lending->lent[i].readers, 0);
        lending->lent[i].block = SIZE_MAX;
    }
    return lending;
}

void cvol_lending_free(cvol_lending *lending)
{
    free(lending->lent);
    free(lending->samples);
}

int cvol_lent_take(cvol_lending *lending, size_t place, size_t index, void *out, long row_stride,
                   long sheet_stride)
{
    if (!lending)
        return 0;
    cvol_lent *lent = &lending->lent[place];
    int readers = atomic_load_explicit(&lent->readers, memory_order_relaxed);
    do
        if (readers < 0)
            return 0;
    while (!atomic_compare_exchange_weak_explicit(&lent->readers, &readers, readers + 1,
                                                  memory_order_acquire, memory_order_relaxed));
    const int is_there = lent->block == index;
    if (is_there)
        cvol_tight_take(out, lending->samples + place * lending->bytes, &lending->shape, row_stride,
                        sheet_stride);
    atomic_fetch_sub_explicit(&lent->readers, 1, memory_order_release);
    return is_there;
}

void cvol_lent_put(cvol_lending *lending, size_t place, size_t index, const void *samples,
                   long row_stride, long sheet_stride)
{
    if (!lending)
        return;
    cvol_lent *lent = &lending->lent[place];
    int nobody = 0;
    if (!atomic_compare_exchange_strong_explicit(&lent->readers, &nobody, -1, memory_order_acquire,
                                                 memory_order_relaxed))
        return;
    lent->block = index;
    cvol_tight_put(lending->samples + place * lending->bytes, &lending->shape, samples, row_stride,
                   sheet_stride);
    atomic_store_explicit(&lent->readers, 0, memory_order_release);
}
