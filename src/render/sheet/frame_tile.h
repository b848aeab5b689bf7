/* A frame that is drawn tile by tile, so that its memory does not grow with the picture.
 *
 * A tile is a plan with some lines of the whole plan's intermediate image. It is drawn and warped
 * independently. Each pixel of the picture belongs to the tile in which it lies; the tile's lines
 * reach a few further, within the reach of the warp. The number of tiles depends on the frame
 * alone, not on the threads, so pictures do not depend on threads either. */
#ifndef CVOL_RENDER_SHEET_FRAME_TILE_H
#define CVOL_RENDER_SHEET_FRAME_TILE_H

#include "render/sheet/frame/frame.h"

typedef struct cvol_frame_tiles {
    int count;
    size_t spare; /* bytes that a frame may still use for optional memory */
} cvol_frame_tiles;

/* The number of tiles for a plan of a picture of this size. `line_floats`: per pixel of the
 * intermediate image; `mask_bytes`: memory of the mask. */
cvol_frame_tiles cvol_frame_tiles_choose(const cvol_sheet_plan *plan, size_t pixels,
                                         int line_floats, size_t mask_bytes);
/* Tile `index` of `count`; the plan itself if there is one. */
cvol_sheet_plan cvol_frame_tile_make(const cvol_sheet_plan *plan, int index, int count);

#endif
