/* The part of the module for HDF5 that reads the description of an image of MINC 2. */
#ifndef CVOL_VOLUME_FORMATS_HDF5_MINC_MODULE_H
#define CVOL_VOLUME_FORMATS_HDF5_MINC_MODULE_H

#include <hdf5.h>

#include "volume/formats/hdf5_shape.h"

/* The dataset of the image, and those of the smallest and largest value of its slices. */
#define CVOL_HDF5_MINC_IMAGE "/minc-2.0/image/0/image"

/* Sets shape->minc if the dataset is an image of MINC 2; *kept are the numbers to which it points,
 * freed with free(). 0 and the reason in `message` if they cannot be read. */
int cvol_hdf5_read_minc(hid_t file, hid_t dataset, cvol_hdf5_shape *shape, double **kept,
                        char *message, size_t room);

#endif
