/* Files of many volumes: which one is meant, and how many there are. */
#include <stdlib.h>
#include <string.h>

#include "cli.h"

int choose_volume(cvol_context *context, common_options *common, const char *path,
                  cvol_file_part *part)
{
    const cvol_read_options *read = &common->read;
    if (read->series)
        return complain(EXIT_MISUSED, "%s: is a .cvol file: --series is for DICOM", path);
    if (cvol_file_kind_of(path) != CVOL_FILE_SERIES) {
        if (read->has_index || read->has_channel)
            return complain(EXIT_MISUSED,
                            "%s: is a .cvol file of one volume: --time, --index and --channel have "
                            "nothing to choose from",
                            path);
        return EXIT_DONE;
    }
    part->time = read->has_index ? read->index : 0;
    part->channel = read->has_channel ? read->channel : 0;
    cvol_series *series;
    const int code = cvol_series_read(context, &series, path);
    if (code)
        return complain_context(context, code, NULL);
    const int times = cvol_series_times(series), channels = cvol_series_channels(series);
    cvol_series_free(series);
    if (((times > 1 && !read->has_index) || (channels > 1 && !read->has_channel)) &&
        part->time < times && part->channel < channels && !common->choice_said) {
        common->choice_said = 1;
        clear_progress();
        fprintf(stderr, "cvol: %s: this is ", path);
        if (times > 1)
            fprintf(stderr, "time %d of %d%s", part->time, times, channels > 1 ? ", " : "");
        if (channels > 1)
            fprintf(stderr, "channel %d of %d", part->channel, channels);
        fprintf(stderr, "; %s%s%s another\n", times > 1 ? "--time" : "",
                times > 1 && channels > 1 ? " and " : "",
                channels > 1 ? times > 1 ? "--channel choose" : "--channel chooses" : " chooses");
    }
    return EXIT_DONE;
}

int count_volumes(cvol_context *context, common_options *common, const char *path, int *times,
                  int *channels)
{
    const cvol_read_options *read = &common->read;
    *times = *channels = 1;
    int code;
    if (cvol_file_is_cvol(path)) {
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
        code = cvol_volume_contents(context, times, channels, path, read);
    }
    return code ? complain_context(context, code, NULL) : EXIT_DONE;
}

/* ---- colours -------------------------------------------------------------------------------- */

/* A name, or #rrggbb; 1 if that is what the text is, of so many letters. */
static int parse_colour(double rgb[3], const char *text, size_t length)
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
            return complain(EXIT_MISUSED,
                            "--channel-colors is '%s', must be names (red green blue yellow "
                            "magenta cyan orange white) or #rrggbb, between commas",
                            text);
        if (found < count)
            memcpy(out + 3 * found, rgb, sizeof rgb);
        next = comma ? comma + 1 : NULL;
    }
    return found == count
               ? EXIT_DONE
               : complain(EXIT_MISUSED, "--channel-colors has %d colours, there are %d channels",
                          found, count);
}
