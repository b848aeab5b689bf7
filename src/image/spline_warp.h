/* From a lattice to pixels: the last step of a picture of the transform engine, and of its
 * compressed picture. */
#ifndef CVOL_IMAGE_SPLINE_WARP_H
#define CVOL_IMAGE_SPLINE_WARP_H

#include "cvol/image.h"

/* Fills every pixel by cubic splines (Unser, Aldroubi and Eden 1993); beyond the lattice with the
 * background. `places`, four floats for each of dims[0] x dims[1]: colour, premultiplied, and
 * opacity; they are overwritten. Pixel (x, y) is at place to_intermediate[a][0] x +
 * to_intermediate[a][1] y + to_intermediate[a][2]. Bits do not depend on the number of threads.
 * Errors: MEMORY. */
int cvol_spline_warp(cvol_context *context, cvol_image *image, float *places, const size_t dims[2],
                     const double to_intermediate[2][3], const double background[3]);

#endif
