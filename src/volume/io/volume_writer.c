/* Writing a volume's samples by slab: raw or deflated, behind a header or in a separate file. The
 * bytes do not depend on the slabs. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/byte_order.h"
#include "base/context.h"
#include "base/file.h"
#include "base/memory.h"
#include "volume/io/deflate.h"
#include "volume/io/stream.h"

/* Bytes that are swapped and deflated at once. */
#define STEP_BYTES ((size_t)1 << 20)

struct cvol_volume_writer {
    char *path;
    cvol_grid grid;
    cvol_write_plan plan;
    cvol_write_sink sink; /* instead of a plan */
    cvol_output *header;  /* for detached samples, else NULL */
    cvol_output *samples; /* behind the header if they are attached */
    cvol_deflater *deflater;
    size_t slice, slices; /* bytes of a slice, and slices of all volumes */
    size_t bytes, done;   /* of all samples, and how many are written */
    uint8_t *step; /* samples that wait for a full step; NULL: samples are written as they come */
    size_t filled;
    int swaps, failed;
};

/* ---- opening ------------------------------------------------------------------------- */

/* Header and detached samples are both complete before either replaces an older file. */
static int open_outputs(cvol_context *context, cvol_volume_writer *s)
{
    const cvol_write_plan *plan = &s->plan;
    cvol_output **headed = plan->data_path ? &s->header : &s->samples;
    int code = cvol_output_open(context, headed, s->path);
    if (!code && !plan->packs_header)
        code = cvol_output_write(context, *headed, plan->header.data, plan->header.size);
    if (!code && plan->data_path)
        code = cvol_output_open(context, &s->samples, plan->data_path);
    if (!code && plan->encoding != CVOL_ENCODING_RAW)
        code = cvol_deflater_open(context, &s->deflater, s->samples,
                                  plan->encoding == CVOL_ENCODING_GZIP);
    if (!code && plan->packs_header)
        code = cvol_deflater_write(context, s->deflater, plan->header.data, plan->header.size);
    s->swaps = cvol_machine_is_big_endian() != plan->big_endian && cvol_type_size(s->grid.type) > 1;
    if (!code && (s->swaps || s->deflater) && !(s->step = cvol_allocate(STEP_BYTES, 1)))
        code = cvol_fail_memory(context, STEP_BYTES, s->path);
    return code;
}

int cvol_volume_writer_begin(cvol_context *context, cvol_volume_writer **out,
                             const cvol_format *format, const char *path, const cvol_grid *grid,
                             const cvol_series_options *series, int are_labels)
{
    *out = NULL;
    cvol_volume_writer *s = calloc(1, sizeof *s);
    if (!s)
        return cvol_fail_memory(context, sizeof *s, path);
    s->grid = *grid;
    s->slice = cvol_grid_bytes(grid) / grid->dims[2];
    s->path = strndup(path, cvol_volume_writer_file_length(path));
    int code = s->path ? CVOL_OK : cvol_fail_memory(context, strlen(path), path);
    const size_t volumes = (size_t)series->times * (size_t)series->channels;
    if (!code && (!cvol_size_multiply(&s->slices, grid->dims[2], volumes) ||
                  !cvol_size_multiply(&s->bytes, s->slice, s->slices)))
        code = cvol_fail(context, CVOL_ERROR_LIMIT, "%s: %zu volumes have too many samples", path,
                         volumes);
    if (!code && format->open_sink)
        code = format->open_sink(context, &s->sink, grid, path, series, are_labels);
    else if (!code) {
        s->plan.series = series;
        code = format->plan(context, &s->plan, grid, path);
    }
    if (!code && (s->plan.header.failed || s->plan.trailer.failed))
        code = cvol_fail_memory(context, s->plan.header.size, path);
    if (!code && !s->sink.write)
        code = open_outputs(context, s);
    if (code)
        cvol_volume_writer_abandon(s);
    else
        *out = s;
    return code;
}

/* ---- writing ------------------------------------------------------------------------- */

static int put(cvol_context *context, cvol_volume_writer *s, const void *data, size_t size)
{
    return s->deflater ? cvol_deflater_write(context, s->deflater, data, size)
                       : cvol_output_write(context, s->samples, data, size);
}

static int put_step(cvol_context *context, cvol_volume_writer *s)
{
    size_t sample = cvol_type_size(s->grid.type);
    if (s->swaps)
        cvol_swap_bytes(s->step, s->filled / sample, sample);
    int code = put(context, s, s->step, s->filled);
    s->filled = 0;
    return code;
}

/* Steps always begin at the same offsets. */
static int put_in_steps(cvol_context *context, cvol_volume_writer *s, const uint8_t *data,
                        size_t size)
{
    int code = CVOL_OK;
    while (!code && size) {
        if (s->filled == 0 && size >= STEP_BYTES && !s->swaps) {
            code = put(context, s, data, STEP_BYTES);
            data += STEP_BYTES;
            size -= STEP_BYTES;
            continue;
        }
        size_t part = STEP_BYTES - s->filled < size ? STEP_BYTES - s->filled : size;
        memcpy(s->step + s->filled, data, part);
        s->filled += part;
        data += part;
        size -= part;
        if (s->filled == STEP_BYTES)
            code = put_step(context, s);
    }
    return code;
}

