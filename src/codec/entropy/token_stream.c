/* Token streams: growth, the writer's reverse pass, and the ends. */
#include "codec/entropy/token_stream.h"

#include <stdlib.h>
#include <string.h>

/* ---- writing ---------------------------------------------------------------------------- */

void cvol_token_writer_start(cvol_token_writer *writer)
{
    writer->count = 0;
    writer->raw.size = 0;
    writer->raw_bits = 0;
    writer->raw_count = 0;
    writer->failed = 0;
}

void cvol_token_writer_free(cvol_token_writer *writer)
{
    free(writer->tokens);
    cvol_bytes_free(&writer->raw);
}

int cvol_token_writer_grow(cvol_token_writer *writer)
{
    const size_t capacity = writer->capacity ? 2 * writer->capacity : 4096;
    uint32_t *tokens = realloc(writer->tokens, capacity * sizeof *tokens);
    if (!tokens) {
        writer->failed = 1;
        return 0;
    }
    writer->tokens = tokens;
    writer->capacity = capacity;
    return 1;
}

void cvol_raw_put(cvol_token_writer *writer, uint32_t value, int count)
{
    writer->raw_bits |= (value & ((UINT64_C(1) << count) - 1)) << writer->raw_count;
    writer->raw_count += count;
    if (writer->raw_count >= 32) {
        cvol_bytes_put_u32(&writer->raw, (uint32_t)writer->raw_bits);
        writer->raw_bits >>= 32;
        writer->raw_count -= 32;
    }
}

void cvol_token_writer_count(const cvol_token_writer *writer, cvol_token_counts *counts)
{
    uint64_t *of = &counts->of[0][0];
    for (size_t i = 0; i < writer->count; i++)
        of[writer->tokens[i]]++;
}

/* Writes the words of the tokens, last token first, into scratch memory after out->size; returns
 * the state. */
static uint32_t write_words(const cvol_token_writer *writer, const cvol_token_tables *tables,
                            uint8_t *end, uint8_t **begin)
{
    uint32_t x = UINT32_C(1) << 16;
    for (size_t i = writer->count; i > 0; i--) {
        const uint32_t entry = writer->tokens[i - 1];
        const uint16_t *bounds = tables->rows[entry >> 4].bounds + 7 + (entry & 15);
        const uint32_t first = bounds[0], frequency = bounds[1] - first;
        if (x >> 18 >= frequency) {
            *--end = (uint8_t)(x >> 8);
            *--end = (uint8_t)x;
            x >>= 16;
        }
        x = (x / frequency << CVOL_TOKEN_SCALE) + x % frequency + first;
    }
    *begin = end;
    return x;
}

int cvol_token_writer_finish(cvol_token_writer *writer, const cvol_token_tables *tables,
                             cvol_bytes *out)
{
    for (; writer->raw_count > 0; writer->raw_count -= 8, writer->raw_bits >>= 8)
        cvol_bytes_put_u8(&writer->raw, (uint8_t)writer->raw_bits);
    writer->raw_count = 0;
    if (writer->failed || writer->raw.failed)
        return 0;
    if (!writer->count && !writer->raw.size)
        return 1;
    const size_t most = 4 + 2 * writer->count + writer->raw.size;
    if (!cvol_bytes_reserve(out, most))
        return 0;
    uint8_t *start = out->data + out->size, *words;
    const uint32_t x = write_words(writer, tables, start + most, &words);
    const size_t word_bytes = (size_t)(start + most - words);
    for (int i = 0; i < 4; i++)
        start[i] = (uint8_t)(x >> 8 * i);
    memmove(start + 4, words, word_bytes);
    uint8_t *raw = start + 4 + word_bytes;
    for (size_t i = writer->raw.size; i > 0; i--)
        *raw++ = writer->raw.data[i - 1];
    out->size += (size_t)(raw - start);
    return 1;
}

/* ---- reading ---------------------------------------------------------------------------- */

uint32_t cvol_token_take_last(const uint8_t *data, size_t size, size_t at)
{
    return at < size ? data[at] : 0;
}

uint32_t cvol_raw_bits_last(const uint8_t *data, size_t size, size_t at)
{
    uint32_t next = 0;
    for (size_t i = 0; i < 4; i++)
        if (at + i < size)
            next |= (uint32_t)data[size - 1 - at - i] << 8 * i;
    return next;
}

void cvol_token_reader_start(cvol_token_reader *reader, const cvol_token_tables *tables,
                             const uint8_t *data, size_t size)
{
    *reader = (cvol_token_reader){
        .rows = tables->rows, .state = UINT32_C(1) << 16, .data = data, .size = size};
    if (!size)
        return;
    reader->state = 0;
    for (size_t i = 0; i < 4 && i < size; i++)
        reader->state |= (uint32_t)data[i] << 8 * i;
    reader->at = 4;
}

int cvol_token_reader_ended(const cvol_token_reader *reader)
{
    const size_t raw = reader->raw_at - (size_t)reader->raw_count / 8;
    return reader->state == UINT32_C(1) << 16 && reader->at + raw == reader->size;
}
