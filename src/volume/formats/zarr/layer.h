/* The slices of a volume in a Zarr array, read by layers of chunks. */
#ifndef CVOL_VOLUME_FORMATS_ZARR_LAYER_H
#define CVOL_VOLUME_FORMATS_ZARR_LAYER_H

#include "volume/formats/zarr/array.h"

typedef struct cvol_zarr_layers {
    cvol_zarr_array array;
    int of[3];                      /* x, y, z: their axes; -1: there is none */
    uint64_t begin[CVOL_ZARR_AXES]; /* the chosen place along other axes */
    size_t dims[3];
    uint8_t *kept; /* the last layer that was read in part */
    size_t kept_number;
} cvol_zarr_layers;

/* Reads slices first .. first + count - 1 of the chosen volume. */
int cvol_zarr_layers_read(cvol_context *context, cvol_zarr_layers *layers, void *out, size_t first,
                          size_t count);
/* Frees what the layers hold. */
void cvol_zarr_layers_close(cvol_zarr_layers *layers);

#endif
