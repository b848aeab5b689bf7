/* cvol info of files with several volumes: their times and channels. */
#include <stdlib.h>

#include "tools/info/info.h"

/* ---- .cvol files ---- */

/* Times, channels and volumes of a series. */
static json_t *describe_contents(const cvol_series *series)
{
    const int times = cvol_series_times(series), channels = cvol_series_channels(series);
    json_t *values = json_array(), *names = json_array(), *volumes = json_array();
    for (int t = 0; t < times; t++)
        json_array_append_new(values, json_real(cvol_series_time(series, t)));
    for (int c = 0; c < channels; c++) {
        double rgb[3];
        cvol_series_get_channel_colour(rgb, series, c);
        json_array_append_new(names, json_pack("{s:o, s:o}", "name",
                                               json_text(cvol_series_channel_name(series, c)),
                                               "colour", json_triple(rgb)));
    }
    for (int t = 0; t < times; t++)
        for (int c = 0; c < channels; c++)
            json_array_append_new(
                volumes,
                json_pack("{s:i, s:i, s:I, s:I}", "time", t, "channel", c, "offset",
                          (json_int_t)cvol_series_volume_offset(series, t, c), "file_bytes",
                          (json_int_t)cvol_series_volume_bytes(series, t, c)));
    return json_pack("{s:s, s:i, s:i, s:b, s:o, s:o, s:o, s:o}", "kind", "series", "times", times,
                     "channels", channels, "colours", cvol_series_has_colours(series),
                     "time_values", values, "time_unit", json_text(cvol_series_time_unit(series)),
                     "channel", names, "volumes", volumes);
}

/* The same as text. */
static void print_contents(const char *path, const cvol_series *series)
{
    const int times = cvol_series_times(series), channels = cvol_series_channels(series);
    const char *unit = cvol_series_time_unit(series);
    uint64_t least = UINT64_MAX, most = 0;
    for (int i = 0; i < times * channels; i++) {
        const uint64_t bytes = cvol_series_volume_bytes(series, i / channels, i % channels);
        least = bytes < least ? bytes : least;
        most = bytes > most ? bytes : most;
    }
    clear_progress();
    printf("%s\n  %-16s %d, %g to %g%s%s\n  %-16s %d%s\n", path, "times", times,
           cvol_series_time(series, 0), cvol_series_time(series, times - 1), unit[0] ? " " : "",
           unit, "channels", channels,
           cvol_series_has_colours(series) ? ", the components of one colour" : "");
    for (int c = 0; c < channels; c++) {
        double rgb[3];
        cvol_series_get_channel_colour(rgb, series, c);
        printf("    %-14d %s%s#%02x%02x%02x\n", c, cvol_series_channel_name(series, c),
               cvol_series_channel_name(series, c)[0] ? ", " : "", (unsigned)(255 * rgb[0] + 0.5),
               (unsigned)(255 * rgb[1] + 0.5), (unsigned)(255 * rgb[2] + 0.5));
    }
    printf("  %-16s %llu, volumes of %llu to %llu\n", "file_bytes",
           (unsigned long long)file_size(path), (unsigned long long)least,
           (unsigned long long)most);
}

/* Describes a series: the list of its volumes, and the grid, which all share. */
int show_series(cvol_context *context, common_options *common, const char *path)
{
    cvol_series *series;
    cvol_array *array;
    const size_t zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};
    const cvol_file_part first = {.size = sizeof(cvol_file_part), .begin = zero, .end = one};
    if (has_raw_options(common) || common->fill_given)
        return report_error(
            EXIT_MISUSED,
            "%s: is a .cvol file: leave out --dims, --type and other options for raw samples",
            path);
    int code = cvol_series_read(context, &series, path);
    if (code)
        return report_context_error(context, code, NULL);
    code = cvol_array_read_part(context, &array, NULL, path, &first);
    json_t *grid = code ? NULL : describe_grid(cvol_array_grid(array));
    int status = code ? report_context_error(context, code, NULL) : EXIT_DONE;
    if (!status && common->json) {
        json_t *object = describe_contents(series);
        json_object_set_new(object, "file_bytes", json_integer((json_int_t)file_size(path)));
        json_object_update(object, grid);
        status = print_json(object);
    } else if (!status) {
        print_contents(path, series);
        print_fields(grid);
    }
    json_decref(grid);
    cvol_array_free(array);
    cvol_series_free(series);
    return status;
}

/* ---- other formats ---- */

static json_t *describe_several(const volume_labels *labels, int times)
{
    json_t *values = json_array(), *channels = json_array();
    for (int t = 0; t < times; t++)
        json_array_append_new(values, json_real(labels->times ? labels->times[t] : t));
    for (int c = 0; c < labels->channels; c++)
        json_array_append_new(channels, json_pack("{s:o, s:o}", "name", json_text(labels->names[c]),
                                                  "colour", json_triple(labels->colours + 3 * c)));
    return json_pack("{s:s, s:i, s:i, s:b, s:o, s:o, s:o}", "kind", "series", "times", times,
                     "channels", labels->channels, "colours", labels->are_colours, "time_values",
                     values, "time_unit", json_text(labels->unit), "channel", channels);
}

/* Text like that of print_contents. */
static void print_several(const char *path, const volume_labels *labels, int times)
{
    clear_progress();
    printf("%s\n  %-16s %d", path, "times", times);
    if (labels->times && times > 1)
        printf(", %g to %g%s%s", labels->times[0], labels->times[times - 1],
               labels->unit[0] ? " " : "", labels->unit);
    printf("\n  %-16s %d%s\n", "channels", labels->channels,
           labels->are_colours ? ", the components of one colour" : "");
    for (int c = 0; c < labels->channels && labels->channels > 1; c++) {
        const double *rgb = labels->colours + 3 * c;
        printf("    %-14d %s%s#%02x%02x%02x\n", c, labels->names[c],
               labels->names[c][0] ? ", " : "", (unsigned)(255 * rgb[0] + 0.5),
               (unsigned)(255 * rgb[1] + 0.5), (unsigned)(255 * rgb[2] + 0.5));
    }
}

/* The grid, which all volumes share. Exit status. */
static int find_grid(cvol_context *context, cvol_grid *out, const common_options *common,
                     const char *path, int times, int channels)
{
    cvol_volume_stream *stream;
    cvol_read_options first = common->read;
    first.has_index = first.has_index || times > 1;
    first.has_channel = first.has_channel || channels > 1;
    const int code = cvol_volume_stream_open(context, &stream, path, &first);
    if (code)
        return report_context_error(context, code, NULL);
    *out = *cvol_volume_stream_grid(stream);
    cvol_volume_stream_free(stream);
    return EXIT_DONE;
}

int show_several(cvol_context *context, common_options *common, const char *path, int times,
                 int channels)
{
    volume_labels labels;
    cvol_grid grid;
    int status = find_grid(context, &grid, common, path, times, channels);
    if (status)
        return status;
    status = find_labels(context, &labels, common, path, times, channels);
    if (!status && common->json) {
        json_t *object = describe_several(&labels, times), *of_grid = describe_grid(&grid);
        json_object_set_new(object, "file_bytes", json_integer((json_int_t)file_size(path)));
        json_object_update(object, of_grid);
        json_decref(of_grid);
        status = print_json(object);
    } else if (!status) {
        json_t *of_grid = describe_grid(&grid);
        print_several(path, &labels, times);
        print_fields(of_grid);
        json_decref(of_grid);
    }
    free_labels(&labels);
    return status;
}
