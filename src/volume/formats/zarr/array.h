/* Arrays of Zarr: shape, chunks, sample type and codecs, from .zarray (format 2) or zarr.json
 * (format 3). */
#ifndef CVOL_VOLUME_FORMATS_ZARR_ARRAY_H
#define CVOL_VOLUME_FORMATS_ZARR_ARRAY_H

#include "volume/formats/zarr/json.h"
#include "volume/io/wide.h"

/* Shards that are remembered, so that their indices are checked once. */
#define CVOL_ZARR_CHECKED 1024

typedef enum cvol_zarr_packing {
    CVOL_ZARR_PLAIN,
    CVOL_ZARR_DEFLATE, /* zlib or gzip */
    CVOL_ZARR_ZSTD,
    CVOL_ZARR_BLOSC,
    CVOL_ZARR_CVOL /* doc/zarr.md */
} cvol_zarr_packing;

typedef struct cvol_zarr_array {
    char *path; /* its folder */
    int rank;
    uint64_t shape[CVOL_ZARR_AXES];
    uint64_t chunk[CVOL_ZARR_AXES]; /* the samples that are packed together */
    uint64_t shard[CVOL_ZARR_AXES]; /* chunks in one file along each axis */
    int is_sharded;
    int index_at_start;         /* of the shards */
    size_t index_checksum;      /* bytes of it */
    _Atomic uint64_t *checked;  /* [CVOL_ZARR_CHECKED] shards + 1 whose index has been checked */
    int order[CVOL_ZARR_AXES];  /* the axes of a chunk as they are stored, the fastest last */
    char names[CVOL_ZARR_AXES]; /* of axes, by zarr.json: t, c, z, y, x; 0: none, or another */
    cvol_type type;             /* of the samples that are read */
    int is_half;                /* stored as half floats */
    cvol_wide wide;             /* stored as integers of 64 bits; the type is CVOL_WIDE_TYPE */
    int big_endian;
    size_t element;  /* bytes of a stored sample */
    uint8_t fill[8]; /* the sample of missing chunks, in the machine's byte order */
    cvol_zarr_packing packing;
    int has_checksum;   /* CRC-32C behind each chunk */
    const char *prefix; /* of chunks' names: "" or "c" */
    char separator;
    size_t chunk_bytes; /* of an unpacked chunk */
} cvol_zarr_array;

/* Reads the array of a folder. json is that of .zarray or zarr.json. The caller frees array->path
 * and array->checked, also after a failure. Errors: FORMAT, UNSUPPORTED, LIMIT, MEMORY. */
int cvol_zarr_array_read_2(cvol_zarr_array *array, const cvol_zarr_json *json);
int cvol_zarr_array_read_3(cvol_zarr_array *array, const cvol_zarr_json *json);

/* ---- for both formats ---- */

/* Sets type, element, is_half, wide by the name of NumPy without byte order, "u1". 0: unknown. */
int cvol_zarr_set_type(cvol_zarr_array *array, const char *name);
int cvol_zarr_set_fill(cvol_zarr_array *array, const cvol_zarr_json *json, const json_t *value);
/* The last step: checks that sizes fit into memory, and sets chunk_bytes. `field` has the chunks.
 */
int cvol_zarr_complete(cvol_zarr_array *array, const cvol_zarr_json *json, const char *field,
                       const json_t *chunks);

#endif
