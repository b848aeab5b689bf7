/* Streams of tokens and raw bits: range asymmetric numeral systems (Duda 2013) with static tables.
 *
 * A stream's state is a number x of 2^16 .. 2^32 - 1. Token t of frequency f, whose numbers begin
 * at b, is read from it as
 *      n = x mod 2^14,  b <= n < b + f;   x = f floor(x / 2^14) + n - b;
 *      if x < 2^16:  x = 2^16 x + the next 16-bit word.
 *
 * The writer inverts this, from the last token to the first, and begins at x = 2^16, where a reader
 * therefore ends. The bytes are x (32 bits), the words in the reader's order, all little-endian,
 * and then the bytes of raw bits, which the reader takes from the last one backwards, the lowest
 * bit of each byte first. A stream without tokens and raw bits has no bytes. */
#ifndef CVOL_CODEC_ENTROPY_TOKEN_STREAM_H
#define CVOL_CODEC_ENTROPY_TOKEN_STREAM_H

#include <stddef.h>
#include <stdint.h>

#include "base/bytes.h"
#include "base/vector.h"
#include "codec/entropy/token_tables.h"

/* ---- writing ---------------------------------------------------------------------------- */

typedef struct cvol_token_writer {
    uint32_t *tokens; /* row * 16 + token */
    size_t count, capacity;
    cvol_bytes raw;
    uint64_t raw_bits;
    int raw_count, failed; /* failed: memory ran out */
} cvol_token_writer;

/* Starts anew; keeps the buffers of an earlier use (the first use: a zeroed struct). */
void cvol_token_writer_start(cvol_token_writer *writer);
void cvol_token_writer_free(cvol_token_writer *writer);
/* Ends the stream and appends it to `out`. 1, or 0 when memory ran out. */
int cvol_token_writer_finish(cvol_token_writer *writer, const cvol_token_tables *tables,
                             cvol_bytes *out);
/* Adds the written tokens to the counts. */
void cvol_token_writer_count(const cvol_token_writer *writer, cvol_token_counts *counts);

int cvol_token_writer_grow(cvol_token_writer *writer);
CVOL_INLINE void cvol_token_put(cvol_token_writer *writer, int row, uint32_t token)
{
    if (__builtin_expect(writer->count == writer->capacity, 0) && !cvol_token_writer_grow(writer))
        return;
    writer->tokens[writer->count++] = (uint32_t)row << 4 | token;
}
/* Writes the low `count` <= 32 bits of value. */
void cvol_raw_put(cvol_token_writer *writer, uint32_t value, int count);

/* ---- reading ---------------------------------------------------------------------------- */

/* Bytes beyond a stream's ends read as zeros. */
typedef struct cvol_token_reader {
    const cvol_token_row *rows;
    uint32_t state;
    int raw_count;
    uint64_t raw_bits;
    const uint8_t *data;
    size_t size, at, raw_at; /* bytes taken from the front and from the back */
} cvol_token_reader;

void cvol_token_reader_start(cvol_token_reader *reader, const cvol_token_tables *tables,
                             const uint8_t *data, size_t size);
/* Returns 1 if the stream was read exactly to its end; otherwise the result is invalid. */
int cvol_token_reader_ended(const cvol_token_reader *reader);

uint32_t cvol_token_take_last(const uint8_t *data, size_t size, size_t at);
uint32_t cvol_raw_bits_last(const uint8_t *data, size_t size, size_t at);

/* Advances the state past a token whose numbers are begin .. end - 1. */
CVOL_INLINE void cvol_token_pass(cvol_token_reader *reader, uint32_t n, uint32_t begin,
                                 uint32_t end)
{
    uint32_t x = (end - begin) * (reader->state >> CVOL_TOKEN_SCALE) + n - begin;
    if (x < UINT32_C(1) << 16) {
        uint32_t next;
        if (__builtin_expect(reader->at + 2 <= reader->size, 1))
            next = (uint32_t)reader->data[reader->at] | (uint32_t)reader->data[reader->at + 1] << 8;
        else
            next = cvol_token_take_last(reader->data, reader->size, reader->at);
        reader->at += 2;
        x = x << 16 | next;
    }
    reader->state = x;
}

CVOL_INLINE uint32_t cvol_token_take(cvol_token_reader *reader, int row)
{
    const uint16_t *bounds = reader->rows[row].bounds;
    const uint32_t n = reader->state & ((1u << CVOL_TOKEN_SCALE) - 1);
    uint32_t t = 0;
    while (n >= bounds[8 + t])
        t++;
    cvol_token_pass(reader, n, bounds[7 + t], bounds[8 + t]);
    return t;
}

/* Reads `count` <= 32 raw bits. */
CVOL_INLINE uint32_t cvol_raw_take(cvol_token_reader *reader, int count)
{
    if (__builtin_expect(reader->raw_count < count, 0)) {
        uint32_t next;
        if (__builtin_expect(reader->raw_at + 4 <= reader->size, 1)) {
            const uint8_t *p = reader->data + reader->size - reader->raw_at - 4;
            next = (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
        } else {
            next = cvol_raw_bits_last(reader->data, reader->size, reader->raw_at);
        }
        reader->raw_at += 4;
        reader->raw_bits |= (uint64_t)next << reader->raw_count;
        reader->raw_count += 32;
    }
    const uint32_t value = (uint32_t)(reader->raw_bits & ((UINT64_C(1) << count) - 1));
    reader->raw_bits >>= count;
    reader->raw_count -= count;
    return value;
}

#endif
