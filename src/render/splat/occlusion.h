/* The parts of a picture that are so opaque that they hide everything behind them.
 *
 * A picture is divided into cells. A cell is closed when the transmittance of each of its pixels is
 * below 2^-14, and hidden when all cells that a footprint from within it reaches are closed. All
 * samples on hidden cells together change no pixel by more than 1/60 of a grey level. */
#ifndef CVOL_RENDER_SPLAT_OCCLUSION_H
#define CVOL_RENDER_SPLAT_OCCLUSION_H

#include "render/splat/frame.h"

#define CVOL_HIDDEN_WIDTH 16
#define CVOL_HIDDEN_HEIGHT 8

/* For one band, whose first row is a multiple of CVOL_HIDDEN_HEIGHT. */
typedef struct cvol_splat_hidden {
    int across, down;         /* cells */
    int reach[2];             /* of a footprint, in cells */
    int some, all;            /* of them are hidden */
    uint8_t *closed, *hidden; /* [down][across] */
} cvol_splat_hidden;

/* Finds the cells that are closed by now. */
void cvol_splat_hidden_update(cvol_splat_hidden *hidden, const cvol_splat_band *band);

/* Returns 1 if all samples on the way from (x0, y0) to (x1, y1) are hidden. */
int cvol_splat_is_hidden(const cvol_splat_hidden *hidden, const cvol_splat_band *band, double x0,
                         double y0, double x1, double y1);

#endif
