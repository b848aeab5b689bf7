/* Evaluated blocks that are kept from picture to picture, for those who have the memory: as they
 * were drawn, so that pictures are the same ones, sooner.
 *
 * They lie as kernels read them, and have as many points as their view wanted: blocks of views
 * along other axes, or with others, are kept by themselves, and make room for each other.
 */
#ifndef CVOL_RENDER_SHEET_BAND_BLOCK_CACHE_H
#define CVOL_RENDER_SHEET_BAND_BLOCK_CACHE_H

#include <stdatomic.h>

#include "render/sheet/band/block_pack.h"

/* Blocks of one kind. */
typedef struct cvol_block_cache {
    int axis, level; /* across which sheets lie */
    cvol_packed_block shape;
    cvol_int16_scale int16;
    uint64_t used; /* when it was opened last */
    size_t count;
    _Atomic(char *) *blocks; /* of each [sheet][row][lane]; NULL: it is not kept */
    struct cvol_block_cache_slot *all;
} cvol_block_cache;

#define CVOL_KEEP_KINDS 12

/* All zero keeps nothing. */
typedef struct cvol_block_cache_slot {
    cvol_block_cache kinds[CVOL_KEEP_KINDS];
    uint64_t opened; /* how often any was */
    size_t most;     /* bytes that blocks may take */
    atomic_size_t taken;
    atomic_int full; /* some did not fit */
} cvol_block_cache_slot;

/* Those of a plan that is about to be drawn, `count` blocks, which are `megabytes` at most; NULL
 * where none are to be kept, or there is no memory. */
cvol_block_cache *cvol_block_cache_open(cvol_block_cache_slot *keep, const cvol_sheet_plan *plan,
                                        size_t count, double megabytes);
void cvol_block_cache_free(cvol_block_cache_slot *keep);

/* Block `index` to where a view wants it, strides in samples; 0 if it is not kept. `kept` may be
 * NULL. */
int cvol_block_cache_take(const cvol_block_cache *kept, size_t index, void *out, long row_stride,
                          long sheet_stride);
/* Keeps it, as it lies there, if there is room. Any number of threads may do either. */
void cvol_block_cache_put(cvol_block_cache *kept, size_t index, const void *samples,
                          long row_stride, long sheet_stride);
/* Asks for a block that will be taken soon; 0 if it is not kept. */
int cvol_block_cache_prefetch(const cvol_block_cache *kept, size_t index);

#endif
