/* How much each cell of a low-resolution volume absorbs. */
#ifndef CVOL_RENDER_LIGHT_EXTINCTION_H
#define CVOL_RENDER_LIGHT_EXTINCTION_H

#include "cvol/render.h"
#include "render/light/coarse.h"
#include "render/transfer/transfer.h"

/* Sets out[cell] to the mean extinction of each cell, per mean spacing: that of the transfer
 * function in mode composite; in mode iso a surface and what it encloses are opaque; in other modes
 * it grows with the brightness. Cells outside of the clip have none. Values vary within a cell as
 * much as half the way to its neighbours. Errors: MEMORY. */
int cvol_extinction_find(cvol_context *context, float *out, const cvol_coarse *coarse,
                         const cvol_grid *grid, const cvol_transfer *transfer,
                         const cvol_render_options *options);

#endif
