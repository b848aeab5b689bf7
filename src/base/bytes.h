/* Bytes of files: growing buffers for writing, bounded cursors for reading; little-endian. */
#ifndef CVOL_BASE_BYTES_H
#define CVOL_BASE_BYTES_H

#include <stddef.h>
#include <stdint.h>

/* A growing buffer. Lack of memory sets `failed`, which stays set: check it once at the end. */
typedef struct cvol_bytes {
    uint8_t *data;
    size_t size, capacity;
    int failed;
} cvol_bytes;

void cvol_bytes_free(cvol_bytes *bytes);
/* Reserves `more` bytes beyond size; 1 on success. */
int cvol_bytes_reserve(cvol_bytes *bytes, size_t more);
void cvol_bytes_append(cvol_bytes *bytes, const void *data, size_t size);
/* The characters of a string, without its end. */
void cvol_bytes_put_text(cvol_bytes *bytes, const char *text);
void cvol_bytes_put_u8(cvol_bytes *bytes, uint8_t value);
void cvol_bytes_put_u16(cvol_bytes *bytes, uint16_t value);
void cvol_bytes_put_u32(cvol_bytes *bytes, uint32_t value);
void cvol_bytes_put_u64(cvol_bytes *bytes, uint64_t value);
void cvol_bytes_put_f64(cvol_bytes *bytes, double value);
/* LEB128: seven bits per byte, low bits first. */
void cvol_bytes_put_varint(cvol_bytes *bytes, uint64_t value);

/* Reads within data[0 .. size). A read past the end gives 0 and sets `failed`, which stays set:
 * check it once after a group of reads. */
typedef struct cvol_cursor {
    const uint8_t *data;
    size_t size, at;
    int failed;
} cvol_cursor;

cvol_cursor cvol_cursor_make(const void *data, size_t size);
size_t cvol_cursor_left(const cvol_cursor *cursor);
/* The next `size` bytes in place, or NULL. */
const uint8_t *cvol_cursor_take(cvol_cursor *cursor, size_t size);
uint8_t cvol_cursor_u8(cvol_cursor *cursor);
uint16_t cvol_cursor_u16(cvol_cursor *cursor);
uint32_t cvol_cursor_u32(cvol_cursor *cursor);
uint64_t cvol_cursor_u64(cvol_cursor *cursor);
double cvol_cursor_f64(cvol_cursor *cursor);
uint64_t cvol_cursor_varint(cvol_cursor *cursor);

/* CRC-32C (Castagnoli, reflected 0x82F63B78, start and final xor 0xFFFFFFFF). */
uint32_t cvol_crc32c(const void *data, size_t size);
/* The CRC-32C of bytes with CRC `crc`, followed by data; the CRC of no bytes is 0. */
uint32_t cvol_crc32c_more(uint32_t crc, const void *data, size_t size);

#endif
