/* Blocks that lie between two bands, which both want: what one thread has evaluated it lends the
 * others, who copy it in a fraction of the time.
 *
 * Nobody waits: what is being put there, or has made room for another block by then, is evaluated
 * again, and comes out the same. Blocks have their place by where in their layer they lie, in some
 * layers in turn, since bands are seldom in the same one.
 */
#ifndef CVOL_RENDER_SHEET_BAND_BLOCK_EXCHANGE_H
#define CVOL_RENDER_SHEET_BAND_BLOCK_EXCHANGE_H

#include <stdatomic.h>

#include "render/sheet/band/block_pack.h"

typedef struct cvol_exchanged_block {
    atomic_int readers; /* -1: it is being written */
    size_t block;       /* SIZE_MAX: none */
} cvol_exchanged_block;

/* All zero lends nothing. */
typedef struct cvol_block_exchange {
    cvol_packed_block shape;
    size_t bytes;               /* that a block takes of `samples` */
    size_t lanes, rows, layers; /* of places: rows and layers of blocks have these in turn */
    cvol_exchanged_block *lent;
    char *samples;
    size_t lent_capacity, sample_capacity;
} cvol_block_exchange;

/* For a plan that so many threads are about to draw, of `most` bytes; NULL where nothing is
 * evaluated twice, or there is no memory. */
cvol_block_exchange *cvol_block_exchange_open(cvol_block_exchange *exchange,
                                              const cvol_sheet_plan *plan, int threads,
                                              size_t most);
void cvol_block_exchange_free(cvol_block_exchange *exchange);

/* The place of a block; 0 where nothing is lent. */
static inline size_t cvol_block_exchange_place(const cvol_block_exchange *exchange, size_t lane,
                                               size_t row, size_t layer)
{
    return exchange ? lane + exchange->lanes * (row % exchange->rows +
                                                exchange->rows * (layer % exchange->layers))
                    : 0;
}

/* Block `index`, whose place that is, to where a view wants it, strides in samples;
 * 0 if it is not lent. `lending` may be NULL. */
int cvol_block_exchange_take(cvol_block_exchange *exchange, size_t place, size_t index, void *out,
                             long row_stride, long sheet_stride);
void cvol_block_exchange_put(cvol_block_exchange *exchange, size_t place, size_t index,
                             const void *samples, long row_stride, long sheet_stride);

#endif
