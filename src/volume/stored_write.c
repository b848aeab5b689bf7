/* Writing samples: raw or deflated, little-endian, with the same bytes at every run. */
#include "volume/stored.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "base/bytes.h"
#include "base/context.h"
#include "base/file.h"
#include "volume/input.h"

/* Samples that are sent, and progress that is reported, at once. */
#define STEP_BYTES ((size_t)1 << 20)
#define LEVEL 6

int cvol_sink_output(cvol_context *context, void *output, const void *data, size_t size)
{
    return cvol_output_write(context, output, data, size);
}

int cvol_sink_bytes(cvol_context *context, void *bytes, const void *data, size_t size)
{
    cvol_bytes *buffer = bytes;
    cvol_bytes_append(buffer, data, size);
    return buffer->failed ? cvol_fail_memory(context, buffer->size + size, "compressed samples")
                          : CVOL_OK;
}

/* A stream of bytes to a sink, deflated on the way or not. */
typedef struct writing {
    cvol_context *context;
    cvol_sink_fn put;
    void *sink;
    int deflates;
    z_stream stream;
    uint8_t piece[1 << 16];
} writing;

static int write_open(writing *w, cvol_encoding encoding)
{
    w->deflates = encoding != CVOL_ENCODING_RAW;
    if (!w->deflates)
        return CVOL_OK;
    /* zlib leaves the gzip header's time and name empty: equal volumes give equal files. */
    int window_bits = encoding == CVOL_ENCODING_GZIP ? 15 + 16 : 15;
    if (deflateInit2(&w->stream, LEVEL, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY) == Z_OK)
        return CVOL_OK;
    w->deflates = 0;
    return cvol_fail_memory(w->context, sizeof w->stream, "compression");
}

static int write_some(writing *w, const void *data, size_t size, int flush)
{
    if (!w->deflates)
        return size ? w->put(w->context, w->sink, data, size) : CVOL_OK;
    w->stream.next_in = (z_const Bytef *)data;
    w->stream.avail_in = (uInt)size;
    do {
        w->stream.next_out = w->piece;
        w->stream.avail_out = sizeof w->piece;
        deflate(&w->stream, flush);
        size_t made = sizeof w->piece - w->stream.avail_out;
        int code = made ? w->put(w->context, w->sink, w->piece, made) : CVOL_OK;
        if (code)
            return code;
    } while (w->stream.avail_out == 0);
    return CVOL_OK;
}

static int write_samples(writing *w, const cvol_volume *volume)
{
    size_t bytes = cvol_grid_bytes(&volume->grid), size = cvol_type_size(volume->grid.type);
    int swaps = size > 1 && cvol_machine_is_big_endian();
    uint8_t *swapped = NULL;
    if (swaps && !(swapped = malloc(STEP_BYTES)))
        return cvol_fail_memory(w->context, STEP_BYTES, "samples in file order");
    int code = CVOL_OK;
    for (size_t done = 0; !code && done < bytes;) {
        size_t step = bytes - done < STEP_BYTES ? bytes - done : STEP_BYTES;
        const void *data = (const uint8_t *)volume->data + done;
        if (swaps) {
            memcpy(swapped, data, step);
            cvol_swap_bytes(swapped, step / size, size);
            data = swapped;
        }
        code = write_some(w, data, step, Z_NO_FLUSH);
        done += step;
        if (!code)
            code = cvol_report_progress(w->context, "writing", (double)done / (double)bytes);
    }
    free(swapped);
    return code;
}

int cvol_stored_write(cvol_context *context, const cvol_volume *volume, cvol_encoding encoding,
                      const void *prefix, size_t prefix_size, cvol_sink_fn put, void *sink)
{
    writing *w = calloc(1, sizeof *w);
    if (!w)
        return cvol_fail_memory(context, sizeof *w, "writing");
    w->context = context;
    w->put = put;
    w->sink = sink;
    int code = write_open(w, encoding);
    if (!code && prefix_size)
        code = write_some(w, prefix, prefix_size, Z_NO_FLUSH);
    if (!code)
        code = write_samples(w, volume);
    if (!code)
        code = write_some(w, NULL, 0, Z_FINISH);
    if (w->deflates)
        deflateEnd(&w->stream);
    free(w);
    return code;
}

int cvol_stored_write_file(cvol_context *context, const cvol_volume *volume, const char *path,
                           const void *header, size_t header_size, cvol_encoding encoding)
{
    cvol_output *output = NULL;
    int code = cvol_output_open(context, &output, path);
    if (!code && header_size)
        code = cvol_output_write(context, output, header, header_size);
    if (!code)
        code = cvol_stored_write(context, volume, encoding, NULL, 0, cvol_sink_output, output);
    if (!code)
        return cvol_output_commit(context, output);
    cvol_output_abandon(output);
    return code;
}

/* ---- detached data ------------------------------------------------------------------- */

static int is_plain_name(const char *name)
{
    size_t length = strlen(name);
    for (size_t i = 0; i < length; i++)
        if ((unsigned char)name[i] < ' ' || name[i] == 0x7f || name[i] == '%')
            return 0;
    return length && name[0] != ' ' && name[length - 1] != ' ';
}

int cvol_stored_data_path(cvol_context *context, char **out, const char *header_path,
                          const char *ending)
{
    const char *name = cvol_input_name(header_path), *dot = strrchr(name, '.');
    size_t stem = dot ? (size_t)(dot - header_path) : strlen(header_path);
    *out = malloc(stem + strlen(ending) + 1);
    if (!*out)
        return cvol_fail_memory(context, stem, header_path);
    memcpy(*out, header_path, stem);
    memcpy(*out + stem, ending, strlen(ending) + 1);
    if (is_plain_name(cvol_input_name(*out)))
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                     "%s: a header cannot hold the data file's name '%s'", header_path,
                     cvol_input_name(*out));
}

int cvol_stored_write_detached(cvol_context *context, const cvol_volume *volume, const char *path,
                               const struct cvol_bytes *header, const char *data_path)
{
    /* Both are whole before either replaces what was there. */
    cvol_output *output = NULL, *data = NULL;
    int code = cvol_output_open(context, &output, path);
    if (!code)
        code = cvol_output_write(context, output, header->data, header->size);
    if (!code)
        code = cvol_output_open(context, &data, data_path);
    if (!code)
        code = cvol_stored_write(context, volume, CVOL_ENCODING_RAW, NULL, 0, cvol_sink_output,
                                 data);
    if (!code) {
        code = cvol_output_commit(context, data);
        data = NULL;
    }
    if (!code)
        return cvol_output_commit(context, output);
    cvol_output_abandon(data);
    cvol_output_abandon(output);
    return code;
}
