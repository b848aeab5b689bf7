/* Writing images of OME-Zarr 0.4 and 0.5 (ngff.openmicroscopy.org). */
#ifndef CVOL_VOLUME_FORMATS_ZARR_WRITE_H
#define CVOL_VOLUME_FORMATS_ZARR_WRITE_H

#include "cvol/series.h"
#include "volume/io/stored.h"

/* Opens a folder for the volumes of a series (NULL: one volume), all channels of time 0 first.
 * labels: coarser levels hold samples of the volume instead of means. */
int cvol_zarr_write_open(cvol_context *context, cvol_write_sink *sink, const cvol_grid *grid,
                         const char *path, const cvol_series_options *series, int labels);

#endif
