/* Reading a volume's samples by slab: raw bytes are read in place. Compressed ones are inflated
 * forward and, to go back, once more from the beginning. Samples stored as text, and wide elements,
 * are read completely. */
#define _GNU_SOURCE
#include "volume/io/stream.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/byte_order.h"
#include "base/context.h"
#include "base/grid.h"
#include "base/memory.h"
#include "volume/io/dense.h"
#include "volume/io/inflate.h"

struct cvol_volume_stream {
    cvol_grid grid;
    cvol_stored stored;
    char *name;       /* the header's file */
    const char *path; /* the samples' */
    cvol_input input;
    size_t bytes;            /* of all samples */
    uint64_t start;          /* raw: of the first sample; compressed: of the first stored byte */
    uint64_t packed;         /* compressed bytes from there on */
    cvol_inflater *inflater; /* NULL: at the beginning */
    size_t inflated;         /* bytes of samples inflated so far */
    cvol_volume *whole;      /* text, wide elements: all samples */
    uint8_t *slice;          /* for a format's own slices: the last one that was read in part */
    size_t slice_number;     /* the index of that slice, or dims[2] */
};

static int fail_short(cvol_context *context, const cvol_volume_stream *s, uint64_t got)
{
    return cvol_fail(context, CVOL_ERROR_FORMAT,
                     "%s: holds %llu of the %zu bytes of samples that its header announces",
                     s->path, (unsigned long long)got, s->bytes);
}

static int fail_long(cvol_context *context, const cvol_volume_stream *s, const char *by)
{
    return cvol_fail(context, CVOL_ERROR_FORMAT,
                     "%s: holds %s more than the %zu bytes of samples that its header announces",
                     s->path, by, s->bytes);
}

/* ---- raw ----------------------------------------------------------------------------- */

static int find_raw(cvol_context *context, cvol_volume_stream *s)
{
    uint64_t size = s->input.size, skip = s->stored.byte_skip;
    uint64_t available = size > s->start ? size - s->start : 0;
    available = available > skip ? available - skip : 0;
    if (available < s->bytes)
        return fail_short(context, s, available);
    s->start = s->stored.at_end ? size - s->bytes : s->start + skip;
    if (available > s->bytes && !s->stored.at_end && !s->stored.may_go_on) {
        char more[32];
        snprintf(more, sizeof more, "%llu bytes", (unsigned long long)(available - s->bytes));
        return fail_long(context, s, more);
    }
    return CVOL_OK;
}

static int read_raw(cvol_context *context, cvol_volume_stream *s, void *out, size_t offset,
                    size_t size)
{
    size_t got;
    int code = cvol_input_read(context, &s->input, s->start + offset, out, size, &got);
    return code || got == size ? code : fail_short(context, s, offset + got);
}

/* ---- compressed ---------------------------------------------------------------------- */

static int check_claim(cvol_context *context, const cvol_volume_stream *s)
{
    uint64_t claimed = s->bytes, skip = s->stored.byte_skip, most;
    if (__builtin_mul_overflow(s->packed, (uint64_t)CVOL_INFLATE_FACTOR, &most) ||
        __builtin_add_overflow(most, (uint64_t)CVOL_INFLATE_SLACK, &most))
        most = UINT64_MAX;
    if (!__builtin_add_overflow(claimed, skip, &claimed) && claimed <= most)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_FORMAT,
                     "%s: %llu compressed bytes cannot hold the %zu bytes of samples that its "
                     "header announces",
                     s->path, (unsigned long long)s->packed, s->bytes);
}

static int find_packed(cvol_context *context, cvol_volume_stream *s)
{
    uint64_t size = s->input.size > s->start ? s->input.size - s->start : 0;
    if (s->stored.stored_size > size)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: holds %llu of the %llu compressed bytes that its header announces",
                         s->path, (unsigned long long)size,
                         (unsigned long long)s->stored.stored_size);
    s->packed = s->stored.stored_size ? s->stored.stored_size : size;
    return check_claim(context, s);
}

