/* The intermediate image: its lines, its opaque tiles, and the tiles that a block reaches. */
#ifndef CVOL_RENDER_SHEET_BAND_INTERMEDIATE_H
#define CVOL_RENDER_SHEET_BAND_INTERMEDIATE_H

#include "render/sheet/frame/frame.h"

/* The number of samples beyond a window's own that its pixels read. */
static inline int cvol_sheet_reach(const cvol_sheet_plan *plan)
{
    return plan->wide ? plan->reach : 0;
}

/* Index of block (lane, row) of a layer in the array's block table. */
size_t cvol_sheet_block_index(const cvol_sheet_plan *plan, const cvol_array *array, size_t lane,
                              size_t row, size_t layer);

/* Opaque tiles: 16 x 16 pixels of the intermediate image. */
#define CVOL_TILE 16
typedef struct cvol_tiles {
    int across, down;
    uint8_t *open; /* [down][across]: 1 if some group of the tile can still change */
} cvol_tiles;

/* For lines begin .. end - 1, begin a multiple of CVOL_TILE. */
void cvol_tiles_update(const cvol_tiles *tiles, const cvol_intermediate *intermediate, int begin,
                       int end);

/* The tiles left .. right of rows top .. bottom, none if left > right or top > bottom. */
typedef struct cvol_tile_span {
    int left, right, top, bottom;
} cvol_tile_span;

/* The tiles that the block (lane, row) of a layer with slices z_begin .. z_end - 1 reaches; 0 if it
 * lies behind the eye. */
int cvol_block_tiles(cvol_tile_span *out, const cvol_tiles *tiles, const cvol_sheet_plan *plan,
                     size_t lane, size_t row, size_t z_begin, size_t z_end);

/* Tests if the block (lane, row) of a layer with slices z_begin .. z_end - 1 reaches an open tile
 * in tile rows tile_begin .. tile_end - 1, and if so, also an open tile outside of these. */
typedef enum cvol_block_visibility {
    CVOL_BLOCK_HIDDEN,
    CVOL_BLOCK_VISIBLE,
    CVOL_BLOCK_SHARED
} cvol_block_visibility;
cvol_block_visibility cvol_block_test_visibility(const cvol_tiles *tiles,
                                                 const cvol_sheet_plan *plan, size_t lane,
                                                 size_t row, size_t z_begin, size_t z_end,
                                                 int tile_begin, int tile_end);

/* The slices of a layer: *begin .. *end - 1. */
void cvol_layer_sheets(size_t *begin, size_t *end, const cvol_sheet_plan *plan, size_t layer);

/* Line `j` of the image, for kernels. */
cvol_line cvol_band_line(const cvol_intermediate *image, int j);

#endif
