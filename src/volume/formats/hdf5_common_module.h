/* What the parts of the module for HDF5 share. */
#ifndef CVOL_VOLUME_FORMATS_HDF5_COMMON_MODULE_H
#define CVOL_VOLUME_FORMATS_HDF5_COMMON_MODULE_H

#include <hdf5.h>

/* Reads `count` numbers of an attribute, up to 8; 0 if there is none, or it has another number of
 * them. */
int cvol_hdf5_read_doubles(hid_t object, const char *name, double *out, int count);

/* 1 unless samples without chunks are incomplete. Raw ones must lie within the file (none, if they
 * were never written), and compact ones in the dataset's header, where libhdf5 1.10 would read
 * beyond the end. */
int cvol_hdf5_check_storage(hid_t file, hid_t dataset);

#endif
