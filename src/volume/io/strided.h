/* Samples in memory in an order that is not the grid's: axes turned, several values a place. */
#ifndef CVOL_VOLUME_IO_STRIDED_H
#define CVOL_VOLUME_IO_STRIDED_H

#include "volume/io/stored.h"

typedef struct cvol_strided {
    uint8_t *data;    /* freed with free() */
    size_t size;      /* bytes of it */
    size_t first;     /* of element (0, 0, 0), counted in elements, */
    size_t stride[3]; /* and how far apart neighbours are */
    int big_endian;   /* elements are stored high byte first */
    int is_half;      /* elements are half floats, and samples floats */
} cvol_strided;

/* Makes these samples the grid's, whose shape and type are set; takes the data, also when it fails.
 * All elements must be within. */
int cvol_strided_take(cvol_context *context, cvol_stored *stored, const cvol_strided *strided,
                      const cvol_grid *grid, const char *path);
/* The same of `count` elements that lie in a file at `offset`, which must have them all. */
int cvol_strided_read(cvol_context *context, cvol_stored *stored, cvol_strided *strided,
                      const cvol_grid *grid, const char *path, uint64_t offset, size_t count);

#endif
