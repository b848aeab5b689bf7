/* Fetches layers of bricks from a source of slabs. */
#include "codec/brick/slab_source.h"

#include "codec/brick/brick_code.h"
#include "codec/quantize/coding.h"

enum { LAP_REACH = 2 };

int cvol_slab_fetch_layers(cvol_context *context, cvol_slab *slab, const cvol_slab_source *source,
                           const cvol_array *shape, size_t layer, size_t end)
{
    const size_t slices = shape->grid.dims[2];
    const size_t side = cvol_coding_of(shape)->brick.side[2];
    const size_t begin = layer * side, after = end * side + LAP_REACH;
    const size_t from = begin > LAP_REACH ? begin - LAP_REACH : 0;
    return source->fetch(context, source->user, slab, from,
                         (after < slices ? after : slices) - from);
}
