/* The lattice on which a view's slice is transformed, as long as the volume's shadow. Its points
 * are the pixels, or, if these are much smaller than samples, a coarser lattice. */
#include <math.h>

#include "render/fourier/spectrum.h"
#include "transform/fft.h"

/* If pixels are smaller than this part of the smallest spacing, the lattice has this spacing, and
 * pixels are interpolated. */
#define FINEST 0.4
/* Lattice points beyond the shadow. */
#define MARGIN 8

static double least_spacing(const cvol_grid *grid)
{
    double least = INFINITY;
    for (int a = 0; a < 3; a++)
        least = fmin(least, grid->spacing[a]);
    return least;
}

void cvol_fourier_slice_grid_make(cvol_fourier_slice_grid *out, const cvol_grid *grid,
                                  const cvol_view *view)
{
    const double finest = FINEST * least_spacing(grid);
    const double size[2] = {view->width, view->height};
    out->aligned = view->pixel >= finest;
    out->space = out->aligned ? view->pixel : finest;
    for (int d = 0; d < 2; d++) {
        const double *along = d ? view->up : view->right;
        double shadow = 0;
        out->middle[d] = 0;
        for (int a = 0; a < 3; a++) { /* samples are linear up to their neighbours */
            shadow += fabs(along[a]) * (view->extent[a] + 2 * grid->spacing[a]);
            out->middle[d] += along[a] * (view->centre[a] - view->extent[a] / 2);
        }
        out->dims[d] = cvol_fft_good_length((size_t)ceil(shadow / out->space) + MARGIN, 1);
        /* pixel (i, j) is at i + 1/2 - width / 2 or, upwards, height / 2 - j - 1/2 */
        const double first = 0.5 - size[d] / 2 + out->middle[d] / out->space;
        const double middle = (double)(out->dims[d] / 2);
        out->first[d] = 0;
        out->shift[d] = middle;
        if (out->aligned) {
            out->first[d] = (ptrdiff_t)floor(first + middle);
            out->shift[d] = (double)out->first[d] - first;
        }
    }
}
