/* The pixels of a picture that see the volume. */
#ifndef CVOL_RENDER_SHEET_WARP_OUTLINE_H
#define CVOL_RENDER_SHEET_WARP_OUTLINE_H

#include "render/sheet/warp/row.h"

/* Sets hit[i] to 1 if the ray of pixel i crosses the drawn box of a volume, else 0. For plans in
 * parallel projection. */
void cvol_warp_outline(uint8_t hit[CVOL_WARP_CHUNK], const cvol_sheet_plan *plan,
                       const cvol_warp_places *places);

#endif
