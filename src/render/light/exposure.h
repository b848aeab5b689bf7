/* The exposure of a picture. */
#ifndef CVOL_RENDER_LIGHT_EXPOSURE_H
#define CVOL_RENDER_LIGHT_EXPOSURE_H

#include "cvol/render.h"
#include "render/light/coarse.h"
#include "render/transfer/transfer.h"
#include "render/view/view.h"

/* Cells, with the extinction and the factor of light of each. */
typedef struct cvol_lit_cells {
    const cvol_coarse *coarse;
    const float *extinction, *factors;
} cvol_lit_cells;

/* Sets *exposure to the ratio of the brightness without light to that with it, or somewhat less
 * where much would be white. Errors: MEMORY. */
int cvol_exposure_find(cvol_context *context, double *exposure, const cvol_lit_cells *cells,
                       const cvol_grid *grid, const cvol_transfer *transfer, const cvol_view *view,
                       const cvol_render_options *options);

#endif
