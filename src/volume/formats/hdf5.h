/* Names of datasets within files. */
#ifndef CVOL_VOLUME_FORMATS_HDF5_H
#define CVOL_VOLUME_FORMATS_HDF5_H

#include <stddef.h>

/* The length of FILE in FILE:INSIDE, if FILE is a file and the whole path is not; else the whole
 * length. */
size_t cvol_hdf5_file_length(const char *path);

#endif
