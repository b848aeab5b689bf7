/* What a NRRD header says, between its parser (nrrd.c) and its axes (nrrd_axes.c). */
#ifndef CVOL_VOLUME_FORMATS_NRRD_H
#define CVOL_VOLUME_FORMATS_NRRD_H

#include "cvol/base.h"

/* The fields that are read. */
enum nrrd_field {
    NRRD_TYPE,
    NRRD_DIMENSION,
    NRRD_SIZES,
    NRRD_KINDS,
    NRRD_ENCODING,
    NRRD_ENDIAN,
    NRRD_SPACINGS,
    NRRD_SPACE,
    NRRD_SPACE_DIMENSION,
    NRRD_SPACE_DIRECTIONS,
    NRRD_SPACE_ORIGIN,
    NRRD_SPACE_UNITS,
    NRRD_UNITS,
    NRRD_LINE_SKIP,
    NRRD_BYTE_SKIP,
    NRRD_DATA_FILE,
    NRRD_FIELDS
};

typedef struct nrrd {
    cvol_context *context;
    const char *path;
    const char *value[NRRD_FIELDS]; /* NULL where the header has no such field */
    size_t data_offset;             /* behind the header */
    int ended;                      /* an empty line ended the header */
    size_t dimension;
    size_t kept[3]; /* which axes of the file are the grid's */
    cvol_grid grid;
} nrrd;

/* "PATH: FIELD 'VALUE' WHAT", as a FORMAT or an UNSUPPORTED error. */
int cvol_nrrd_fail(const nrrd *n, const char *field, const char *value, const char *what);
int cvol_nrrd_unsupported(const nrrd *n, const char *field, const char *value, const char *what);

/* Everything about axes: which there are, how long, and how they lie. */
int cvol_nrrd_read_axes(nrrd *n);

#endif
