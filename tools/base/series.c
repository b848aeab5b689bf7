/* Series: the chosen volume, the number of volumes, and their labels. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>

#include "tools/base/cli.h"

int choose_volume(cvol_context *context, common_options *common, const char *path,
                  cvol_file_part *part)
{
    const cvol_read_options *read = &common->read;
    if (read->series)
        return report_error(EXIT_MISUSED,
                            "%s: is a .cvol file: leave out --series, which is for DICOM", path);
    if (kind_of(path) != CVOL_FILE_SERIES) {
        if (read->has_index || read->has_channel)
            return report_error(EXIT_MISUSED,
                                "%s: holds one volume: leave out --time, --index and --channel",
                                path);
        return EXIT_DONE;
    }
    part->time = read->has_index ? read->index : 0;
    part->channel = read->has_channel ? read->channel : 0;
    cvol_series *series;
    const int code = cvol_series_read(context, &series, path);
    if (code)
        return report_context_error(context, code, NULL);
    const int times = cvol_series_times(series), channels = cvol_series_channels(series);
    cvol_series_free(series);
    const int time_is_open = times > 1 && !read->has_index,
              channel_is_open = channels > 1 && !read->has_channel;
    if ((time_is_open || channel_is_open) && part->time < times && part->channel < channels &&
        !common->choice_printed) {
        const int both = time_is_open && channel_is_open;
        common->choice_printed = 1;
        clear_progress();
        fprintf(stderr, "cvol: %s: using ", path);
        if (time_is_open)
            fprintf(stderr, "time %d of %d%s", part->time, times, both ? ", " : "");
        if (channel_is_open)
            fprintf(stderr, "channel %d of %d", part->channel, channels);
        fprintf(stderr, "; %s another\n",
                both           ? "--time and --channel choose"
                : time_is_open ? "--time chooses"
                               : "--channel chooses");
    }
    return EXIT_DONE;
}

int count_volumes(cvol_context *context, common_options *common, const char *path, int *times,
                  int *channels)
{
    const cvol_read_options *read = &common->read;
    *times = *channels = 1;
    int code;
    if (is_cvol(path)) {
        cvol_series *series;
        code = cvol_series_read(context, &series, path);
        if (!code && !read->has_index)
            *times = cvol_series_times(series);
        if (!code && !read->has_channel)
            *channels = cvol_series_channels(series);
        if (!code)
            cvol_series_free(series);
    } else {
        const int status = read_type_name(common);
        if (status)
            return status;
        code = cvol_file_count_volumes(context, times, channels, path, read);
    }
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}

void choose_of_several(cvol_context *context, cvol_read_options *out,
                       const cvol_read_options *requested, const char *path)
{
    const cvol_read_options all = cvol_read_options_defaults();
    int times = 1, channels = 1;
    cvol_series *series;
    const int is_series = kind_of(path) == CVOL_FILE_SERIES;
    /* If this fails, the caller opens the file and reports why it is unreadable. */
    if (is_series && !cvol_series_read(context, &series, path)) {
        times = cvol_series_times(series);
        channels = cvol_series_channels(series);
        cvol_series_free(series);
    } else if (!is_series && !is_cvol(path) && cvol_file_is_volume(path) &&
               cvol_file_count_volumes(context, &times, &channels, path, &all))
        times = channels = 1;
    /* A series of one time has time 0. */
    out->has_index = requested->has_index && (times > 1 || (is_series && !requested->index));
    out->index = requested->index;
    out->has_channel = requested->has_channel &&
                       (channels > 1 || (is_series && !requested->channel));
    out->channel = requested->channel;
}

/* ---- labels --------------------------------------------------------------------------------- */

void free_labels(volume_labels *labels)
{
    for (int c = 0; labels->names && c < labels->channels; c++)
        free(labels->names[c]);
    free(labels->names);
    free(labels->unit);
    free(labels->times);
    free(labels->colours);
    *labels = (volume_labels){0};
}

static int labels_of_series(cvol_context *context, volume_labels *out,
                            const cvol_read_options *read, const char *path, int times)
{
    cvol_series *series;
    const int code = cvol_series_read(context, &series, path);
    if (code)
        return report_context_error(context, code, NULL);
    const int time = read->has_index ? read->index : 0,
              channel = read->has_channel ? read->channel : 0;
    if (time < 0 || time > cvol_series_times(series) - times || channel < 0 ||
        channel > cvol_series_channels(series) - out->channels) {
        cvol_series_free(series);
        return report_error(EXIT_MISUSED, "%s: has no time %d and channel %d", path, time, channel);
    }
    for (int t = 0; t < times; t++)
        out->times[t] = cvol_series_time(series, time + t);
    out->unit = strdup(cvol_series_time_unit(series));
    for (int c = 0; c < out->channels; c++) {
        out->names[c] = strdup(cvol_series_channel_name(series, channel + c));
        cvol_series_get_channel_colour(out->colours + 3 * c, series, channel + c);
    }
    out->are_colours = out->channels > 1 && cvol_series_has_colours(series);
    cvol_series_free(series);
    return EXIT_DONE;
}

