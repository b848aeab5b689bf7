/* Names of datasets within files, and writing, which needs no library. */
#ifndef CVOL_VOLUME_FORMATS_HDF5_H
#define CVOL_VOLUME_FORMATS_HDF5_H

#include <stddef.h>

#include "volume/io/stored.h"

/* The length of FILE in FILE:INSIDE, if FILE is a file and the whole path is not; else the whole
 * length. */
size_t cvol_hdf5_file_length(const char *path);

/* A format's plan (format.h). */
int cvol_hdf5_plan(cvol_context *context, cvol_write_plan *plan, const cvol_grid *grid,
                   const char *path);

#endif
