/* The .cvol container, version 0: doc/format.md is its description. */
#ifndef CVOL_CODEC_CONTAINER_H
#define CVOL_CODEC_CONTAINER_H

#include "array/array.h"
#include "base/bytes.h"
#include "codec/group.h"

enum { CVOL_SIGNATURE_BYTES = 8, CVOL_FORMAT_VERSION = 0 };

/* 1 if data begins with the signature. */
int cvol_container_is(const uint8_t *data, size_t size);
/* How many bytes of data are the signature's; its byte `i`. */
size_t cvol_container_matches(const uint8_t *data, size_t size);
uint8_t cvol_container_signature(size_t i);

/* Appends all that comes before the groups' bytes. The file is `out` followed by the groups in
 * order. Only volumes in DCT blocks have groups (and must have ranges); of others `out` is the
 * file. Errors: DATA, MEMORY. */
int cvol_container_begin(cvol_context *context, cvol_bytes *out, const cvol_array *array,
                         const cvol_groups *groups);

/* A box of samples, [begin, end). */
typedef struct cvol_box {
    size_t begin[3], end[3];
} cvol_box;

/* Reads a file from memory as far as the box needs it: what cvol_array_read_box does. box NULL:
 * all. Errors: those of both. */
int cvol_container_read_box(cvol_context *context, cvol_array **out, const uint8_t *data,
                            size_t size, const cvol_box *box, const char *name);
/* Reads a whole file from memory; `name` begins its messages. Errors: FORMAT, CORRUPT, LIMIT,
 * UNSUPPORTED, MEMORY, CANCELLED. */
int cvol_container_read(cvol_context *context, cvol_array **out, const uint8_t *data, size_t size,
                        const char *name);

#endif
