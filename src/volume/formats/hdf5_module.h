/* The interface of the module for HDF5's datasets. It is separate because libhdf5 depends on many
 * libraries and takes long to start. It uses nothing of cvol, so the module is independent. */
#ifndef CVOL_VOLUME_FORMATS_HDF5_MODULE_H
#define CVOL_VOLUME_FORMATS_HDF5_MODULE_H

#include <stddef.h>
#include <stdint.h>

#define CVOL_HDF5_MODULE "cvol_hdf5.so"
#define CVOL_HDF5_RANK 8

typedef struct cvol_hdf5_dataset cvol_hdf5_dataset;

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

/* All return 1 on success, else 0 and the end of a message in `message`. Any thread may call
 * them. */
typedef struct cvol_hdf5_functions {
    /* A dataset by its path; path NULL: the image of MINC 2, or the only one of three axes or
     * more. */
    int (*open)(cvol_hdf5_dataset **out, cvol_hdf5_shape *shape, const char *file, const char *path,
                char *message, size_t room);
    /* A box, in the machine's byte order. */
    int (*read)(cvol_hdf5_dataset *dataset, void *out, const uint64_t *begin, const uint64_t *count,
                char *message, size_t room);
    void (*close)(cvol_hdf5_dataset *dataset);
} cvol_hdf5_functions;

__attribute__((visibility("default"))) extern const cvol_hdf5_functions cvol_hdf5_module;

#endif
