/* Growing buffers and bounded cursors. */
#include "base/bytes.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

void cvol_bytes_free(cvol_bytes *bytes)
{
    free(bytes->data);
    memset(bytes, 0, sizeof *bytes);
}

int cvol_bytes_reserve(cvol_bytes *bytes, size_t more)
{
    size_t needed;
    if (bytes->failed || !cvol_size_add(&needed, bytes->size, more)) {
        bytes->failed = 1;
        return 0;
    }
    if (needed <= bytes->capacity)
        return 1;
    size_t capacity = bytes->capacity + bytes->capacity / 2 + 256;
    if (capacity < needed)
        capacity = needed;
    uint8_t *data = realloc(bytes->data, capacity);
    if (!data) {
        bytes->failed = 1;
        return 0;
    }
    bytes->data = data;
    bytes->capacity = capacity;
    return 1;
}

void cvol_bytes_append(cvol_bytes *bytes, const void *data, size_t size)
{
    if (size == 0 || !cvol_bytes_reserve(bytes, size))
        return;
    memcpy(bytes->data + bytes->size, data, size);
    bytes->size += size;
}

void cvol_bytes_put_text(cvol_bytes *bytes, const char *text)
{
    cvol_bytes_append(bytes, text, strlen(text));
}

static void put_little_endian(cvol_bytes *bytes, uint64_t value, int size)
{
    uint8_t raw[8];
    for (int i = 0; i < size; i++)
        raw[i] = (uint8_t)(value >> 8 * i);
    cvol_bytes_append(bytes, raw, (size_t)size);
}

void cvol_bytes_put_u8(cvol_bytes *bytes, uint8_t value)
{
    cvol_bytes_append(bytes, &value, 1);
}

void cvol_bytes_put_u16(cvol_bytes *bytes, uint16_t value)
{
    put_little_endian(bytes, value, 2);
}

void cvol_bytes_put_u32(cvol_bytes *bytes, uint32_t value)
{
    put_little_endian(bytes, value, 4);
}

void cvol_bytes_put_u64(cvol_bytes *bytes, uint64_t value)
{
    put_little_endian(bytes, value, 8);
}

void cvol_bytes_put_f64(cvol_bytes *bytes, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    cvol_bytes_put_u64(bytes, bits);
}

void cvol_bytes_put_varint(cvol_bytes *bytes, uint64_t value)
{
    while (value >= 128) {
        cvol_bytes_put_u8(bytes, (uint8_t)(value | 128));
        value >>= 7;
    }
    cvol_bytes_put_u8(bytes, (uint8_t)value);
}

cvol_cursor cvol_cursor_make(const void *data, size_t size)
{
    return (cvol_cursor){.data = data, .size = size};
}

size_t cvol_cursor_left(const cvol_cursor *cursor)
{
    return cursor->failed ? 0 : cursor->size - cursor->at;
}

const uint8_t *cvol_cursor_take(cvol_cursor *cursor, size_t size)
{
    if (cursor->failed || size > cursor->size - cursor->at) {
        cursor->failed = 1;
        return NULL;
    }
    const uint8_t *place = cursor->data + cursor->at;
    cursor->at += size;
    return place;
}

static uint64_t take_little_endian(cvol_cursor *cursor, size_t size)
{
    const uint8_t *raw = cvol_cursor_take(cursor, size);
    uint64_t value = 0;
    if (raw)
        for (size_t i = 0; i < size; i++)
            value |= (uint64_t)raw[i] << 8 * i;
    return value;
}

uint8_t cvol_cursor_u8(cvol_cursor *cursor)
{
    return (uint8_t)take_little_endian(cursor, 1);
}

uint16_t cvol_cursor_u16(cvol_cursor *cursor)
{
    return (uint16_t)take_little_endian(cursor, 2);
}

uint32_t cvol_cursor_u32(cvol_cursor *cursor)
{
    return (uint32_t)take_little_endian(cursor, 4);
}

uint64_t cvol_cursor_u64(cvol_cursor *cursor)
{
    return take_little_endian(cursor, 8);
}

double cvol_cursor_f64(cvol_cursor *cursor)
{
    uint64_t bits = cvol_cursor_u64(cursor);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

uint64_t cvol_cursor_varint(cvol_cursor *cursor)
{
    uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
        uint8_t byte = cvol_cursor_u8(cursor);
        if (shift == 63 && byte > 1)
            break;
        value |= (uint64_t)(byte & 127) << shift;
        if (!(byte & 128))
            return value;
    }
    cursor->failed = 1;
    return 0;
}
