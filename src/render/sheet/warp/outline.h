/* Where pixels of a picture see the volume at all. */
#ifndef CVOL_RENDER_SHEET_WARP_OUTLINE_H
#define CVOL_RENDER_SHEET_WARP_OUTLINE_H

#include "render/sheet/warp/row.h"

/* Whether the rays of these pixels cross the box that is drawn of a volume: hit[i] 0 or 1. Of plans
 * in parallel projection. */
void cvol_warp_outline(uint8_t hit[CVOL_WARP_CHUNK], const cvol_sheet_plan *plan,
                       const cvol_warp_places *places);

#endif
