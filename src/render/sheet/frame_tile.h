/* A frame that is drawn strip by strip, so that its memory does not grow with the picture.
 *
 * A strip is a plan with some lines of the whole one's intermediate image, which is drawn and
 * warped by itself: pixels of the picture are the strip's in which they lie, and its lines reach a
 * few further, as far as the warp looks. How many strips there are depends on the frame alone, and
 * not on the threads, so that neither do pictures.
 */
#ifndef CVOL_RENDER_SHEET_FRAME_TILE_H
#define CVOL_RENDER_SHEET_FRAME_TILE_H

#include "render/sheet/frame/frame.h"

typedef struct cvol_frame_tiles {
    int count;
    size_t spare; /* bytes that a frame may still take, for what can be done without */
} cvol_frame_tiles;

/* In how many strips a plan of a picture of so many pixels is to be drawn. `line_floats`: of the
 * intermediate image, for each of its pixels; `mask_bytes`: what is kept of a mask. */
cvol_frame_tiles cvol_frame_tiles_choose(const cvol_sheet_plan *plan, size_t pixels,
                                         int line_floats, size_t mask_bytes);
/* Strip `index` of `count`; the plan itself if there is one. */
cvol_sheet_plan cvol_frame_tile_make(const cvol_sheet_plan *plan, int index, int count);

#endif
