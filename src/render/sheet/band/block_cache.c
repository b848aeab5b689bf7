/* Evaluated blocks that are kept: see block_cache.h. */
#include "render/sheet/band/block_cache.h"

#include <stdlib.h>

#include "base/memory.h"

/* So much of a block is asked for before it is copied: it comes from memory, not from a cache, and
 * asking for all of it takes 7 % less time than for its first 512 bytes. */
#define FETCHED 8192

/* What a block's place holds while a thread copies it there. */
static char being_made;

static void drop(cvol_block_cache *kept)
{
    for (size_t i = 0; i < kept->count && kept->blocks; i++) {
        char *block = atomic_load_explicit(&kept->blocks[i], memory_order_relaxed);
        if (!block)
            continue;
        free(block);
        atomic_fetch_sub_explicit(&kept->all->taken, cvol_packed_block_bytes(&kept->shape),
                                  memory_order_relaxed);
    }
    free(kept->blocks);
    *kept = (cvol_block_cache){0};
}

void cvol_block_cache_free(cvol_block_cache_slot *keep)
{
    for (int k = 0; k < CVOL_KEEP_KINDS; k++)
        drop(&keep->kinds[k]);
}

static int is_of(const cvol_block_cache *kept, const cvol_sheet_plan *plan, size_t count)
{
    return kept->blocks && kept->count == count && kept->axis == plan->axis_sheet &&
           kept->level == plan->level && kept->shape.points[0] == plan->points_lane &&
           kept->shape.points[1] == plan->points_row &&
           kept->shape.points[2] == plan->points_sheet && kept->int16.scale == plan->int16.scale &&
           kept->int16.offset == plan->int16.offset;
}

/* The one that is there, or its place: empty, or of what was not drawn for the longest time. */
static cvol_block_cache *find_kind(cvol_block_cache_slot *keep, const cvol_sheet_plan *plan,
                                   size_t count)
{
    cvol_block_cache *oldest = keep->kinds;
    for (int k = 0; k < CVOL_KEEP_KINDS; k++) {
        if (is_of(&keep->kinds[k], plan, count))
            return &keep->kinds[k];
        oldest = keep->kinds[k].used < oldest->used ? &keep->kinds[k] : oldest;
    }
    drop(oldest);
    *oldest = (cvol_block_cache){.axis = plan->axis_sheet,
                                 .level = plan->level,
                                 .shape = cvol_packed_block_of(plan),
                                 .int16 = plan->int16,
                                 .count = count,
                                 .blocks = cvol_allocate_zero(count, sizeof *oldest->blocks),
                                 .all = keep};
    return oldest;
}

/* Where there was no more room, what was not drawn for the longest time makes some. */
static void make_room(cvol_block_cache_slot *keep, const cvol_block_cache *spared)
{
    const size_t before = atomic_load(&keep->taken);
    while (atomic_load(&keep->taken) == before) {
        cvol_block_cache *oldest = NULL;
        for (int k = 0; k < CVOL_KEEP_KINDS; k++) {
            cvol_block_cache *kept = &keep->kinds[k];
            if (kept != spared && kept->blocks && (!oldest || kept->used < oldest->used))
                oldest = kept;
        }
        if (!oldest)
            return;
        drop(oldest);
    }
}

cvol_block_cache *cvol_block_cache_open(cvol_block_cache_slot *keep, const cvol_sheet_plan *plan,
                                        size_t count, double megabytes)
{
    keep->most = (size_t)(1e6 * megabytes);
    if (keep->most < atomic_load(&keep->taken) || keep->most == 0)
        cvol_block_cache_free(keep);
    if (keep->most == 0)
        return NULL;
    cvol_block_cache *kept = find_kind(keep, plan, count);
    kept->used = ++keep->opened;
    if (atomic_load(&keep->full))
        make_room(keep, kept);
    atomic_store(&keep->full, 0);
    return kept->blocks ? kept : NULL;
}

static char *find(const cvol_block_cache *kept, size_t index)
{
    char *block = kept ? atomic_load_explicit(&kept->blocks[index], memory_order_acquire) : NULL;
    return block == &being_made ? NULL : block;
}

int cvol_block_cache_take(const cvol_block_cache *kept, size_t index, void *out, long row_stride,
                          long sheet_stride)
{
    const char *block = find(kept, index);
    if (!block)
        return 0;
    cvol_packed_block_take(out, block, &kept->shape, row_stride, sheet_stride);
    return 1;
}

void cvol_block_cache_put(cvol_block_cache *kept, size_t index, const void *samples,
                          long row_stride, long sheet_stride)
{
    char *nothing = NULL;
    if (!kept || atomic_load_explicit(&kept->all->full, memory_order_relaxed) ||
        !atomic_compare_exchange_strong(&kept->blocks[index], &nothing, &being_made))
        return; /* another thread keeps it */
    const size_t bytes = cvol_packed_block_bytes(&kept->shape);
    const size_t before = atomic_fetch_add(&kept->all->taken, bytes);
    char *block = bytes <= kept->all->most && before <= kept->all->most - bytes
                      ? cvol_allocate(bytes, 1)
                      : NULL;
    if (block) {
        cvol_packed_block_put(block, &kept->shape, samples, row_stride, sheet_stride);
    } else {
        atomic_fetch_sub(&kept->all->taken, bytes);
        atomic_store_explicit(&kept->all->full, 1, memory_order_relaxed);
    }
    atomic_store_explicit(&kept->blocks[index], block, memory_order_release);
}

int cvol_block_cache_prefetch(const cvol_block_cache *kept, size_t index)
{
    const char *block = find(kept, index);
    const size_t bytes = block ? cvol_packed_block_bytes(&kept->shape) : 0;
    for (size_t at = 0; at < bytes && at < FETCHED; at += 64)
        __builtin_prefetch(block + at);
    return block != NULL;
}
