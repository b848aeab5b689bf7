/* The share of a process in the work on a volume: whole layers of 64 slices. Its bricks are those
 * that begin in it; bricks of 48 slices may end behind it.
 *
 * With a team in the context, operations on volumes compute only the blocks of this share, and
 * exchange sums. A result has terms in the blocks of the share only, and so may the operands, which
 * then also have the terms of the blocks around it that the operation reads. Arrays that are no
 * volumes are not shared. */
#ifndef CVOL_ARRAY_CORE_SHARE_H
#define CVOL_ARRAY_CORE_SHARE_H

#include "array/core/array.h"
#include "base/context.h"
#include "base/team.h"

typedef struct cvol_share {
    cvol_team *team;  /* NULL: the share is the whole array */
    size_t slices[2]; /* begin, end; both may be the same */
    size_t layers[2]; /* of blocks */
    size_t blocks[2]; /* their indices */
} cvol_share;

/* The first slice of process `rank` of `size`; of process `size`: the number of slices. */
static inline size_t cvol_share_slice(size_t slices, int rank, int size)
{
    const size_t layers = (slices - 1) / CVOL_BRICK_SIDE + 1;
    const size_t begin = layers * (size_t)rank / (size_t)size * CVOL_BRICK_SIDE;
    return begin < slices ? begin : slices;
}

static inline cvol_share cvol_share_of(const cvol_context *context, const cvol_array *array)
{
    cvol_share share = {.slices = {0, array->grid.dims[2]}};
    if (context->team && cvol_array_is_volume(array)) {
        share.team = context->team;
        for (int i = 0; i < 2; i++)
            share.slices[i] = cvol_share_slice(array->grid.dims[2], share.team->rank + i,
                                               share.team->size);
    }
    for (int i = 0; i < 2 && array->block; i++) {
        const size_t side = cvol_block_side(array, 2);
        share.layers[i] = (share.slices[i] + side - 1) / side;
        share.blocks[i] = share.layers[i] * array->blocks[0] * array->blocks[1];
    }
    return share;
}

/* 1 if the share has block `index`. */
static inline int cvol_share_has(const cvol_share *share, size_t index)
{
    return index >= share->blocks[0] && index < share->blocks[1];
}

/* The blocks of a result that a process computes: those of its bricks, and for lapped volumes a
 * layer on either side, which the samples of the share depend on. */
static inline void cvol_share_computed(size_t blocks[2], const cvol_share *share,
                                       const cvol_array *array)
{
    const size_t layer = array->blocks[0] * array->blocks[1];
    size_t side[3] = {0, 0, CVOL_BRICK_SIDE}, more = array->lapped ? layer : 0;
    blocks[0] = share->blocks[0] > more ? share->blocks[0] - more : 0;
    if (array->coding)
        array->coding->ops->brick_sides(side, array->coding);
    if (CVOL_BRICK_SIDE % side[2])
        more = side[2] / (size_t)array->block * layer;
    blocks[1] = share->blocks[1] + more < array->block_count ? share->blocks[1] + more
                                                             : array->block_count;
    if (share->blocks[0] == share->blocks[1])
        blocks[0] = blocks[1] = share->blocks[0];
}

/* The number of terms of all blocks of the array: each process counts those of its share. Errors:
 * those of cvol_team_gather. */
int cvol_share_count_terms(cvol_context *context, uint64_t *count, const cvol_array *array);

/* The first group of `count` blocks, 0 .. count - 1, count .. 2 count - 1, ..., that begins in the
 * share (i = 0) or behind it (i = 1). */
static inline size_t cvol_share_group(const cvol_share *share, int i, size_t count)
{
    return (share->blocks[i] + count - 1) / count;
}

#endif
