/* Writes files of many volumes: space for the list first, volume after volume, then the list. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/file.h"
#include "base/options.h"
#include "codec/container/array_file.h"
#include "codec/container/container.h"
#include "codec/container/series.h"
#include "codec/section/section.h"
#include "codec/section/signature.h"

struct cvol_series_writer {
    cvol_output *output;
    cvol_series *series;
    size_t next;  /* index of the next volume */
    uint64_t at;  /* byte where its section begins */
    cvol_grid of; /* the first volume's */
};

static const cvol_series_options defaults = {
    .size = sizeof(cvol_series_options), .times = 1, .channels = 1};

void cvol_series_options_set_defaults(cvol_series_options *options, size_t size)
{
    cvol_options_fill(options, size, &defaults, sizeof defaults);
}

/* ---- options ---------------------------------------------------------------------------- */

static int check_counts(cvol_context *context, const cvol_series_options *options)
{
    if (options->times < 1 || options->channels < 1 ||
        (int64_t)options->times * options->channels > CVOL_SERIES_MOST)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "a file of %d times and %d channels: there must be 1 to %d volumes",
                         options->times, options->channels, (int)CVOL_SERIES_MOST);
    if (options->colours && options->channels != 3 && options->channels != 4)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "a file of colours has %d channels: there must be 3 (red, green, blue) or "
                         "4 (and alpha)",
                         options->channels);
    if (options->time_unit && strlen(options->time_unit) >= CVOL_TIME_UNIT_BYTES)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "the unit of time is '%s', must have at most %d bytes", options->time_unit,
                         CVOL_TIME_UNIT_BYTES - 1);
    return CVOL_OK;
}

static int set_channel(cvol_context *context, cvol_channel *channel, int number,
                       const cvol_series_options *options)
{
    const char *name = options->channel_names ? options->channel_names[number] : NULL;
    if (name && strlen(name) >= sizeof channel->name)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "channel %d is called '%s', must have at most %d bytes", number, name,
                         (int)sizeof channel->name - 1);
    if (name)
        memcpy(channel->name, name, strlen(name));
    cvol_series_get_default_colour(channel->colour, number, options->channels);
    if (!options->channel_colours)
        return CVOL_OK;
    for (int k = 0; k < 3; k++) {
        channel->colour[k] = options->channel_colours[3 * number + k];
        if (!(channel->colour[k] >= 0 && channel->colour[k] <= 1))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "the colour of channel %d has %g, must be 0 to 1", number,
                             channel->colour[k]);
    }
    return CVOL_OK;
}

static int describe(cvol_context *context, cvol_series *series, const cvol_series_options *options)
{
    int code = CVOL_OK;
    series->is_list = 1;
    series->are_colours = options->colours;
    if (options->time_unit)
        memcpy(series->unit, options->time_unit, strlen(options->time_unit));
    for (int c = 0; c < series->channels && !code; c++)
        code = set_channel(context, &series->channel[c], c, options);
    for (int t = 0; t < series->times && !code; t++) {
        series->time[t] = options->time_values ? options->time_values[t] : t;
        if (!isfinite(series->time[t]))
            code = cvol_fail(context, CVOL_ERROR_ARGUMENT, "the value of time %d is not a number",
                             t);
    }
    return code;
}

/* ---- the start -------------------------------------------------------------------------- */

/* Writes signature, version and the current list; the number of bytes is always the same. */
static int write_start(cvol_context *context, cvol_series_writer *writer, int again)
{
    cvol_bytes bytes = {0}, list = {0};
    for (size_t i = 0; i < CVOL_SIGNATURE_BYTES; i++)
        cvol_bytes_put_u8(&bytes, cvol_container_signature(i));
    cvol_bytes_put_u32(&bytes, CVOL_FORMAT_VERSION);
    cvol_series_put(&list, writer->series);
    cvol_section_put(&bytes, CVOL_LIST, &list);
    int code = bytes.failed ? cvol_fail_memory(context, bytes.size, "a list of volumes")
               : again ? cvol_output_rewrite(context, writer->output, 0, bytes.data, bytes.size)
                       : cvol_output_write(context, writer->output, bytes.data, bytes.size);
    if (!again)
        writer->at = bytes.size;
    cvol_bytes_free(&bytes);
    cvol_bytes_free(&list);
    return code;
}

int cvol_series_writer_open(cvol_context *context, cvol_series_writer **out, const char *path,
                            const cvol_series_options *options)
{
    cvol_series_options full = defaults;
    *out = NULL;
    int code = cvol_options_copy(context, &full, sizeof full,
                                 CVOL_SIZE_TO(cvol_series_options, colours), "cvol_series_options",
                                 options);
    if (!code)
        code = check_counts(context, &full);
    if (code)
        return code;
    cvol_series_writer *writer = calloc(1, sizeof *writer);
    if (!writer)
        return cvol_fail_memory(context, sizeof *writer, path);
    code = cvol_series_make(context, &writer->series, full.times, full.channels);
    if (!code)
        code = describe(context, writer->series, &full);
    if (!code)
        code = cvol_output_open(context, &writer->output, path);
    if (!code)
        code = write_start(context, writer, 0);
    if (!code && !cvol_output_is_seekable(writer->output))
        code = cvol_fail(context, CVOL_ERROR_IO,
                         "%s: a file of many volumes cannot go through a pipe: its beginning is "
                         "written last",
                         path);
    if (!code)
        code = write_start(context, writer, 1);
    if (code)
        cvol_series_writer_abandon(writer);
    else
        *out = writer;
    return code;
}