static int labels_of_stream(cvol_context *context, volume_labels *out,
                            const cvol_read_options *read, const char *path, int times)
{
    cvol_volume_stream *stream;
    cvol_read_options first = *read;
    int all_times, all_channels;
    int code = cvol_file_count_volumes(context, &all_times, &all_channels, path, read);
    first.has_index = first.has_index || all_times > 1;
    first.has_channel = first.has_channel || all_channels > 1;
    if (!code)
        code = cvol_volume_stream_open(context, &stream, path, &first);
    if (code)
        return report_context_error(context, code, NULL);
    const char *unit;
    const double step = cvol_volume_stream_time_step(stream, &unit);
    for (int t = 0; t < times; t++)
        out->times[t] = t * step;
    if (!(step > 0)) {
        free(out->times);
        out->times = NULL;
    }
    out->unit = strdup(unit);
    for (int c = 0; c < out->channels; c++) {
        const int from = read->has_channel ? read->channel : c;
        out->names[c] = strdup(cvol_volume_stream_channel_name(stream, from));
        cvol_volume_stream_get_channel_colour(out->colours + 3 * c, stream, from);
    }
    out->are_colours = out->channels > 1 && cvol_volume_stream_has_colours(stream);
    cvol_volume_stream_free(stream);
    return EXIT_DONE;
}

int find_labels(cvol_context *context, volume_labels *out, common_options *common, const char *path,
                int times, int channels)
{
    *out = (volume_labels){.times = calloc((size_t)times, sizeof *out->times),
                           .names = calloc((size_t)channels, sizeof *out->names),
                           .colours = calloc(3 * (size_t)channels, sizeof *out->colours),
                           .channels = channels};
    int status = read_type_name(common);
    if (!out->times || !out->names || !out->colours)
        return report_error(EXIT_FAILED, "not enough memory");
    for (int c = 0; c < channels; c++)
        cvol_series_get_default_colour(out->colours + 3 * c, c, channels);
    if (!status)
        status = is_cvol(path) ? labels_of_series(context, out, &common->read, path, times)
                               : labels_of_stream(context, out, &common->read, path, times);
    for (int c = 0; !status && c < channels; c++)
        if (!out->names[c])
            status = report_error(EXIT_FAILED, "not enough memory");
    return !status && !out->unit ? report_error(EXIT_FAILED, "not enough memory") : status;
}

/* ---- colours -------------------------------------------------------------------------------- */

/* Reads a colour of `length` letters, a name or #rrggbb; 1 on success. */
int parse_colour(double rgb[3], const char *text, size_t length)
{
    static const struct {
        const char *name;
        double rgb[3];
    } names[] = {{"red", {1, 0, 0}},     {"green", {0, 1, 0}},   {"blue", {0, 0, 1}},
                 {"yellow", {1, 1, 0}},  {"magenta", {1, 0, 1}}, {"cyan", {0, 1, 1}},
                 {"orange", {1, .5, 0}}, {"white", {1, 1, 1}},   {"gray", {1, 1, 1}}};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strlen(names[i].name) == length && !strncmp(names[i].name, text, length)) {
            memcpy(rgb, names[i].rgb, sizeof names[i].rgb);
            return 1;
        }
    if (length != 7 || text[0] != '#' || strspn(text + 1, "0123456789abcdefABCDEF") < 6)
        return 0;
    const unsigned long bits = strtoul(text + 1, NULL, 16);
    for (int k = 0; k < 3; k++)
        rgb[k] = (double)(bits >> (16 - 8 * k) & 255) / 255;
    return 1;
}

int parse_colours(double *out, int count, const char *text)
{
    int found = 0;
    for (const char *next = text; next; found++) {
        const char *comma = strchr(next, ',');
        double rgb[3];
        if (!parse_colour(rgb, next, comma ? (size_t)(comma - next) : strlen(next)))
            return report_error(EXIT_MISUSED,
                                "--channel-colors is '%s', must be names (red green blue yellow "
                                "magenta cyan orange white) or #rrggbb, separated by commas",
                                text);
        if (found < count)
            memcpy(out + 3 * found, rgb, sizeof rgb);
        next = comma ? comma + 1 : NULL;
    }
    return found == count
               ? EXIT_DONE
               : report_error(EXIT_MISUSED,
                              "--channel-colors has %d colours, must have %d, one for each channel",
                              found, count);
}
