/* A block's samples in storage: without the gaps between rows that views have. */
#ifndef CVOL_RENDER_SHEET_BAND_BLOCK_PACK_H
#define CVOL_RENDER_SHEET_BAND_BLOCK_PACK_H

#include <stddef.h>

#include "render/sheet/frame/frame.h"

typedef struct cvol_packed_block {
    size_t sample; /* bytes */
    int points[3]; /* of lane, row, slice */
} cvol_packed_block;

cvol_packed_block cvol_packed_block_of(const cvol_sheet_plan *plan);
size_t cvol_packed_block_bytes(const cvol_packed_block *shape);

/* Stores samples, and copies them back into a view's memory; strides in samples. */
void cvol_packed_block_put(char *block, const cvol_packed_block *shape, const void *samples,
                           ptrdiff_t row_stride, ptrdiff_t sheet_stride);
void cvol_packed_block_take(void *samples, const char *block, const cvol_packed_block *shape,
                            ptrdiff_t row_stride, ptrdiff_t sheet_stride);

#endif
