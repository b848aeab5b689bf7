/* Evaluated blocks that are kept: see sheet_keep.h. */
#include "render/sheet_keep.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

/* So much of a block is asked for before it is copied: it comes from memory, not from a cache, and
 * asking for all of it takes 7 % less time than for its first 512 bytes. */
#define FETCHED 8192

/* What a block's place holds while a thread copies it there. */
static char being_made;

static size_t sample_size(const cvol_kept *kept)
{
    return kept->compact.scale > 0 ? sizeof(int16_t) : sizeof(float);
}

static size_t block_bytes(const cvol_kept *kept)
{
    return sample_size(kept) * (size_t)kept->points[0] * (size_t)kept->points[1] *
           (size_t)kept->points[2];
}

static void drop(cvol_kept *kept)
{
    for (size_t i = 0; i < kept->count && kept->blocks; i++) {
        char *block = atomic_load_explicit(&kept->blocks[i], memory_order_relaxed);
        if (!block)
            continue;
        free(block);
        atomic_fetch_sub_explicit(&kept->all->taken, block_bytes(kept), memory_order_relaxed);
    }
    free(kept->blocks);
    *kept = (cvol_kept){0};
}

void cvol_keep_free(cvol_sheet_keep *keep)
{
    for (int k = 0; k < CVOL_KEEP_KINDS; k++)
        drop(&keep->kinds[k]);
}

static int is_of(const cvol_kept *kept, const cvol_sheet_plan *plan, size_t count)
{
    return kept->blocks && kept->count == count && kept->axis == plan->axis_sheet &&
           kept->level == plan->level && kept->points[0] == plan->points_lane &&
           kept->points[1] == plan->points_row && kept->points[2] == plan->points_sheet &&
           kept->compact.scale == plan->compact.scale &&
           kept->compact.offset == plan->compact.offset;
}

/* The one that is there, or its place: empty, or of what was not drawn for the longest time. */
static cvol_kept *find_kind(cvol_sheet_keep *keep, const cvol_sheet_plan *plan, size_t count)
{
    cvol_kept *oldest = keep->kinds;
    for (int k = 0; k < CVOL_KEEP_KINDS; k++) {
        if (is_of(&keep->kinds[k], plan, count))
            return &keep->kinds[k];
        oldest = keep->kinds[k].used < oldest->used ? &keep->kinds[k] : oldest;
    }
    drop(oldest);
    *oldest = (cvol_kept){.axis = plan->axis_sheet,
                          .level = plan->level,
                          .points = {plan->points_lane, plan->points_row, plan->points_sheet},
                          .compact = plan->compact,
                          .count = count,
                          .blocks = cvol_allocate_zero(count, sizeof *oldest->blocks),
                          .all = keep};
    return oldest;
}

/* Where there was no more room, what was not drawn for the longest time makes some. */
static void make_room(cvol_sheet_keep *keep, const cvol_kept *spared)
{
    const size_t before = atomic_load(&keep->taken);
    while (atomic_load(&keep->taken) == before) {
        cvol_kept *oldest = NULL;
        for (int k = 0; k < CVOL_KEEP_KINDS; k++) {
            cvol_kept *kept = &keep->kinds[k];
            if (kept != spared && kept->blocks && (!oldest || kept->used < oldest->used))
                oldest = kept;
        }
        if (!oldest)
            return;
        drop(oldest);
    }
}

cvol_kept *cvol_keep_open(cvol_sheet_keep *keep, const cvol_sheet_plan *plan, size_t count,
                          double megabytes)
{
    keep->most = (size_t)(1e6 * megabytes);
    if (keep->most < atomic_load(&keep->taken) || keep->most == 0)
        cvol_keep_free(keep);
    if (keep->most == 0)
        return NULL;
    cvol_kept *kept = find_kind(keep, plan, count);
    kept->used = ++keep->opened;
    if (atomic_load(&keep->full))
        make_room(keep, kept);
    atomic_store(&keep->full, 0);
    return kept->blocks ? kept : NULL;
}

static char *find(const cvol_kept *kept, size_t index)
{
    char *block = kept ? atomic_load_explicit(&kept->blocks[index], memory_order_acquire) : NULL;
    return block == &being_made ? NULL : block;
}

/* Lines of `size` bytes, which the compiler had better know. */
static inline void copy_lines(char *out, const char *in, const cvol_kept *kept, size_t size,
                              const long out_strides[2], const long in_strides[2])
{
    for (long z = 0; z < kept->points[2]; z++)
        for (long y = 0; y < kept->points[1]; y++)
            memcpy(out + y * out_strides[0] + z * out_strides[1],
                   in + y * in_strides[0] + z * in_strides[1], size);
}

static void copy(char *out, const char *in, const cvol_kept *kept, const long out_strides[2],
                 const long in_strides[2])
{
    const size_t size = sample_size(kept) * (size_t)kept->points[0];
    switch (size) {
    case 16:
        copy_lines(out, in, kept, 16, out_strides, in_strides);
        break;
    case 20:
        copy_lines(out, in, kept, 20, out_strides, in_strides);
        break;
    case 24:
        copy_lines(out, in, kept, 24, out_strides, in_strides);
        break;
    case 28:
        copy_lines(out, in, kept, 28, out_strides, in_strides);
        break;
    case 32:
        copy_lines(out, in, kept, 32, out_strides, in_strides);
        break;
    case 64:
        copy_lines(out, in, kept, 64, out_strides, in_strides);
        break;
    default:
        copy_lines(out, in, kept, size, out_strides, in_strides);
    }
}

int cvol_keep_take(const cvol_kept *kept, size_t index, void *out, long row_stride,
                   long sheet_stride)
{
    const char *block = find(kept, index);
    if (!block)
        return 0;
    const long size = (long)sample_size(kept), line = size * kept->points[0];
    copy(out, block, kept, (const long[2]){size * row_stride, size * sheet_stride},
         (const long[2]){line, line * kept->points[1]});
    return 1;
}

void cvol_keep_put(cvol_kept *kept, size_t index, const void *samples, long row_stride,
                   long sheet_stride)
{
    char *nothing = NULL;
    if (!kept || atomic_load_explicit(&kept->all->full, memory_order_relaxed) ||
        !atomic_compare_exchange_strong(&kept->blocks[index], &nothing, &being_made))
        return; /* another thread keeps it */
    const size_t bytes = block_bytes(kept);
    const size_t before = atomic_fetch_add(&kept->all->taken, bytes);
    char *block = bytes <= kept->all->most && before <= kept->all->most - bytes
                      ? cvol_allocate(bytes, 1)
                      : NULL;
    if (block) {
        const long size = (long)sample_size(kept), line = size * kept->points[0];
        copy(block, samples, kept, (const long[2]){line, line * kept->points[1]},
             (const long[2]){size * row_stride, size * sheet_stride});
    } else {
        atomic_fetch_sub(&kept->all->taken, bytes);
        atomic_store_explicit(&kept->all->full, 1, memory_order_relaxed);
    }
    atomic_store_explicit(&kept->blocks[index], block, memory_order_release);
}

int cvol_keep_prefetch(const cvol_kept *kept, size_t index)
{
    const char *block = find(kept, index);
    const size_t bytes = block ? block_bytes(kept) : 0;
    for (size_t at = 0; at < bytes && at < FETCHED; at += 64)
        __builtin_prefetch(block + at);
    return block != NULL;
}
