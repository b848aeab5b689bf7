/* Bricks of blocks from dense samples: gathers them with the margin that the filter across their
 * outer faces reads, filters in place, and returns them block by block.
 *
 * The filter of a face reads and writes two samples on either side; the three axes follow each
 * other. So a margin of two samples is enough, and a face of the margin is not filtered along later
 * axes. */
#include "array/block/brick.h"

#include <string.h>

#include "base/memory.h"
#include "transform/cell.h"
#include "transform/lap.h"

enum { MARGIN = 2, PAD = CVOL_ALIGNMENT / sizeof(float) };

/* The samples of a line's first block begin at a 64-byte boundary; the margin before them lies at
 * the end of the line before. */
static size_t line_stride(const cvol_array *shape, const size_t count[3])
{
    const size_t width = count[0] * cvol_block_side(shape, 0) + (shape->lapped ? 2 * MARGIN : 0);
    return (width + PAD - 1) / PAD * PAD;
}

static size_t lines_of(const cvol_array *shape, const size_t count[3], int axis)
{
    return count[axis] * cvol_block_side(shape, axis) + (shape->lapped ? 2 * MARGIN : 0);
}

size_t cvol_brick_scratch(const cvol_array *shape, const size_t cells_count[3])
{
    return PAD + line_stride(shape, cells_count) * lines_of(shape, cells_count, 1) *
                     lines_of(shape, cells_count, 2);
}

/* The brick in its scratch: samples begin .. end - 1 of the volume, with the margin; at[] is the
 * position of sample (x, y, z). */
typedef struct brick {
    size_t first[3], begin[3], end[3]; /* first: of the blocks, without margin */
    size_t stride[3];
    float *origin; /* of sample `first` */
} brick;

static float *brick_at(const brick *b, size_t x, size_t y, size_t z)
{
    const ptrdiff_t at = (ptrdiff_t)(x - b->first[0]) +
                         (ptrdiff_t)(y - b->first[1]) * (ptrdiff_t)b->stride[1] +
                         (ptrdiff_t)(z - b->first[2]) * (ptrdiff_t)b->stride[2];
    return b->origin + at;
}

/* The rows of a brick are short and far apart; hardware prefetch does not find them. */
static void prefetch(const char *row, size_t bytes)
{
    for (size_t i = 0; i < bytes; i += 64)
        __builtin_prefetch(row + i);
    __builtin_prefetch(row + bytes - 1);
}

static void load(const brick *b, const cvol_slab *slab, const cvol_array *shape)
{
    enum { AHEAD = 24 }; /* rows */
    const size_t line = shape->grid.dims[0], size = cvol_type_size(shape->grid.type);
    const size_t width = b->end[0] - b->begin[0], height = b->end[1] - b->begin[1];
    const size_t rows = height * (b->end[2] - b->begin[2]);
    for (size_t i = 0; i < rows + AHEAD; i++) {
        if (i < rows) {
            const size_t y = b->begin[1] + i % height, z = b->begin[2] + i / height;
            prefetch((const char *)slab->samples +
                         size * (b->begin[0] + cvol_slab_row(slab, line, y, z)),
                     size * width);
        }
        if (i < AHEAD)
            continue;
        const size_t y = b->begin[1] + (i - AHEAD) % height;
        const size_t z = b->begin[2] + (i - AHEAD) / height;
        cvol_samples_load(brick_at(b, b->begin[0], y, z), slab->samples, shape->grid.type,
                          b->begin[0] + cvol_slab_row(slab, line, y, z), width, shape->offset);
    }
}

static void filter(const brick *b, const cvol_array *shape, const size_t count[3])
{
    size_t begin[3], end[3];
    memcpy(begin, b->begin, sizeof begin);
    memcpy(end, b->end, sizeof end);
    for (int axis = 0; axis < 3; axis++) {
        cvol_lap_box box = {.grid = CVOL_CELL};
        for (int a = 0; a < 3; a++) {
            box.shape[a] = (int64_t)shape->grid.dims[a];
            box.begin[a] = (int64_t)begin[a];
            box.size[a] = (int64_t)(end[a] - begin[a]);
            box.stride[a] = (int64_t)b->stride[a];
        }
        cvol_lap_pre(brick_at(b, begin[0], begin[1], begin[2]), &box, axis);
        begin[axis] = b->first[axis];
        if (end[axis] > b->first[axis] + count[axis] * CVOL_CELL)
            end[axis] = b->first[axis] + count[axis] * CVOL_CELL;
    }
}

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

static void hand_out(float *cell, const brick *b, const cvol_array *shape, const size_t at[3])
{
    const size_t *dims = shape->grid.dims, side = cvol_block_side(shape, 0);
    const size_t inside = least(side, dims[0] - at[0]);
    for (size_t z = 0; z < cvol_block_side(shape, 2); z++)
        for (size_t y = 0; y < cvol_block_side(shape, 1); y++, cell += side) {
            memcpy(cell,
                   brick_at(b, at[0], least(at[1] + y, dims[1] - 1), least(at[2] + z, dims[2] - 1)),
                   inside * sizeof *cell);
            for (size_t x = inside; x < side; x++)
                cell[x] = cell[inside - 1];
        }
}

void cvol_brick_gather(float *cells, float *scratch, const cvol_slab *slab, const cvol_array *shape,
                       const size_t first_cell[3], const size_t cells_count[3])
{
    const size_t margin = shape->lapped ? MARGIN : 0;
    brick b = {.stride = {1, line_stride(shape, cells_count)}};
    b.stride[2] = b.stride[1] * lines_of(shape, cells_count, 1);
    b.origin = scratch + PAD + margin * (b.stride[1] + b.stride[2]);
    for (int a = 0; a < 3; a++) {
        const size_t side = cvol_block_side(shape, a);
        b.first[a] = first_cell[a] * side;
        b.begin[a] = b.first[a] ? b.first[a] - margin : 0;
        b.end[a] = least(b.first[a] + cells_count[a] * side + margin, shape->grid.dims[a]);
    }
    load(&b, slab, shape);
    if (shape->lapped)
        filter(&b, shape, cells_count);
    for (size_t l = 0; l < cells_count[2]; l++)
        for (size_t j = 0; j < cells_count[1]; j++)
            for (size_t i = 0; i < cells_count[0]; i++) {
                const size_t at[3] = {b.first[0] + i * cvol_block_side(shape, 0),
                                      b.first[1] + j * cvol_block_side(shape, 1),
                                      b.first[2] + l * cvol_block_side(shape, 2)};
                hand_out(cells, &b, shape, at);
                cells += cvol_array_block_terms(shape);
            }
}
