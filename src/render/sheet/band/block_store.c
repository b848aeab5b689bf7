/* Evaluated blocks that are stored: see block_store.h. */
#include "render/sheet/band/block_store.h"

#include <stdlib.h>

#include "base/memory.h"

/* The bytes of a block that are prefetched before it is copied. The block comes from memory, not
 * from a cache, and prefetching all of it takes 7 % less time than its first 512 bytes. */
#define FETCHED 8192

/* The content of a block's place while a thread copies the block there. */
static char being_made;

static void drop(cvol_block_set *set)
{
    for (size_t i = 0; i < set->count && set->blocks; i++) {
        char *block = atomic_load_explicit(&set->blocks[i], memory_order_relaxed);
        if (!block)
            continue;
        free(block);
        atomic_fetch_sub_explicit(&set->all->taken, cvol_packed_block_bytes(&set->shape),
                                  memory_order_relaxed);
    }
    free(set->blocks);
    *set = (cvol_block_set){0};
}

void cvol_block_store_free(cvol_block_store *store)
{
    for (int k = 0; k < CVOL_BLOCK_SETS; k++)
        drop(&store->kinds[k]);
}

static int is_set_of(const cvol_block_set *set, const cvol_sheet_plan *plan, size_t count)
{
    return set->blocks && set->count == count && set->axis == plan->axis_sheet &&
           set->level == plan->level && set->shape.points[0] == plan->points_lane &&
           set->shape.points[1] == plan->points_row && set->shape.points[2] == plan->points_sheet &&
           set->int16.scale == plan->int16.scale && set->int16.offset == plan->int16.offset;
}

/* Finds the set, or an entry for it: an empty one, or the set that was not drawn for the longest
 * time. */
static cvol_block_set *find_set(cvol_block_store *store, const cvol_sheet_plan *plan, size_t count)
{
    cvol_block_set *oldest = store->kinds;
    for (int k = 0; k < CVOL_BLOCK_SETS; k++) {
        if (is_set_of(&store->kinds[k], plan, count))
            return &store->kinds[k];
        oldest = store->kinds[k].used < oldest->used ? &store->kinds[k] : oldest;
    }
    drop(oldest);
    *oldest = (cvol_block_set){.axis = plan->axis_sheet,
                               .level = plan->level,
                               .shape = cvol_packed_block_of(plan),
                               .int16 = plan->int16,
                               .count = count,
                               .blocks = cvol_allocate_zero(count, sizeof *oldest->blocks),
                               .all = store};
    return oldest;
}

/* Frees the set that was not drawn for the longest time, if there was no more room. */
static void make_room(cvol_block_store *store, const cvol_block_set *kept)
{
    const size_t before = atomic_load(&store->taken);
    while (atomic_load(&store->taken) == before) {
        cvol_block_set *oldest = NULL;
        for (int k = 0; k < CVOL_BLOCK_SETS; k++) {
            cvol_block_set *set = &store->kinds[k];
            if (set != kept && set->blocks && (!oldest || set->used < oldest->used))
                oldest = set;
        }
        if (!oldest)
            return;
        drop(oldest);
    }
}

cvol_block_set *cvol_block_store_open(cvol_block_store *store, const cvol_sheet_plan *plan,
                                      size_t count, double megabytes)
{
    store->most = (size_t)(1e6 * megabytes);
    if (store->most < atomic_load(&store->taken) || store->most == 0)
        cvol_block_store_free(store);
    if (store->most == 0)
        return NULL;
    cvol_block_set *set = find_set(store, plan, count);
    set->used = ++store->opened;
    if (atomic_load(&store->full))
        make_room(store, set);
    atomic_store(&store->full, 0);
    return set->blocks ? set : NULL;
}

static char *find(const cvol_block_set *set, size_t index)
{
    char *block = set ? atomic_load_explicit(&set->blocks[index], memory_order_acquire) : NULL;
    return block == &being_made ? NULL : block;
}

int cvol_block_store_take(const cvol_block_set *set, size_t index, void *out, ptrdiff_t row_stride,
                          ptrdiff_t sheet_stride)
{
    const char *block = find(set, index);
    if (!block)
        return 0;
    cvol_packed_block_take(out, block, &set->shape, row_stride, sheet_stride);
    return 1;
}

void cvol_block_store_put(cvol_block_set *set, size_t index, const void *samples,
                          ptrdiff_t row_stride, ptrdiff_t sheet_stride)
{
    char *expected = NULL;
    if (!set || atomic_load_explicit(&set->all->full, memory_order_relaxed) ||
        !atomic_compare_exchange_strong(&set->blocks[index], &expected, &being_made))
        return; /* another thread stores it */
    const size_t bytes = cvol_packed_block_bytes(&set->shape);
    const size_t before = atomic_fetch_add(&set->all->taken, bytes);
    char *block = bytes <= set->all->most && before <= set->all->most - bytes
                      ? cvol_allocate(bytes, 1)
                      : NULL;
    if (block) {
        cvol_packed_block_put(block, &set->shape, samples, row_stride, sheet_stride);
    } else {
        atomic_fetch_sub(&set->all->taken, bytes);
        atomic_store_explicit(&set->all->full, 1, memory_order_relaxed);
    }
    atomic_store_explicit(&set->blocks[index], block, memory_order_release);
}

int cvol_block_store_prefetch(const cvol_block_set *set, size_t index)
{
    const char *block = find(set, index);
    const size_t bytes = block ? cvol_packed_block_bytes(&set->shape) : 0;
    for (size_t at = 0; at < bytes && at < FETCHED; at += 64)
        __builtin_prefetch(block + at);
    return block != NULL;
}
