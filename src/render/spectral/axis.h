/* How one slice's tiles are spread along an axis of the lattice. */
#ifndef CVOL_RENDER_SPECTRAL_AXIS_H
#define CVOL_RENDER_SPECTRAL_AXIS_H

#include "render/spectral/evaluate.h"

/* Tile t begins at place first + t B / step; the matrices, rows of `width` floats for frequencies,
 * are of tiles that are whole, and of the last one. `places` is 0 before there are any. */
typedef struct cvol_tile_axis {
    cvol_lattice_line line;
    long first;
    int places;
    float *whole, *last;
} cvol_tile_axis;

/* Slice k along axis a: where some other slice with the same weights has been before, the matrices
 * stay. */
void cvol_tile_axis_make(cvol_tile_axis *axis, const cvol_compose_job *job, int width, int a,
                         size_t k);

#endif
