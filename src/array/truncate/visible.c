/* Visible samples of blocks: visible.h. */
#include "array/truncate/visible.h"

#include <math.h>
#include <string.h>

#include "array/block/block_transform.h"
#include "transform/block.h"
#include "transform/cell.h"

/* The post-filter mixes four samples across a face, two on each side. */
enum { REACH = 2, AROUND = CVOL_CELL + 2 * REACH };

/* The box of samples that block `index` reaches, within the volume. */
static void reached_box(size_t begin[3], size_t end[3], const cvol_array *array, size_t index)
{
    const size_t margin = array->lapped ? REACH : 0;
    size_t at[3];
    cvol_block_origin(at, array, index);
    for (int a = 0; a < 3; a++) {
        const size_t last = at[a] + cvol_block_side(array, a) + margin;
        begin[a] = at[a] > margin ? at[a] - margin : 0;
        end[a] = last < array->grid.dims[a] ? last : array->grid.dims[a];
    }
}

/* True if all samples of the block are samples of the volume. */
static int is_within(const cvol_array *array, size_t index)
{
    size_t at[3];
    cvol_block_origin(at, array, index);
    for (int a = 0; a < 3; a++)
        if (at[a] + cvol_block_side(array, a) > array->grid.dims[a])
            return 0;
    return 1;
}

/* The state of the mask in a box, by its blocks of 16: NONE or ALL if all of them agree, else SOME.
 */
static cvol_mask_state state_of(const cvol_mask *mask, const size_t begin[3], const size_t end[3])
{
    size_t at[3];
    int clear = 1, full = 1;
    for (at[2] = begin[2] / CVOL_MASK_CELL; at[2] * CVOL_MASK_CELL < end[2]; at[2]++)
        for (at[1] = begin[1] / CVOL_MASK_CELL; at[1] * CVOL_MASK_CELL < end[1]; at[1]++)
            for (at[0] = begin[0] / CVOL_MASK_CELL; at[0] * CVOL_MASK_CELL < end[0]; at[0]++) {
                const cvol_mask_state state = cvol_mask_cell(mask, at);
                clear = clear && state == CVOL_MASK_NONE;
                full = full && state == CVOL_MASK_ALL;
            }
    return clear ? CVOL_MASK_NONE : full ? CVOL_MASK_ALL : CVOL_MASK_SOME;
}

/* The samples first .. end - 1 along an axis that evaluated sample x reaches. */
static void reached_along(size_t *first, size_t *end, const cvol_array *array, int axis, size_t x)
{
    const size_t dim = array->grid.dims[axis];
    const size_t face = (x + REACH) / CVOL_CELL * CVOL_CELL;
    const int mixed = array->lapped && face && x < face + REACH && face + REACH <= dim;
    *first = mixed ? face - REACH : x;
    *end = mixed ? face + REACH : x + 1;
    *end = *end < dim ? *end : dim;
}

/* Spreads the samples that are not masked along one axis: from `size` to the sides of the block. */
static void spread(uint8_t *out, const uint8_t *in, const cvol_array *array, size_t index, int axis,
                   const size_t begin[3], const size_t size[3])
{
    const size_t B = (size_t)array->block;
    const size_t stride = axis == 0 ? 1 : axis == 1 ? size[0] : size[0] * size[1];
    const size_t outer = size[0] * size[1] * size[2] / (stride * size[axis]);
    size_t at[3];
    cvol_block_origin(at, array, index);
    for (size_t x = 0; x < B; x++) {
        size_t first, end;
        reached_along(&first, &end, array, axis, at[axis] + x);
        for (size_t o = 0; o < outer; o++) {
            uint8_t *to = out + (o * B + x) * stride;
            memset(to, 0, stride);
            for (size_t f = first; f < end; f++)
                for (size_t i = 0; i < stride; i++)
                    to[i] |= in[(o * size[axis] + f - begin[axis]) * stride + i];
        }
    }
}

size_t cvol_visible_find(uint8_t *visible, const cvol_array *array, size_t index)
{
    enum { ROOM = CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX };
    _Static_assert(ROOM >= AROUND * AROUND * AROUND, "the box that a lapped block reaches");
    const size_t B = (size_t)array->block, all = B * B * B;
    uint8_t box[ROOM], other[ROOM];
    size_t begin[3], end[3], size[3], count = 0;
    reached_box(begin, end, array, index);
    const cvol_mask_state state = array->mask ? state_of(array->mask, begin, end) : CVOL_MASK_NONE;
    if (state == CVOL_MASK_ALL)
        return 0;
    if (state == CVOL_MASK_NONE && is_within(array, index))
        return all;
    for (int a = 0; a < 3; a++)
        size[a] = end[a] - begin[a];
    if (array->mask)
        cvol_mask_get(box, array->mask, begin, end);
    else
        memset(box, 0, size[0] * size[1] * size[2]);
    for (size_t i = 0; i < size[0] * size[1] * size[2]; i++)
        box[i] = !box[i];
    uint8_t *from = box, *to = other;
    for (int a = 0; a < 3; a++) {
        uint8_t *const out = a == 2 ? visible : to;
        spread(out, from, array, index, a, begin, size);
        size[a] = B;
        to = from;
        from = out;
    }
    for (size_t i = 0; i < all; i++)
        count += visible[i];
    return count;
}

cvol_visible_error cvol_visible_loss(float *samples, const float *errors, const uint8_t *visible,
                                     const cvol_array *array, size_t index)
{
    const size_t B = (size_t)array->block, all = B * B * B;
    const int box[3] = {CVOL_CELL, CVOL_CELL, CVOL_CELL};
    double sum = 0, total = 0;
    float most = 0;
    if (B == CVOL_CELL) {
        cvol_cell_inverse(samples, errors, array->block_table[index].split, box);
    } else {
        memcpy(samples, errors, all * sizeof *samples);
        cvol_block_from_slots(samples, array);
    }
    for (size_t i = 0; i < all; i++) {
        const double square = (double)samples[i] * (double)samples[i];
        const int counts = !visible || visible[i];
        total += square;
        sum += counts ? square : 0;
        most = counts && fabsf(samples[i]) > most ? fabsf(samples[i]) : most;
    }
    const double rounding = 2 * CVOL_ROUNDING * sqrt(total); /* of the transform */
    const double norm = sqrt(sum) + rounding;
    return (cvol_visible_error){norm * norm, (double)most + rounding};
}
