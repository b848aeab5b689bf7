/* JSON files of Zarr folders: loading, and messages that name file, field and value. */
#ifndef CVOL_VOLUME_FORMATS_ZARR_JSON_H
#define CVOL_VOLUME_FORMATS_ZARR_JSON_H

#include <jansson.h>

#include "cvol/base.h"

/* The most axes of an array. */
#define CVOL_ZARR_AXES 8

typedef struct cvol_zarr_json {
    cvol_context *context;
    char *path;   /* the file */
    json_t *root; /* an object; NULL: there is no such file */
} cvol_zarr_json;

/* Loads FOLDER/NAME. Integers that 64 bits with a sign cannot hold become texts. The caller closes
 * it, also after a failure. Errors: IO, FORMAT, MEMORY. */
int cvol_zarr_json_open(cvol_context *context, cvol_zarr_json *json, const char *folder,
                        const char *name);
void cvol_zarr_json_close(cvol_zarr_json *json);

/* "FILE: 'field' is VALUE, must be ..."; value NULL: missing. Returns `code`. */
int cvol_zarr_json_fail(const cvol_zarr_json *json, int code, const char *field,
                        const json_t *value, const char *must);

/* Reads a list of integers from `least`. *count: 0 for any number of them up to CVOL_ZARR_AXES,
 * which is then stored; else the required number. */
int cvol_zarr_json_sizes(const cvol_zarr_json *json, const char *field, const json_t *list,
                         uint64_t least, uint64_t *out, int *count);

/* FOLDER/NAME, which the caller frees; NULL without memory. */
char *cvol_zarr_join(const char *folder, const char *name);

#endif
