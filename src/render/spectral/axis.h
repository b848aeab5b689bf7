/* The spread of one slice's tiles along an axis of the lattice. */
#ifndef CVOL_RENDER_SPECTRAL_AXIS_H
#define CVOL_RENDER_SPECTRAL_AXIS_H

#include "render/spectral/evaluate.h"

/* Tile t begins at place first + t B / step. The matrices, rows of `width` floats for frequencies,
 * are for whole tiles, and for the last one. `places` is 0 if there are none yet. */
typedef struct cvol_tile_axis {
    cvol_intermediate_line line;
    ptrdiff_t first;
    int places;
    float *whole, *last;
} cvol_tile_axis;

/* For slice k along axis a. The matrices stay if an earlier slice had the same weights. */
void cvol_tile_axis_make(cvol_tile_axis *axis, const cvol_compose_job *job, int width, int a,
                         size_t k);

#endif