/* Begins again if `offset` is already behind the stream's position. */
static int rewind_to(cvol_context *context, cvol_volume_stream *s, size_t offset)
{
    if (s->inflater && s->inflated <= offset)
        return CVOL_OK;
    cvol_inflater_close(s->inflater);
    s->inflated = 0;
    int code = cvol_inflater_open(context, &s->inflater, &s->input, s->start, s->packed);
    uint64_t got = 0;
    if (!code)
        code = cvol_inflater_read(context, s->inflater, NULL, s->stored.byte_skip, &got);
    return code || got == s->stored.byte_skip ? code : fail_short(context, s, 0);
}

/* Inflates the next bytes, into `out`, or skips them if it is NULL. */
static int inflate_next(cvol_context *context, cvol_volume_stream *s, void *out, size_t size)
{
    uint64_t got;
    int code = cvol_inflater_read(context, s->inflater, out, size, &got);
    s->inflated += (size_t)got;
    return code || got == size ? code : fail_short(context, s, s->inflated);
}

/* The stream must end with the samples, and its check sum must be valid, unless other volumes
 * follow. */
static int check_stream_end(cvol_context *context, cvol_volume_stream *s)
{
    if (s->stored.has_more_volumes)
        return CVOL_OK;
    uint8_t more;
    uint64_t got;
    int code = s->stored.has_remarks
                   ? cvol_inflater_read(context, s->inflater, NULL, UINT64_MAX, &got)
                   : cvol_inflater_read(context, s->inflater, &more, 1, &got);
    if (code)
        return code;
    if (got && !s->stored.has_remarks)
        return fail_long(context, s, "compressed");
    if (!cvol_inflater_ended(s->inflater))
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: is cut off within the check sum of its compressed samples", s->path);
    return CVOL_OK;
}

static int read_packed(cvol_context *context, cvol_volume_stream *s, void *out, size_t offset,
                       size_t size)
{
    int code = rewind_to(context, s, offset);
    if (!code)
        code = inflate_next(context, s, NULL, offset - s->inflated);
    if (!code)
        code = inflate_next(context, s, out, size);
    if (!code && s->inflated == s->bytes)
        code = check_stream_end(context, s);
    if (code) { /* after a failure, the next call begins again */
        cvol_inflater_close(s->inflater);
        s->inflater = NULL;
    }
    return code;
}

/* ---- a format's own slices ----------------------------------------------------------- */

/* Reads part of one slice, and keeps the slice: callers read the rest next. */
static int read_part(cvol_context *context, cvol_volume_stream *s, void *out, size_t number,
                     size_t begin, size_t size)
{
    const cvol_slices *slices = &s->stored.slices;
    size_t bytes = s->bytes / s->grid.dims[2];
    if (!s->slice && !(s->slice = cvol_allocate(bytes, 1)))
        return cvol_fail_memory(context, bytes, s->name);
    if (s->slice_number != number) {
        s->slice_number = s->grid.dims[2]; /* until the slice is complete */
        int code = slices->read(context, slices->state, s->slice, number, 1);
        if (code)
            return code;
        s->slice_number = number;
    }
    memcpy(out, s->slice + begin, size);
    return CVOL_OK;
}

static int read_slices(cvol_context *context, cvol_volume_stream *s, uint8_t *out, size_t offset,
                       size_t size)
{
    const cvol_slices *slices = &s->stored.slices;
    size_t bytes = s->bytes / s->grid.dims[2];
    int code = CVOL_OK;
    while (!code && size) {
        size_t number = offset / bytes, begin = offset % bytes, step = bytes - begin;
        if (begin || size < bytes) {
            step = size < step ? size : step;
            code = read_part(context, s, out, number, begin, step);
        } else {
            step = size - size % bytes;
            code = slices->read(context, slices->state, out, number, step / bytes);
        }
        out += step;
        offset += step;
        size -= step;
    }
    return code;
}

/* ---- opening ------------------------------------------------------------------------- */

static int check_grid(cvol_context *context, const cvol_volume_stream *s, uint64_t limit_bytes)
{
    if ((s->stored.encoding == CVOL_ENCODING_TEXT || s->stored.wide) &&
        limit_bytes > context->limit_bytes)
        limit_bytes = context->limit_bytes;
    int code = cvol_grid_check_within(context, &s->grid, s->name, limit_bytes);
    return code == CVOL_ERROR_FORMAT && s->stored.undescribed ? CVOL_ERROR_ARGUMENT : code;
}

