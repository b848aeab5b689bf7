/* Samples in memory in another order than the grid's: permuted axes, several values per voxel. */
#ifndef CVOL_VOLUME_IO_STRIDED_H
#define CVOL_VOLUME_IO_STRIDED_H

#include "volume/io/stored.h"

typedef struct cvol_strided {
    uint8_t *data;    /* freed with free() */
    size_t size;      /* bytes of it */
    size_t first;     /* of element (0, 0, 0), counted in elements, */
    size_t stride[3]; /* and the distance of neighbours */
    int big_endian;   /* elements are big-endian */
    int is_half;      /* elements are half floats, and samples floats */
} cvol_strided;

/* Copies `count` elements of `element` bytes, `step` bytes apart in `in`, one after the other to
 * `out`. is_half: they are half floats in the machine's byte order, and become floats. */
void cvol_strided_gather(void *out, const void *in, size_t count, size_t step, size_t element,
                         int is_half);

/* Makes these samples the grid's, whose shape and type are set; takes over the data, also if it
 * fails. All elements must lie within the data. */
int cvol_strided_take(cvol_context *context, cvol_stored *stored, const cvol_strided *strided,
                      const cvol_grid *grid, const char *path);
/* The same for `count` elements at `offset` of a file, which must have all of them. */
int cvol_strided_read(cvol_context *context, cvol_stored *stored, cvol_strided *strided,
                      const cvol_grid *grid, const char *path, uint64_t offset, size_t count);

#endif