/* ---- volumes ---------------------------------------------------------------------------- */

/* True if two numbers differ by more than rounding, on the scale of `unit`. */
static int differs(double a, double b, double unit)
{
    return !(fabs(a - b) <= 1e-6 * fmax(fabs(unit), fmax(fabs(a), fabs(b))));
}

/* The name of the first difference from the first volume, or NULL. */
static const char *difference(const cvol_grid *grid, const cvol_grid *first)
{
    for (int a = 0; a < 3; a++) {
        if (differs(grid->spacing[a], first->spacing[a], 0))
            return "spacing";
        if (differs(grid->origin[a], first->origin[a], first->spacing[a]))
            return "origin";
        for (int k = 0; k < 3; k++)
            if (differs(grid->direction[a][k], first->direction[a][k], 1))
                return "direction";
    }
    if (grid->space != first->space)
        return "space (LPS or RAS)";
    return strcmp(grid->unit, first->unit) ? "unit of length" : NULL;
}

static int check_volume(cvol_context *context, cvol_series_writer *writer, const cvol_grid *grid)
{
    const cvol_grid *first = &writer->of;
    const size_t count = (size_t)writer->series->times * (size_t)writer->series->channels;
    if (writer->next == count)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "all %zu volumes are there already", count);
    if (!writer->next) {
        writer->of = *grid;
        return CVOL_OK;
    }
    if (memcmp(grid->dims, first->dims, sizeof grid->dims) || grid->type != first->type)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "has %zu x %zu x %zu samples of %s, the volumes before it %zu x %zu x %zu "
                         "of %s; those in one file must match",
                         grid->dims[0], grid->dims[1], grid->dims[2], cvol_type_name(grid->type),
                         first->dims[0], first->dims[1], first->dims[2],
                         cvol_type_name(first->type));
    const char *other = difference(grid, first);
    return other ? cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "has another %s than the volumes before it; those in one file must "
                             "match",
                             other)
                 : CVOL_OK;
}

/* Reserves the next volume's header. */
static int begin_volume(cvol_context *context, cvol_series_writer *writer)
{
    static const uint8_t zeros[CVOL_SECTION_HEADER_BYTES];
    const int code = cvol_output_write(context, writer->output, zeros, sizeof zeros);
    cvol_output_count(writer->output);
    return code;
}

static int end_volume(cvol_context *context, cvol_series_writer *writer)
{
    cvol_bytes header = {0};
    uint64_t length;
    uint32_t checksum;
    cvol_output_counted(writer->output, &length, &checksum);
    cvol_section_put_header(&header, CVOL_VOLM, length, checksum);
    const int code = header.failed ? cvol_fail_memory(context, header.size, "a section")
                                   : cvol_output_rewrite(context, writer->output, writer->at,
                                                         header.data, header.size);
    cvol_bytes_free(&header);
    writer->at += CVOL_SECTION_HEADER_BYTES;
    writer->series->volumes[writer->next++] = (cvol_extent){writer->at, length};
    writer->at += length;
    return code;
}

int cvol_series_add(cvol_context *context, cvol_series_writer *writer, const cvol_array *array,
                    uint64_t *file_bytes)
{
    int code = check_volume(context, writer, cvol_array_grid(array));
    if (!code)
        code = begin_volume(context, writer);
    if (!code)
        code = cvol_array_write_within(context, array, writer->output, file_bytes);
    return code ? code : end_volume(context, writer);
}

int cvol_series_add_written(cvol_context *context, cvol_series_writer *writer,
                            const cvol_grid *grid, cvol_series_write *write, void *user)
{
    int code = check_volume(context, writer, grid);
    if (!code)
        code = begin_volume(context, writer);
    if (!code)
        code = write(context, writer->output, user);
    return code ? code : end_volume(context, writer);
}

/* ---- the end ---------------------------------------------------------------------------- */

static int write_end(cvol_context *context, cvol_series_writer *writer)
{
    const size_t count = (size_t)writer->series->times * (size_t)writer->series->channels;
    if (writer->next < count)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%zu of %zu volumes were written",
                         writer->next, count);
    cvol_bytes bytes = {0};
    cvol_section_put(&bytes, CVOL_ENDS, &(cvol_bytes){0});
    int code = bytes.failed ? cvol_fail_memory(context, bytes.size, "a section")
                            : cvol_output_write(context, writer->output, bytes.data, bytes.size);
    writer->at += bytes.size;
    cvol_bytes_free(&bytes);
    return code ? code : write_start(context, writer, 1);
}

int cvol_series_writer_commit(cvol_context *context, cvol_series_writer *writer,
                              uint64_t *file_bytes)
{
    int code = write_end(context, writer);
    code = cvol_output_end(context, writer->output, code);
    writer->output = NULL;
    if (!code && file_bytes)
        *file_bytes = writer->at;
    cvol_series_writer_abandon(writer);
    return code;
}

void cvol_series_writer_abandon(cvol_series_writer *writer)
{
    if (!writer)
        return;
    cvol_output_abandon(writer->output);
    cvol_series_free(writer->series);
    free(writer);
}
