/* Packed content of sections: one zstd frame of 32-bit and 16-bit numbers, byte by byte.
 *
 * Numbers are laid out in planes: the lowest byte of each, then the next byte of each, and so on.
 * Bytes of equal weight are alike, which is what zstd finds.
 */
#ifndef CVOL_CODEC_SECTION_PACKED_H
#define CVOL_CODEC_SECTION_PACKED_H

#include "base/bytes.h"
#include "cvol/base.h"

/* A frame of n bytes holds at most this many times n: no block of it gives more than 128 KiB, or
 * takes less than four bytes. */
#define CVOL_PACKED_EXPANSION UINT64_C(32768)

/* Appends the lowest `bytes` bytes of each of `count` numbers of 32 bits (uint32_t or float), as
 * planes. */
void cvol_planes_put(cvol_bytes *out, const void *numbers, size_t count, int bytes);
/* Reads them back; what is missing is 0 and sets `failed`. */
void cvol_planes_take(void *numbers, size_t count, int bytes, cvol_cursor *from);

/* Appends the frame of raw bytes. Errors: MEMORY. */
int cvol_packed_put(cvol_context *context, cvol_bytes *out, const cvol_bytes *raw);
/* Unpacks what is left of the section's content, which must be one frame of exactly `size` bytes;
 * that is held against the frame's own length and the context's limit before memory is spent on it.
 * The caller frees *raw. Errors: CORRUPT, LIMIT, MEMORY. */
int cvol_packed_take(cvol_context *context, uint8_t **raw, uint64_t size, cvol_cursor *content,
                     const char *tag, const char *name);

/* Unpacks one frame into `size` bytes, all of them. CVOL_ERROR_MEMORY where zstd has none, which is
 * no damage; CVOL_ERROR_CORRUPT; no message. */
int cvol_zstd_take(void *out, size_t size, const uint8_t *frame, size_t bytes);

#endif
