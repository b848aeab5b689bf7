/* Images of MINC 2 (en.wikibooks.org/wiki/MINC): the geometry and the values of a dataset of HDF5.
 */
#ifndef CVOL_VOLUME_FORMATS_MINC_H
#define CVOL_VOLUME_FORMATS_MINC_H

#include "volume/formats/hdf5_shape.h"
#include "volume/io/axes.h"

/* How stored samples become values. */
typedef struct cvol_minc_scale {
    int is_by_slice;  /* samples of `stored` become samples of the grid's type by slice */
    cvol_type stored; /* the type in the file */
} cvol_minc_scale;

/* Sets the grid's geometry by the image's dimensions, whose axes are chosen, and its scale of
 * values; if slices have different ones, scale->is_by_slice and the type of their values. Errors:
 * UNSUPPORTED, FORMAT. */
int cvol_minc_complete(cvol_context *context, cvol_grid *grid, cvol_minc_scale *scale,
                       const cvol_hdf5_shape *shape, const cvol_axes *axes, const char *name);

/* Makes values of `count` samples, those of slice z of the chosen volume. */
void cvol_minc_convert(void *out, cvol_type type, const void *samples, cvol_type stored,
                       size_t count, const cvol_hdf5_minc *minc, const cvol_axes *axes, size_t z);

#endif
