/* Chunks of Zarr arrays: finding their bytes, and unpacking them. */
#ifndef CVOL_VOLUME_FORMATS_ZARR_CHUNK_H
#define CVOL_VOLUME_FORMATS_ZARR_CHUNK_H

#include "volume/formats/zarr/array.h"

/* Reads and unpacks the chunk at `place` into `out`, which has array->chunk_bytes bytes: elements
 * in the order of array->order, in the machine's byte order. *is_missing: there is none, and `out`
 * is undefined. Threads may call it at once, each with its own context. Errors: IO, FORMAT,
 * UNSUPPORTED, MEMORY, those of .cvol files. */
int cvol_zarr_chunk_read(cvol_context *context, void *out, int *is_missing,
                         const cvol_zarr_array *array, const uint64_t place[CVOL_ZARR_AXES]);

/* Decodes a chunk of codec cvol. */
int cvol_zarr_decode_cvol(cvol_context *context, void *out, const cvol_zarr_array *array,
                          const uint8_t *data, size_t size, const char *name);

#endif
