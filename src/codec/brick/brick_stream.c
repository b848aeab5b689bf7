/* Streams with one part per brick. */
#include "codec/brick/brick_stream.h"

#include "base/context.h"
#include "codec/quantize/coding.h"

cvol_box cvol_brick_samples_of(const cvol_array *array, size_t brick)
{
    size_t bricks[3];
    cvol_brick_grid(bricks, array);
    const size_t place[3] = {brick % bricks[0], brick / bricks[0] % bricks[1],
                             brick / bricks[0] / bricks[1]};
    cvol_box box;
    for (int a = 0; a < 3; a++) {
        const size_t side = cvol_coding_of(array)->brick.side[a],
                     left = array->grid.dims[a] - place[a] * side;
        box.begin[a] = place[a] * side;
        box.end[a] = box.begin[a] + (left < side ? left : side);
    }
    return box;
}

int cvol_brick_intersects(const cvol_array *array, size_t brick, const cvol_box *box)
{
    const cvol_box own = cvol_brick_samples_of(array, brick);
    for (int a = 0; box && a < 3; a++)
        if (own.end[a] <= box->begin[a] || own.begin[a] >= box->end[a])
            return 0;
    return 1;
}

int cvol_brick_stream_check(cvol_context *context, const cvol_array *array,
                            const cvol_brick_index *index, int stream, const cvol_section *section,
                            const cvol_box *box, const char *name)
{
    int code = cvol_brick_index_check(context, index, stream, section, name);
    for (size_t run = 0; run < index->runs && !code; run++) {
        const size_t first = run * index->run, left = index->bricks - first;
        int needed = 0;
        for (size_t b = 0; b < index->run && b < left && !needed; b++)
            needed = cvol_brick_intersects(array, first + b, box);
        if (needed && !cvol_brick_index_verify(index, stream, run, section->content))
            code = cvol_fail(context, CVOL_ERROR_CORRUPT,
                             "%s: section %s: the run of bricks from brick %zu of %zu is damaged",
                             name, section->tag, first, index->bricks);
    }
    return code;
}
