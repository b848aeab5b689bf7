/* Evaluated blocks that a renderer stores from picture to picture. It changes speed, never pixels.
 *
 * A block is stored in the form that kernels read, with the number of points of its view. Views
 * along other axes, or with other points, have a separate set. Sets replace each other, the least
 * recently used one first. */
#ifndef CVOL_RENDER_SHEET_BAND_BLOCK_STORE_H
#define CVOL_RENDER_SHEET_BAND_BLOCK_STORE_H

#include <stdatomic.h>

#include "render/sheet/band/block_pack.h"

/* The blocks of one kind of view. */
typedef struct cvol_block_set {
    int axis, level; /* the axis across the slices */
    cvol_packed_block shape;
    cvol_int16_scale int16;
    uint64_t used; /* time of the last opening */
    size_t count;
    _Atomic(char *) *blocks; /* of each [slice][row][lane]; NULL: not stored */
    struct cvol_block_store *all;
} cvol_block_set;

#define CVOL_BLOCK_SETS 12

/* All zero stores nothing. */
typedef struct cvol_block_store {
    cvol_block_set kinds[CVOL_BLOCK_SETS];
    uint64_t opened; /* number of openings */
    size_t most;     /* bytes that blocks may take */
    atomic_size_t taken;
    atomic_int full; /* some did not fit */
} cvol_block_store;

/* Opens the set of a plan before it is drawn: `count` blocks, `megabytes` at most. NULL if nothing
 * is to be stored, or without memory. */
cvol_block_set *cvol_block_store_open(cvol_block_store *store, const cvol_sheet_plan *plan,
                                      size_t count, double megabytes);
void cvol_block_store_free(cvol_block_store *store);

/* Copies block `index` into a view's memory, strides in samples; 0 if it is not stored. `set` may
 * be NULL. */
int cvol_block_store_take(const cvol_block_set *set, size_t index, void *out, ptrdiff_t row_stride,
                          ptrdiff_t sheet_stride);
/* Stores a copy if there is room. Any number of threads may take and put. */
void cvol_block_store_put(cvol_block_set *set, size_t index, const void *samples,
                          ptrdiff_t row_stride, ptrdiff_t sheet_stride);
/* Prefetches a block that will soon be taken; 0 if it is not stored. */
int cvol_block_store_prefetch(const cvol_block_set *set, size_t index);

#endif
