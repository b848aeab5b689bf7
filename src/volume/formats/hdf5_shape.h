/* The description of a dataset of HDF5, in which the module for HDF5 tells it. */
#ifndef CVOL_VOLUME_FORMATS_HDF5_SHAPE_H
#define CVOL_VOLUME_FORMATS_HDF5_SHAPE_H

#include <stddef.h>
#include <stdint.h>

#define CVOL_HDF5_RANK 8

/* A dimension of MINC 2; `start` and `step` are millimetres along the cosines, or seconds. */
typedef struct cvol_hdf5_dimension {
    int is_spatial, is_time, is_irregular;
    double start, step, cosines[3];
} cvol_hdf5_dimension;

/* The description of an image of MINC 2. */
typedef struct cvol_hdf5_minc {
    int is_image; /* 0: the dataset is none */
    cvol_hdf5_dimension dimension[CVOL_HDF5_RANK];
    double valid[2];            /* the stored samples that mean `least` and `most` */
    int scaled;                 /* leading axes, at each place of which these differ */
    const double *least, *most; /* NULL: unknown; they live as long as the dataset */
} cvol_hdf5_minc;

typedef struct cvol_hdf5_shape {
    int rank;
    uint64_t dims[CVOL_HDF5_RANK]; /* the last one runs fastest */
    int type;                      /* cvol_type; 0: none */
    int is_int64, is_uint64;       /* elements are such integers, and type has their size */
    double size_um[3];             /* attribute element_size_um, z first; 0: there is none */
    cvol_hdf5_minc minc;
} cvol_hdf5_shape;

#endif
