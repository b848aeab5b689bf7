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

typedef struct cvol_lent {
    atomic_int readers; /* -1: it is being written */
    size_t block;       /* SIZE_MAX: none */
} cvol_lent;

/* All zero lends nothing. */
typedef struct cvol_lending {
    cvol_tight shape;
    size_t bytes;               /* that a block takes of `samples` */
    size_t lanes, rows, layers; /* of places: rows and layers of blocks have these in turn */
    cvol_lent *lent;
    char *samples;
    size_t lent_capacity, sample_capacity;
} cvol_lending;

/* For a plan that so many threads are about to draw, of `most` bytes; NULL where nothing is
 * evaluated twice, or there is no memory. */
cvol_lending *cvol_lending_open(cvol_lending *lending, const cvol_sheet_plan *plan, int threads,
                                size_t most);
void cvol_lending_free(cvol_lending *lending);

/* The place of a block; 0 where nothing is lent. */
static inline size_t cvol_lending_place(const cvol_lending *lending, size_t lane, size_t row,
                                        size_t layer)
{
    return lending ? lane + lending->lanes *
                                (row % lending->rows + lending->rows * (layer % lending->layers))
                   : 0;
}

/* Block `index`, whose place that is, to where a view wants it, strides in samples;
 * 0 if it is not lent. `lending` may be NULL. */
int cvol_lent_take(cvol_lending *lending, size_t place, size_t index, void *out, long row_stride,
                   long sheet_stride);
void cvol_lent_put(cvol_lending *lending, size_t place, size_t index, const void *samples,
                   long row_stride, long sheet_stride);

#endif
