/* Strips of bricks, and fetching their samples. */
#include "codec/brick/slab_source.h"

#include "codec/brick/brick_code.h"
#include "codec/quantize/coding.h"

enum { LAP_REACH = 2 };

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

cvol_strips cvol_strips_of(const cvol_slab_source *source, const cvol_array *shape)
{
    cvol_strips strips;
    const size_t *side = cvol_coding_of(shape)->brick.side;
    const size_t row_bytes = shape->grid.dims[0] * cvol_type_size(shape->grid.type) *
                             least(side[2] + 2 * LAP_REACH, shape->grid.dims[2]);
    const size_t rows = source->strip_bytes ? source->strip_bytes / row_bytes : shape->grid.dims[1];
    cvol_brick_grid(strips.grid, shape);
    strips.rows = strips.grid[1];
    if (rows < shape->grid.dims[1])
        strips.rows = rows >= side[1] + 2 * LAP_REACH ? (rows - 2 * LAP_REACH) / side[1] : 1;
    strips.per_layer = (strips.grid[1] + strips.rows - 1) / strips.rows;
    return strips;
}

cvol_strip cvol_strip_at(const cvol_strips *strips, size_t number)
{
    const size_t layer = number / strips->per_layer,
                 row = number % strips->per_layer * strips->rows;
    return (cvol_strip){{layer, layer + 1}, {row, least(row + strips->rows, strips->grid[1])}};
}

size_t cvol_strip_of(const cvol_strips *strips, size_t brick)
{
    const size_t row = brick / strips->grid[0];
    return row / strips->grid[1] * strips->per_layer + row % strips->grid[1] / strips->rows;
}

void cvol_strip_bricks(size_t bricks[2], const cvol_strips *strips, const cvol_strip *strip)
{
    const size_t *grid = strips->grid;
    bricks[0] = grid[0] * (strip->rows[0] + grid[1] * strip->layers[0]);
    bricks[1] = grid[0] * (strip->rows[1] + grid[1] * (strip->layers[1] - 1));
}

cvol_box cvol_strip_samples(const cvol_array *shape, const cvol_strip *strip)
{
    const size_t *side = cvol_coding_of(shape)->brick.side;
    const size_t *dims = shape->grid.dims, *bricks[] = {strip->rows, strip->layers};
    cvol_box box = {.end = {dims[0]}};
    for (int a = 1; a < 3; a++) {
        box.begin[a] = bricks[a - 1][0] * side[a];
        box.end[a] = least(bricks[a - 1][1] * side[a], dims[a]);
    }
    return box;
}

int cvol_slab_fetch_strip(cvol_context *context, cvol_slab *slab, const cvol_slab_source *source,
                          const cvol_array *shape, const cvol_strip *strip)
{
    cvol_box box = cvol_strip_samples(shape, strip);
    for (int a = 1; a < 3; a++) {
        box.begin[a] -= least(box.begin[a], LAP_REACH);
        box.end[a] = least(box.end[a] + LAP_REACH, shape->grid.dims[a]);
    }
    *slab = (cvol_slab){.first_slice = box.begin[2],
                        .slices = box.end[2] - box.begin[2],
                        .first_row = box.begin[1],
                        .rows = box.end[1] - box.begin[1]};
    return source->fetch(context, source->user, slab);
}
