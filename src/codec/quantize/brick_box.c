/* Bricks as boxes of blocks. */
#include "codec/quantize/brick_box.h"

#include "codec/quantize/coding.h"

void cvol_brick_grid(size_t bricks[3], const cvol_array *array)
{
    for (int a = 0; a < 3; a++)
        bricks[a] = (array->grid.dims[a] - 1) / cvol_coding_of(array)->brick.side[a] + 1;
}

size_t cvol_brick_count(const cvol_array *array)
{
    size_t bricks[3];
    cvol_brick_grid(bricks, array);
    return bricks[0] * bricks[1] * bricks[2];
}

cvol_brick_box cvol_brick_box_of(const cvol_array *array, size_t brick)
{
    size_t bricks[3];
    cvol_brick_grid(bricks, array);
    const size_t place[3] = {brick % bricks[0], brick / bricks[0] % bricks[1],
                             brick / bricks[0] / bricks[1]};
    cvol_brick_box box;
    for (int a = 0; a < 3; a++) {
        const size_t side = cvol_coding_of(array)->brick.side[a] / (size_t)array->block;
        box.first[a] = place[a] * side;
        const size_t left = array->blocks[a] - box.first[a];
        box.count[a] = left < side ? left : side;
    }
    return box;
}

void cvol_brick_inside(size_t size[3], const cvol_array *array, size_t brick)
{
    const cvol_brick_box box = cvol_brick_box_of(array, brick);
    for (int a = 0; a < 3; a++) {
        const size_t left = array->grid.dims[a] - box.first[a] * (size_t)array->block;
        size[a] = left < cvol_coding_of(array)->brick.side[a]
                      ? left
                      : cvol_coding_of(array)->brick.side[a];
    }
}

void cvol_brick_shape_blocks(size_t blocks[3], const cvol_array *array)
{
    for (int a = 0; a < 3; a++)
        blocks[a] = cvol_coding_of(array)->brick.side[a] / (size_t)array->block;
}

size_t cvol_brick_volume(const cvol_array *array)
{
    return cvol_coding_of(array)->brick.side[0] * cvol_coding_of(array)->brick.side[1] *
           cvol_coding_of(array)->brick.side[2];
}

size_t cvol_brick_box_blocks(const cvol_brick_box *box)
{
    return box->count[0] * box->count[1] * box->count[2];
}

size_t cvol_brick_block_index(const cvol_array *array, const cvol_brick_box *box, size_t i)
{
    size_t place[3];
    cvol_brick_box_place(place, box, i);
    for (int a = 0; a < 3; a++)
        place[a] += box->first[a];
    return place[0] + array->blocks[0] * (place[1] + array->blocks[1] * place[2]);
}

int cvol_block_sub_blocks(cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX], int block, uint16_t split)
{
    if (block == CVOL_CELL)
        return cvol_cell_list_sub_blocks(parts, split);
    parts[0] = (cvol_sub_block){.side = block};
    return 1;
}
