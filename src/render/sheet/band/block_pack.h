/* A block's samples without the gaps that views leave between its rows: as they are put away. */
#ifndef CVOL_RENDER_SHEET_BAND_BLOCK_PACK_H
#define CVOL_RENDER_SHEET_BAND_BLOCK_PACK_H

#include <stddef.h>

#include "render/sheet/frame/frame.h"

typedef struct cvol_tight {
    size_t sample; /* bytes */
    int points[3]; /* of lane, row, sheet */
} cvol_tight;

cvol_tight cvol_tight_of(const cvol_sheet_plan *plan);
size_t cvol_tight_bytes(const cvol_tight *shape);

/* Puts samples away, and back where a view wants them; strides in samples. */
void cvol_tight_put(char *block, const cvol_tight *shape, const void *samples, long row_stride,
                    long sheet_stride);
void cvol_tight_take(void *samples, const char *block, const cvol_tight *shape, long row_stride,
                     long sheet_stride);

#endif
