/* Packed content of sections: one zstd frame of 32-bit and 16-bit numbers in byte planes.
 *
 * A plane holds the lowest byte of each number, the next plane the next byte of each, and so on.
 * zstd compresses planes better because bytes of equal weight are similar. */
#ifndef CVOL_CODEC_SECTION_PACKED_H
#define CVOL_CODEC_SECTION_PACKED_H

#include "base/bytes.h"
#include "cvol/base.h"

/* A frame of n bytes unpacks to at most this many times n: a zstd block gives at most 128 KiB, and
 * takes at least four bytes. */
#define CVOL_PACKED_EXPANSION UINT64_C(32768)

/* Appends the lowest `bytes` bytes of each of `count` numbers of 32 bits (uint32_t or float), as
 * planes. */
void cvol_planes_put(cvol_bytes *out, const void *numbers, size_t count, int bytes);
/* Reads them back; missing bytes are 0, and set `failed`. */
void cvol_planes_take(void *numbers, size_t count, int bytes, cvol_cursor *from);

/* Appends the frame of raw bytes. Errors: MEMORY. */
int cvol_packed_put(cvol_context *context, cvol_bytes *out, const cvol_bytes *raw);
/* Unpacks the rest of the section's content, which must be one frame of exactly `size` bytes;
 * checks `size` against the frame's own length and the context's limit before it allocates memory.
 * The caller frees *raw. Errors: CORRUPT, LIMIT, MEMORY. */
int cvol_packed_take(cvol_context *context, uint8_t **raw, uint64_t size, cvol_cursor *content,
                     const char *tag, const char *name);

/* ZSTD_compress, with the same frame from every processor. Returns its size or zstd's error. */
size_t cvol_zstd_put(void *out, size_t room, const void *data, size_t size, int level);
/* Unpacks one frame into exactly `size` bytes. Returns CVOL_OK, CVOL_ERROR_MEMORY if zstd lacks
 * memory, or CVOL_ERROR_CORRUPT; no message. */
int cvol_zstd_take(void *out, size_t size, const uint8_t *frame, size_t bytes);

#endif