static int open_samples(cvol_context *context, cvol_volume_stream *s)
{
    s->path = s->stored.data_path ? s->stored.data_path : s->name;
    int code = cvol_input_open(context, &s->input, s->path);
    if (code && s->stored.data_path &&
        strcmp(s->name, s->path)) { /* the message must name the file */
        char reason[CVOL_MESSAGE_BYTES];
        snprintf(reason, sizeof reason, "%s", cvol_context_message(context));
        cvol_fail(context, code, "%s: its data file %s", s->name, reason);
    }
    if (!code && s->stored.undescribed && s->input.size != s->bytes)
        code = cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: has %llu bytes, but %zu x %zu x %zu samples of %s are %zu bytes",
                         s->path, (unsigned long long)s->input.size, s->grid.dims[0],
                         s->grid.dims[1], s->grid.dims[2], cvol_type_name(s->grid.type), s->bytes);
    s->start = s->stored.offset;
    if (!code)
        code = cvol_input_skip_lines(context, &s->input, &s->start, s->stored.line_skip);
    if (code)
        return code;
    if (s->stored.encoding == CVOL_ENCODING_RAW)
        return find_raw(context, s);
    if (s->stored.encoding != CVOL_ENCODING_TEXT)
        return find_packed(context, s);
    if (__builtin_add_overflow(s->start, s->stored.byte_skip, &s->start))
        s->start = s->input.size;
    return cvol_stored_read_text(context, &s->whole, &s->grid, s->stored.wide, &s->input, s->start,
                                 s->stored.stored_size,
                                 s->stored.may_go_on && !s->stored.data_path);
}

/* Reads all elements and makes samples of them; only then the type is known. */
static int read_wide(cvol_context *context, cvol_volume_stream *s, int as_double)
{
    cvol_volume *whole = s->whole; /* of a text */
    const int is_text = whole != NULL;
    s->whole = NULL;
    int code = is_text ? CVOL_OK : cvol_dense_create(context, &whole, &s->grid, 0);
    if (!code && !is_text)
        code = cvol_stream_read_bytes(context, s, whole->data, 0, s->bytes);
    if (!code)
        code = cvol_wide_narrow(context, &s->grid.type, whole->data, cvol_grid_samples(&s->grid),
                                s->stored.wide, as_double, s->path ? s->path : s->name);
    if (code) {
        cvol_volume_free(whole);
        return code;
    }
    whole->grid = s->grid;
    s->bytes = cvol_grid_bytes(&s->grid);
    s->whole = whole;
    return CVOL_OK;
}

int cvol_stream_begin(cvol_context *context, cvol_volume_stream **out, const cvol_format *format,
                      const char *path, const cvol_read_options *options, uint64_t limit_bytes)
{
    *out = NULL;
    cvol_volume_stream *s = calloc(1, sizeof *s);
    if (!s)
        return cvol_fail_memory(context, sizeof *s, path);
    s->input.fd = -1;
    s->grid = cvol_grid_make(1, 1, 1, CVOL_UINT8);
    s->name = strdup(path);
    int code = s->name ? CVOL_OK : cvol_fail_memory(context, strlen(path), path);
    if (!code)
        code = format->find(context, &s->grid, &s->stored, s->name, options);
    cvol_labels_repair_unit(s->grid.unit);
    for (int a = 0; a < 3 && !code; a++)
        if (options->spacing[a] != 0)
            s->grid.spacing[a] = options->spacing[a];
    if (!code)
        code = check_grid(context, s, limit_bytes);
    if (!code) {
        s->bytes = cvol_grid_bytes(&s->grid);
        s->slice_number = s->grid.dims[2];
        code = s->stored.slices.read ? CVOL_OK : open_samples(context, s);
    }
    if (!code && s->stored.wide)
        code = read_wide(context, s, options->wide_float64);
    if (code)
        cvol_volume_stream_free(s);
    else
        *out = s;
    return code;
}

void cvol_volume_stream_free(cvol_volume_stream *stream)
{
    if (!stream)
        return;
    cvol_inflater_close(stream->inflater);
    cvol_volume_free(stream->whole);
    cvol_input_close(&stream->input);
    if (stream->stored.slices.close)
        stream->stored.slices.close(stream->stored.slices.state);
    free(stream->stored.labels.channel);
    free(stream->slice);
    free(stream->stored.data_path);
    free(stream->name);
    free(stream);
}

/* ---- reading ------------------------------------------------------------------------- */

