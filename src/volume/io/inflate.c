/* gzip and zlib streams inside files, inflated part by part with zlib. */
#include "volume/io/inflate.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "base/context.h"

#define PIECE_BYTES ((size_t)1 << 18)
/* 15: the largest window; + 32: detect gzip or zlib by the header. */
#define WINDOW_BITS (15 + 32)

struct cvol_inflater {
    z_stream stream;
    const cvol_input *input;
    uint64_t at, left; /* stored bytes that `piece` does not hold yet */
    int ended;         /* no byte of the stream is missing */
    uint8_t piece[PIECE_BYTES];
};

int cvol_inflater_open(cvol_context *context, cvol_inflater **out, const cvol_input *input,
                       uint64_t offset, uint64_t stored)
{
    *out = NULL;
    cvol_inflater *inflater = calloc(1, sizeof *inflater);
    if (!inflater || inflateInit2(&inflater->stream, WINDOW_BITS) != Z_OK) {
        free(inflater);
        return cvol_fail_memory(context, sizeof *inflater, input->path);
    }
    inflater->input = input;
    inflater->at = offset;
    inflater->left = stored;
    *out = inflater;
    return CVOL_OK;
}

void cvol_inflater_close(cvol_inflater *inflater)
{
    if (!inflater)
        return;
    inflateEnd(&inflater->stream);
    free(inflater);
}

int cvol_inflater_ended(const cvol_inflater *inflater)
{
    return inflater->ended;
}

/* Reads the next part when the last one is used up; avail_in stays 0 at the end. */
static int refill(cvol_context *context, cvol_inflater *inflater)
{
    if (inflater->stream.avail_in || !inflater->left)
        return CVOL_OK;
    size_t size = inflater->left < PIECE_BYTES ? (size_t)inflater->left : PIECE_BYTES, got;
    int code = cvol_input_read(context, inflater->input, inflater->at, inflater->piece, size, &got);
    if (code)
        return code;
    inflater->stream.next_in = inflater->piece;
    inflater->stream.avail_in = (uInt)got;
    inflater->at += got;
    inflater->left = got == size ? inflater->left - got : 0;
    return CVOL_OK;
}

/* After a member's end: zeros are padding, another member continues, anything else is an error. */
static int next_member(cvol_context *context, cvol_inflater *inflater)
{
    z_stream *stream = &inflater->stream;
    for (;;) {
        int code = refill(context, inflater);
        if (code)
            return code;
        if (!stream->avail_in) {
            inflater->ended = 1;
            return CVOL_OK;
        }
        if (*stream->next_in) {
            if (*stream->next_in == 0x1f && inflateReset(stream) == Z_OK)
                return CVOL_OK;
            return cvol_fail(context, CVOL_ERROR_FORMAT,
                             "%s: other bytes follow the end of its compressed samples",
                             inflater->input->path);
        }
        stream->next_in++;
        stream->avail_in--;
    }
}

/* Inflates into one buffer until it is full, or the stream or its bytes end. */
static int inflate_some(cvol_context *context, cvol_inflater *inflater, void *data, uInt size,
                        uInt *got)
{
    z_stream *stream = &inflater->stream;
    stream->next_out = data;
    stream->avail_out = size;
    int code = CVOL_OK;
    while (!code && stream->avail_out && !inflater->ended) {
        code = refill(context, inflater);
        if (code)
            break;
        /* Runs without input too: the stream may still have output that did not fit into the last
         * buffer. */
        int status = inflate(stream, Z_NO_FLUSH);
        if (status == Z_BUF_ERROR && !stream->avail_in)
            break;
        if (status == Z_STREAM_END)
            code = next_member(context, inflater);
        else if (status == Z_MEM_ERROR)
            code = cvol_fail_memory(context, 0, inflater->input->path);
        else if (status != Z_OK && status != Z_BUF_ERROR)
            code = cvol_fail(context, CVOL_ERROR_FORMAT,
                             "%s: its compressed bytes are damaged (%s)", inflater->input->path,
                             stream->msg ? stream->msg : "no gzip or zlib stream");
    }
    *got = size - stream->avail_out;
    return code;
}

int cvol_inflater_read(cvol_context *context, cvol_inflater *inflater, void *data, uint64_t size,
                       uint64_t *got)
{
    uint8_t waste[16384];
    *got = 0;
    while (*got < size) {
        uint64_t left = size - *got;
        uInt most = data ? 1u << 30 : (uInt)sizeof waste, some;
        int code = inflate_some(context, inflater, data ? (uint8_t *)data + *got : waste,
                                left < most ? (uInt)left : most, &some);
        *got += some;
        if (code)
            return code;
        if (some == 0)
            break;
    }
    return CVOL_OK;
}

size_t cvol_inflate_head(void *out, size_t size, const void *head, size_t head_size)
{
    z_stream stream;
    memset(&stream, 0, sizeof stream);
    if (inflateInit2(&stream, WINDOW_BITS) != Z_OK)
        return 0;
    stream.next_in = (z_const Bytef *)head;
    stream.avail_in = (uInt)head_size;
    stream.next_out = out;
    stream.avail_out = (uInt)size;
    inflate(&stream, Z_SYNC_FLUSH);
    inflateEnd(&stream);
    return size - stream.avail_out;
}
