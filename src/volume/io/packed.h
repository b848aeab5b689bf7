/* A file that may be packed by gzip, read from its beginning on. */
#ifndef CVOL_VOLUME_IO_PACKED_H
#define CVOL_VOLUME_IO_PACKED_H

#include "volume/io/inflate.h"

typedef struct cvol_packed {
    cvol_input input;
    cvol_inflater *inflater; /* NULL: the file is not packed */
    uint64_t at;             /* of the next byte, unpacked */
} cvol_packed;

/* 1 if a file that begins with these bytes is packed. */
int cvol_packed_is(const uint8_t *head, size_t size);
/* The caller closes it, also after a failure. */
int cvol_packed_open(cvol_context *context, cvol_packed *file, const char *path);
void cvol_packed_close(cvol_packed *file);
/* Reads the next `size` bytes; *got is less at the end. out NULL: they are skipped. */
int cvol_packed_read(cvol_context *context, cvol_packed *file, void *out, uint64_t size,
                     uint64_t *got);

#endif
