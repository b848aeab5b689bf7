/* Storage of blocks' samples: see block_pack.h. */
#include "render/sheet/band/block_pack.h"

#include <string.h>

cvol_packed_block cvol_packed_block_of(const cvol_sheet_plan *plan)
{
    return (cvol_packed_block){plan->int16.scale > 0 ? sizeof(int16_t) : sizeof(float),
                               {plan->points_lane, plan->points_row, plan->points_sheet}};
}

size_t cvol_packed_block_bytes(const cvol_packed_block *shape)
{
    return shape->sample * (size_t)shape->points[0] * (size_t)shape->points[1] *
           (size_t)shape->points[2];
}

/* Copies lines of a `size` that is a constant at compile time. */
static inline void copy_lines(char *out, const char *in, const cvol_packed_block *shape,
                              size_t size, const ptrdiff_t out_strides[2],
                              const ptrdiff_t in_strides[2])
{
    for (ptrdiff_t z = 0; z < shape->points[2]; z++)
        for (ptrdiff_t y = 0; y < shape->points[1]; y++)
            memcpy(out + y * out_strides[0] + z * out_strides[1],
                   in + y * in_strides[0] + z * in_strides[1], size);
}

static void copy(char *out, const char *in, const cvol_packed_block *shape,
                 const ptrdiff_t out_strides[2], const ptrdiff_t in_strides[2])
{
    const size_t size = shape->sample * (size_t)shape->points[0];
    switch (size) {
    case 16:
        copy_lines(out, in, shape, 16, out_strides, in_strides);
        break;
    case 20:
        copy_lines(out, in, shape, 20, out_strides, in_strides);
        break;
    case 24:
        copy_lines(out, in, shape, 24, out_strides, in_strides);
        break;
    case 28:
        copy_lines(out, in, shape, 28, out_strides, in_strides);
        break;
    case 32:
        copy_lines(out, in, shape, 32, out_strides, in_strides);
        break;
    case 64:
        copy_lines(out, in, shape, 64, out_strides, in_strides);
        break;
    default:
        copy_lines(out, in, shape, size, out_strides, in_strides);
    }
}

typedef struct byte_strides {
    ptrdiff_t tight[2], loose[2]; /* from row to row, from slice to slice */
} byte_strides;

static byte_strides strides_of(const cvol_packed_block *shape, ptrdiff_t row_stride,
                               ptrdiff_t sheet_stride)
{
    const ptrdiff_t size = (ptrdiff_t)shape->sample, line = size * shape->points[0];
    return (byte_strides){{line, line * shape->points[1]},
                          {size * row_stride, size * sheet_stride}};
}

void cvol_packed_block_put(char *block, const cvol_packed_block *shape, const void *samples,
                           ptrdiff_t row_stride, ptrdiff_t sheet_stride)
{
    const byte_strides by = strides_of(shape, row_stride, sheet_stride);
    copy(block, samples, shape, by.tight, by.loose);
}

void cvol_packed_block_take(void *samples, const char *block, const cvol_packed_block *shape,
                            ptrdiff_t row_stride, ptrdiff_t sheet_stride)
{
    const byte_strides by = strides_of(shape, row_stride, sheet_stride);
    copy(samples, block, shape, by.loose, by.tight);
}
