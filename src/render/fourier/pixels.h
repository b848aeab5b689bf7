/* Pixels from sums along rays. */
#ifndef CVOL_RENDER_FOURIER_PIXELS_H
#define CVOL_RENDER_FOURIER_PIXELS_H

#include "render/fourier/spectrum.h"

/* Along axis a, the interval of t in which a ray is within the box, for pixel x and row y (world
 * lengths from the middle): a middle and a half width, both linear in x and y. */
typedef struct cvol_fourier_rays {
    int moves[3];              /* 1 if t moves along this axis */
    double mid_x[3], mid_y[3]; /* the middle of t is mid_x x + mid_y y */
    double half[3];            /* t is within half of it; or |place| <= half */
} cvol_fourier_rays;

cvol_fourier_rays cvol_fourier_rays_make(const cvol_grid *grid, const cvol_view *view);

/* The common data of all rows of a picture. */
typedef struct cvol_fourier_pixels {
    const cvol_fourier_volume *volume;
    const cvol_fourier_kernel *kernel;
    cvol_fourier_source source;
    const cvol_fourier_planes *planes;
    const cvol_view *view;
    cvol_fourier_depth_cue cue;
    cvol_fourier_rays rays;
    double floor; /* smaller weights are ignored */
    int integrals;
    /* If pixels are not points of the lattice: */
    ptrdiff_t *cell;
    float (*weights)[CVOL_FOURIER_TAPS];
} cvol_fourier_pixels;

/* Tabulates weights, after all else is set. Errors: MEMORY; the caller frees in that case, too. */
int cvol_fourier_pixels_prepare(cvol_context *context, cvol_fourier_pixels *job);
void cvol_fourier_pixels_free(cvol_fourier_pixels *job);
/* Means (or integrals) of row j of pixels; NaN outside the volume. scratch:
 * cvol_fourier_pixels_scratch floats. */
void cvol_fourier_pixels_row(float *out, float *scratch, const cvol_fourier_pixels *job, int j);
size_t cvol_fourier_pixels_scratch(const cvol_fourier_pixels *job);

#endif
