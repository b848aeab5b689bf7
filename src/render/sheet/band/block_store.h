/* Evaluated blocks that a renderer stores from picture to picture. It changes speed, never pixels.
 *
 * A block is stored as kernels read it, with as many points as its view wanted. Views along other
 * axes, or with other points, have a kind of their own; kinds make room for each other, the one
 * that was used least recently first.
 */
#ifndef CVOL_RENDER_SHEET_BAND_BLOCK_STORE_H
#define CVOL_RENDER_SHEET_BAND_BLOCK_STORE_H

#include <stdatomic.h>

#include "render/sheet/band/block_pack.h"

/* Blocks of one kind. */
typedef struct cvol_stored_kind {
    int axis, level; /* across which sheets lie */
    cvol_packed_block shape;
    cvol_int16_scale int16;
    uint64_t used; /* when it was opened last */
    size_t count;
    _Atomic(char *) *blocks; /* of each [sheet][row][lane]; NULL: it is not kind */
    struct cvol_block_store *all;
} cvol_stored_kind;

#define CVOL_STORED_KINDS 12

/* All zero keeps nothing. */
typedef struct cvol_block_store {
    cvol_stored_kind kinds[CVOL_STORED_KINDS];
    uint64_t opened; /* how often any was */
    size_t most;     /* bytes that blocks may take */
    atomic_size_t taken;
    atomic_int full; /* some did not fit */
} cvol_block_store;

/* Those of a plan that is about to be drawn, `count` blocks, which are `megabytes` at most; NULL
 * where none are to be kind, or there is no memory. */
cvol_stored_kind *cvol_block_store_open(cvol_block_store *store, const cvol_sheet_plan *plan,
                                        size_t count, double megabytes);
void cvol_block_store_free(cvol_block_store *store);

/* Block `index` to where a view wants it, strides in samples; 0 if it is not kind. `kind` may be
 * NULL. */
int cvol_block_store_take(const cvol_stored_kind *kind, size_t index, void *out, long row_stride,
                          long sheet_stride);
/* Keeps it, as it lies there, if there is room. Any number of threads may do either. */
void cvol_block_store_put(cvol_stored_kind *kind, size_t index, const void *samples,
                          long row_stride, long sheet_stride);
/* Asks for a block that will be taken soon; 0 if it is not kind. */
int cvol_block_store_prefetch(const cvol_stored_kind *kind, size_t index);

#endif
