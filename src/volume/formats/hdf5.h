/* Names of datasets within files. */
#ifndef CVOL_VOLUME_FORMATS_HDF5_H
#define CVOL_VOLUME_FORMATS_HDF5_H

#include <stddef.h>

/* Of FILE:INSIDE, the length of FILE, if that is a file and the whole is none; else that of all. */
size_t cvol_hdf5_file_length(const char *path);

#endif
