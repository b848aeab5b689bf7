/* Layers of blocks from the point of view of a band of the intermediate image. */
#ifndef CVOL_RENDER_SHEET_BAND_LAYER_H
#define CVOL_RENDER_SHEET_BAND_LAYER_H

#include "render/sheet/band/skip.h"
#include "render/sheet/frame/frame.h"

/* A layer as seen by one band. */
typedef struct cvol_band_layer {
    size_t layer, z_begin, z_end; /* slices */
    size_t first_row, last_row;   /* of blocks */
    int tile_begin, tile_end;     /* rows of tiles */
} cvol_band_layer;

/* Rows of blocks that lines line_begin .. line_end - 1 reach in a layer: *first .. *last; 0 if
 * none. */
int cvol_layer_rows(size_t *first, size_t *last, const cvol_sheet_plan *plan, size_t layer,
                    int line_begin, int line_end);

/* `before`: the view of the layer that rays met before this one, NULL if unknown. */
void cvol_layer_describe(cvol_layer *out, const void *samples, ptrdiff_t row_stride,
                         ptrdiff_t sheet_stride, const cvol_layer_skip *skip,
                         const cvol_layer_skip *before, const cvol_sheet_plan *plan,
                         const cvol_band_layer *at);
/* A layer without slices, behind the last one; sheets[0] has the place of the next slice. */
void cvol_layer_describe_end(cvol_layer *out, const cvol_sheet_plan *plan);

#endif