const cvol_grid *cvol_volume_stream_grid(const cvol_volume_stream *stream)
{
    return &stream->grid;
}

double cvol_volume_stream_time_step(const cvol_volume_stream *stream, const char **unit)
{
    *unit = stream->stored.labels.time_unit;
    return stream->stored.labels.time_step;
}

const char *cvol_volume_stream_channel_name(const cvol_volume_stream *stream, int channel)
{
    const cvol_labels *labels = &stream->stored.labels;
    return channel >= 0 && (size_t)channel < labels->channels ? labels->channel[channel].name : "";
}

int cvol_volume_stream_get_channel_colour(double rgb[3], const cvol_volume_stream *stream,
                                          int channel)
{
    const cvol_labels *labels = &stream->stored.labels;
    if (channel < 0 || (size_t)channel >= labels->channels || !labels->channel[channel].has_colour)
        return 0;
    memcpy(rgb, labels->channel[channel].colour, sizeof labels->channel[channel].colour);
    return 1;
}

int cvol_volume_stream_has_colours(const cvol_volume_stream *stream)
{
    return stream->stored.labels.are_colours;
}

cvol_volume *cvol_stream_take_whole(cvol_volume_stream *stream)
{
    cvol_volume *whole = stream->whole;
    stream->whole = NULL;
    return whole;
}

int cvol_stream_read_bytes(cvol_context *context, cvol_volume_stream *stream, void *out,
                           size_t offset, size_t size)
{
    if (size == 0)
        return CVOL_OK;
    if (stream->whole) {
        memcpy(out, (const uint8_t *)stream->whole->data + offset, size);
        return CVOL_OK;
    }
    if (stream->stored.slices.read)
        return read_slices(context, stream, out, offset, size);
    int code = stream->stored.encoding == CVOL_ENCODING_RAW
                   ? read_raw(context, stream, out, offset, size)
                   : read_packed(context, stream, out, offset, size);
    size_t sample = cvol_type_size(stream->grid.type);
    if (!code && stream->stored.big_endian != cvol_machine_is_big_endian())
        cvol_swap_bytes(out, size / sample, sample);
    return code;
}

int cvol_volume_stream_read(cvol_context *context, cvol_volume_stream *stream, void *out,
                            size_t first_slice, size_t slices)
{
    if (!stream || (!out && slices))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "reading slices: no %s",
                         stream ? "room for samples" : "stream");
    size_t most = stream->grid.dims[2], slice = stream->bytes / most;
    if (first_slice > most || slices > most - first_slice)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: %zu slices from slice %zu on were requested, but it has %zu",
                         stream->name, slices, first_slice, most);
    return cvol_stream_read_bytes(context, stream, out, first_slice * slice, slices * slice);
}

int cvol_volume_stream_can_read_rows(const cvol_volume_stream *stream)
{
    const cvol_slices *slices = &stream->stored.slices;
    return stream->whole || slices->read_rows ||
           (!slices->read && stream->stored.encoding == CVOL_ENCODING_RAW);
}

int cvol_volume_stream_read_rows(cvol_context *context, cvol_volume_stream *stream, void *out,
                                 size_t first_slice, size_t slices, size_t first_row, size_t rows)
{
    if (!stream || (!out && slices && rows))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "reading rows: no %s",
                         stream ? "room for samples" : "stream");
    const size_t *dims = stream->grid.dims;
    const size_t row = stream->bytes / dims[2] / dims[1];
    if (first_slice > dims[2] || slices > dims[2] - first_slice || first_row > dims[1] ||
        rows > dims[1] - first_row)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: %zu rows from row %zu on of %zu slices from slice %zu on were "
                         "requested, but it has %zu rows and %zu slices",
                         stream->name, rows, first_row, slices, first_slice, dims[1], dims[2]);
    const cvol_slices *own = &stream->stored.slices;
    if (own->read_rows && !stream->whole)
        return slices && rows
                   ? own->read_rows(context, own->state, out, first_slice, slices, first_row, rows)
                   : CVOL_OK;
    int code = CVOL_OK;
    for (size_t i = 0; i < slices && !code; i++)
        code = cvol_stream_read_bytes(context, stream, (uint8_t *)out + i * rows * row,
                                      ((first_slice + i) * dims[1] + first_row) * row, rows * row);
    return code;
}
