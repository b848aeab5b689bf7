/* What of a picture is so opaque that nothing behind it is seen.
 *
 * A picture is divided into cells; one is closed when less than 2^-14 of the light comes through
 * each of its pixels, and hidden when all that a footprint from within it reaches is closed.
 * Samples that fall onto hidden cells change no pixel by more than 1/60 of a grey level, all of
 * them together.
 */
#ifndef CVOL_RENDER_SPLAT_OCCLUSION_H
#define CVOL_RENDER_SPLAT_OCCLUSION_H

#include "render/splat/frame.h"

#define CVOL_HIDDEN_WIDTH 16
#define CVOL_HIDDEN_HEIGHT 8

/* Of one band, whose first row is a multiple of CVOL_HIDDEN_HEIGHT. */
typedef struct cvol_splat_hidden {
    int across, down;         /* cells */
    int reach[2];             /* of a footprint, in cells */
    int some, all;            /* of them are hidden */
    uint8_t *closed, *hidden; /* [down][across] */
} cvol_splat_hidden;

/* Looks which cells have been closed by now. */
void cvol_splat_hidden_update(cvol_splat_hidden *hidden, const cvol_splat_band *band);

/* Whether all samples on the way from (x0, y0) to (x1, y1) are hidden. */
int cvol_splat_is_hidden(const cvol_splat_hidden *hidden, const cvol_splat_band *band, double x0,
                         double y0, double x1, double y1);

#endif
