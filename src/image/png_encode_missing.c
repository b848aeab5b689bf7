/* PNG files in memory (W3C, Portable Network Graphics), by zlib, for builds without libpng: every
 * row has the filter Up, the difference to the row above. */
#include "image/png_encode.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "base/context.h"
#include "base/memory.h"

enum { FILTER_UP = 2, PIECE = 1 << 16 };

static void put_u32_big_endian(uint8_t out[4], uint32_t value)
{
    for (int i = 0; i < 4; i++)
        out[i] = (uint8_t)(value >> (24 - 8 * i));
}

/* A chunk: length, kind, content, and the checksum of both. */
static void put_chunk(cvol_bytes *out, const char *kind, const uint8_t *content, size_t size)
{
    uint8_t word[4];
    put_u32_big_endian(word, (uint32_t)size);
    cvol_bytes_append(out, word, sizeof word);
    cvol_bytes_append(out, kind, 4);
    if (size)
        cvol_bytes_append(out, content, size);
    uLong check = crc32(0, (const Bytef *)kind, 4);
    if (size)
        check = crc32(check, content, (uInt)size);
    put_u32_big_endian(word, (uint32_t)check);
    cvol_bytes_append(out, word, sizeof word);
}

static void put_header(cvol_bytes *out, const cvol_png_rows *rows)
{
    static const uint8_t signature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    static const uint8_t colours[] = {[1] = 0, [3] = 2, [4] = 6};
    uint8_t header[13] = {0};
    put_u32_big_endian(header, (uint32_t)rows->width);
    put_u32_big_endian(header + 4, (uint32_t)rows->height);
    header[8] = (uint8_t)rows->bits;
    header[9] = colours[rows->channels];
    cvol_bytes_append(out, signature, sizeof signature);
    put_chunk(out, "IHDR", header, sizeof header);
}

typedef struct encoder {
    z_stream stream;
    cvol_bytes *out;
    uint8_t *above, *row, *filtered; /* filtered: the filter's number, and the differences */
    uint8_t piece[PIECE];
} encoder;

/* Compresses; full pieces become chunks. */
static void deflate_some(encoder *e, uint8_t *data, size_t size, int flush)
{
    e->stream.next_in = data;
    e->stream.avail_in = (uInt)size;
    int status;
    do {
        status = deflate(&e->stream, flush);
        const size_t made = sizeof e->piece - e->stream.avail_out;
        if (made && (e->stream.avail_out == 0 || flush == Z_FINISH)) {
            put_chunk(e->out, "IDAT", e->piece, made);
            e->stream.next_out = e->piece;
            e->stream.avail_out = sizeof e->piece;
        }
    } while (flush == Z_FINISH ? status == Z_OK : e->stream.avail_in > 0);
}

static void put_rows(encoder *e, const cvol_png_rows *rows, size_t bytes)
{
    for (int y = 0; y < rows->height; y++) {
        rows->fetch(rows, e->row, y);
        e->filtered[0] = FILTER_UP;
        for (size_t i = 0; i < bytes; i++)
            e->filtered[i + 1] = (uint8_t)(e->row[i] - e->above[i]);
        deflate_some(e, e->filtered, bytes + 1, Z_NO_FLUSH);
        uint8_t *row = e->above;
        e->above = e->row;
        e->row = row;
    }
    deflate_some(e, NULL, 0, Z_FINISH);
}

int cvol_png_encode(cvol_context *context, cvol_bytes *out, const cvol_png_rows *rows, int level,
                    const char *name)
{
    const size_t bytes = (size_t)rows->width * (size_t)(rows->channels * rows->bits / 8);
    *out = (cvol_bytes){0};
    (void)name;
    encoder *e = calloc(1, sizeof *e);
    if (!e)
        return cvol_fail_memory(context, sizeof *e, "a PNG encoder");
    e->out = out;
    e->above = calloc(bytes, 1);
    e->row = cvol_allocate(bytes, 1);
    e->filtered = cvol_allocate(bytes + 1, 1);
    e->stream.next_out = e->piece;
    e->stream.avail_out = sizeof e->piece;
    int ready = e->above && e->row && e->filtered &&
                deflateInit2(&e->stream, level < 0 ? Z_DEFAULT_COMPRESSION : level, Z_DEFLATED, 15,
                             8, level < 0 ? Z_RLE : Z_FILTERED) == Z_OK;
    if (ready) {
        put_header(out, rows);
        put_rows(e, rows, bytes);
        put_chunk(out, "IEND", NULL, 0);
        deflateEnd(&e->stream);
        ready = !out->failed;
    }
    free(e->above);
    free(e->row);
    free(e->filtered);
    free(e);
    return ready ? CVOL_OK : cvol_fail_memory(context, bytes, "a PNG encoder");
}
