/* The interface of the module for HDF5's datasets. It is separate because libhdf5 depends on many
 * libraries and takes long to start. It uses nothing of cvol, so the module is independent. */
#ifndef CVOL_VOLUME_FORMATS_HDF5_MODULE_H
#define CVOL_VOLUME_FORMATS_HDF5_MODULE_H

#include "volume/formats/hdf5_shape.h"

#define CVOL_HDF5_MODULE "cvol_hdf5.so"

typedef struct cvol_hdf5_dataset cvol_hdf5_dataset;

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
