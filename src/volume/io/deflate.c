/* gzip and zlib streams inside files, deflated part by part with zlib. */
#include "volume/io/deflate.h"

#include <stdlib.h>
#include <zlib.h>

#include "base/context.h"
#include "base/file.h"

#define LEVEL 6

struct cvol_deflater {
    z_stream stream;
    cvol_output *output;
    uint64_t size; /* bytes written */
    uint8_t piece[1 << 16];
};

int cvol_deflater_open(cvol_context *context, cvol_deflater **out, cvol_output *output, int gzip)
{
    *out = NULL;
    cvol_deflater *deflater = calloc(1, sizeof *deflater);
    /* zlib leaves the gzip header's time and name empty: equal volumes give equal files. */
    int window_bits = gzip ? 15 + 16 : 15;
    if (!deflater || deflateInit2(&deflater->stream, LEVEL, Z_DEFLATED, window_bits, 8,
                                  Z_DEFAULT_STRATEGY) != Z_OK) {
        free(deflater);
        return cvol_fail_memory(context, sizeof *deflater, "compression");
    }
    deflater->output = output;
    *out = deflater;
    return CVOL_OK;
}

void cvol_deflater_close(cvol_deflater *deflater)
{
    if (!deflater)
        return;
    deflateEnd(&deflater->stream);
    free(deflater);
}

static int deflate_some(cvol_context *context, cvol_deflater *deflater, const void *data,
                        size_t size, int flush)
{
    z_stream *stream = &deflater->stream;
    stream->next_in = (z_const Bytef *)data;
    stream->avail_in = (uInt)size;
    do {
        stream->next_out = deflater->piece;
        stream->avail_out = sizeof deflater->piece;
        deflate(stream, flush);
        size_t made = sizeof deflater->piece - stream->avail_out;
        int code = cvol_output_write(context, deflater->output, deflater->piece, made);
        if (code)
            return code;
        deflater->size += made;
    } while (stream->avail_out == 0);
    return CVOL_OK;
}

int cvol_deflater_write(cvol_context *context, cvol_deflater *deflater, const void *data,
                        size_t size)
{
    return size ? deflate_some(context, deflater, data, size, Z_NO_FLUSH) : CVOL_OK;
}

int cvol_deflater_finish(cvol_context *context, cvol_deflater *deflater, uint64_t *size)
{
    int code = deflate_some(context, deflater, NULL, 0, Z_FINISH);
    *size = deflater->size;
    return code;
}
