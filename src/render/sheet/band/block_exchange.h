/* Blocks between two bands, which both need: one thread evaluates a block, and the other copies it
 * in a fraction of the time.
 *
 * Lock-free: if a block is being written, or was replaced, the thread evaluates it again, with the
 * same result. The place of a block depends on its position in its layer. Places are reused after
 * some layers, since bands are rarely in the same layer. */
#ifndef CVOL_RENDER_SHEET_BAND_BLOCK_EXCHANGE_H
#define CVOL_RENDER_SHEET_BAND_BLOCK_EXCHANGE_H

#include <stdatomic.h>

#include "render/sheet/band/block_pack.h"

typedef struct cvol_exchanged_block {
    atomic_int readers; /* -1: it is being written */
    size_t block;       /* SIZE_MAX: none */
} cvol_exchanged_block;

/* All zero is an empty exchange. */
typedef struct cvol_block_exchange {
    cvol_packed_block shape;
    size_t bytes; /* of a block's `samples` */
    size_t lanes, rows,
        layers; /* numbers of places: rows and layers of blocks reuse them cyclically */
    cvol_exchanged_block *blocks;
    char *samples;
    size_t block_capacity, sample_capacity;
} cvol_block_exchange;

/* For a plan that `threads` threads will draw, of `most` bytes. NULL if no block is evaluated
 * twice, or without memory. */
cvol_block_exchange *cvol_block_exchange_open(cvol_block_exchange *exchange,
                                              const cvol_sheet_plan *plan, int threads,
                                              size_t most);
void cvol_block_exchange_free(cvol_block_exchange *exchange);

/* The place of a block; 0 if there is no exchange. */
static inline size_t cvol_block_exchange_place(const cvol_block_exchange *exchange, size_t lane,
                                               size_t row, size_t layer)
{
    return exchange ? lane + exchange->lanes * (row % exchange->rows +
                                                exchange->rows * (layer % exchange->layers))
                    : 0;
}

/* Copies block `index`, whose place is given, into a view's memory, strides in samples; 0 if it is
 * not there. `exchange` may be NULL. */
int cvol_block_exchange_take(cvol_block_exchange *exchange, size_t place, size_t index, void *out,
                             ptrdiff_t row_stride, ptrdiff_t sheet_stride);
void cvol_block_exchange_put(cvol_block_exchange *exchange, size_t place, size_t index,
                             const void *samples, ptrdiff_t row_stride, ptrdiff_t sheet_stride);

#endif
