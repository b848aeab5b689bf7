/* Writing HDF5, which needs no library. */
#ifndef CVOL_VOLUME_FORMATS_HDF5_H
#define CVOL_VOLUME_FORMATS_HDF5_H

#include "volume/io/stored.h"

/* A format's plan (format.h). Errors: ARGUMENT (a name of a dataset that cannot be). */
int cvol_hdf5_plan(cvol_context *context, cvol_write_plan *plan, const cvol_grid *grid,
                   const char *path);

#endif