static int put_samples(cvol_context *context, cvol_volume_writer *writer, const void *data,
                       size_t size)
{
    return writer->step ? put_in_steps(context, writer, data, size)
                        : put(context, writer, data, size);
}

/* Bytes as uint16. */
static int put_wide(cvol_context *context, cvol_volume_writer *writer, const uint8_t *data,
                    size_t size)
{
    uint8_t wide[8192] = {0};
    const size_t most = sizeof wide / 2;
    int code = CVOL_OK;
    for (size_t first = 0; first < size && !code; first += most) {
        const size_t count = size - first < most ? size - first : most;
        for (size_t i = 0; i < count; i++)
            wide[2 * i] = data[first + i];
        code = put_samples(context, writer, wide, 2 * count);
    }
    return code;
}

int cvol_volume_writer_write_bytes(cvol_context *context, cvol_volume_writer *writer,
                                   const void *data, size_t size)
{
    int code = writer->sink.write    ? writer->sink.write(context, writer->sink.state, data, size)
               : writer->plan.widens ? put_wide(context, writer, data, size)
                                     : put_samples(context, writer, data, size);
    writer->done += size;
    writer->failed = writer->failed || code;
    return code;
}

int cvol_volume_writer_write(cvol_context *context, cvol_volume_writer *writer, const void *samples,
                             size_t slices)
{
    if (!writer || (!samples && slices))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "writing slices: no %s",
                         writer ? "samples" : "sink");
    size_t slice = writer->slice, missing = (writer->bytes - writer->done) / slice;
    if (slices > missing)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: %zu slices are too many, %zu of its %zu are missing", writer->path,
                         slices, missing, writer->slices);
    return cvol_volume_writer_write_bytes(context, writer, samples, slices * slice);
}

int cvol_volume_writer_add_missing(cvol_context *context, cvol_volume_writer *writer, double value)
{
    if (!writer)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "a value of missing samples: no sink");
    return writer->sink.add_missing ? writer->sink.add_missing(context, writer->sink.state, value)
                                    : CVOL_OK;
}

/* ---- ending -------------------------------------------------------------------------- */

static int check_whole(cvol_context *context, const cvol_volume_writer *s)
{
    if (s->failed)
        return cvol_fail(context, CVOL_ERROR_IO, "%s: not all of its slices could be written",
                         s->path);
    if (s->done == s->bytes)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s: %zu of its %zu slices were written",
                     s->path, s->done / s->slice, s->slices);
}

static int finish(cvol_context *context, cvol_volume_writer *s)
{
    int code = s->filled ? put_step(context, s) : CVOL_OK;
    uint64_t packed = 0;
    if (!code && s->deflater)
        code = cvol_deflater_finish(context, s->deflater, &packed);
    if (!code && s->plan.trailer.size)
        code = cvol_output_write(context, s->samples, s->plan.trailer.data, s->plan.trailer.size);
    if (code || !s->plan.size_at)
        return code;
    char number[CVOL_PLAN_SIZE_BYTES + 1];
    snprintf(number, sizeof number, "%-*llu", CVOL_PLAN_SIZE_BYTES, (unsigned long long)packed);
    return cvol_output_rewrite(context, s->samples, s->plan.size_at, number, CVOL_PLAN_SIZE_BYTES);
}

int cvol_volume_writer_commit(cvol_context *context, cvol_volume_writer *writer)
{
    if (!writer)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "writing slices: no writer");
    int code = check_whole(context, writer);
    if (!code && writer->sink.write) {
        code = writer->sink.commit(context, writer->sink.state);
        cvol_volume_writer_abandon(writer);
        return code;
    }
    if (!code)
        code = finish(context, writer);
    const int is_pair = writer->header && !context->holds_outputs;
    if (!code && is_pair)
        cvol_context_hold_outputs(context);
    if (!code) {
        code = cvol_output_commit(context, writer->samples);
        writer->samples = NULL;
    }
    if (!code && writer->header) { /* last: a header never exists without its samples */
        code = cvol_output_commit(context, writer->header);
        writer->header = NULL;
    }
    if (is_pair)
        code = cvol_context_release_outputs(context, code);
    cvol_volume_writer_abandon(writer);
    return code;
}

void cvol_volume_writer_abandon(cvol_volume_writer *writer)
{
    if (!writer)
        return;
    if (writer->sink.close)
        writer->sink.close(writer->sink.state);
    cvol_deflater_close(writer->deflater);
    cvol_output_abandon(writer->samples);
    cvol_output_abandon(writer->header);
    cvol_write_plan_free(&writer->plan);
    free(writer->step);
    free(writer->path);
    free(writer);
}
