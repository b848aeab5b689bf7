/* The volumes of files that a page shows. */
#include "volume_list.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cvol/cvol.h"

static int add(volume_list *list, const viewer_volume *volume)
{
    viewer_volume *more = realloc(list->volumes, ((size_t)list->count + 1) * sizeof *more);
    if (more)
        list->volumes = more;
    if (!more || !volume->path || !volume->name || list->count >= VOLUMES_MAX)
        return -1;
    more[list->count++] = *volume;
    return 0;
}

/* "scan.cvol, DAPI"; NULL without memory. */
static char *name_channel(const char *name, const char *channel_name, int channel)
{
    char number[32];
    snprintf(number, sizeof number, "channel %d", channel);
    const char *last = channel_name[0] ? channel_name : number;
    const size_t size = strlen(name) + strlen(last) + 3;
    char *text = malloc(size);
    if (text)
        snprintf(text, size, "%s, %s", name, last);
    return text;
}

/* All times of a volume: their values and unit. 0, or -1 without memory. */
static int set_times(viewer_volume *volume, const cvol_series *series)
{
    const int times = cvol_series_times(series);
    double *values = malloc((size_t)times * sizeof *values);
    if (!values)
        return -1;
    for (int t = 0; t < times; t++)
        values[t] = cvol_series_time(series, t);
    volume->read.has_index = 1;
    volume->times = times;
    volume->time_values = values;
    volume->time_unit = strdup(cvol_series_time_unit(series));
    return volume->time_unit ? 0 : -1;
}

/* One of several channels that are shown together. 0, or -1 without memory. */
static int set_channel(viewer_volume *volume, const cvol_series *series, int channel, int first)
{
    char *name = strdup(cvol_series_channel_name(series, channel));
    volume->read.has_channel = 1;
    volume->read.channel = channel;
    volume->channel = (viewer_channel){.count = cvol_series_channels(series),
                                       .first = first,
                                       .number = channel,
                                       .name = name,
                                       .is_component = cvol_series_has_colours(series)};
    cvol_series_get_channel_colour(volume->channel.rgb, series, channel);
    volume->name = name ? name_channel(volume->name, name, channel) : NULL;
    return name ? 0 : -1;
}

static int add_series(volume_list *list, const viewer_volume *one, const cvol_series *series)
{
    viewer_volume volume = *one;
    const int first = list->count;
    int failed = cvol_series_times(series) > 1 && !one->read.has_index &&
                 set_times(&volume, series);
    if (cvol_series_channels(series) == 1 || one->read.has_channel)
        return failed ? failed : add(list, &volume);
    for (int c = 0; !failed && c < cvol_series_channels(series); c++) {
        volume.name = one->name;
        failed = set_channel(&volume, series, c, first) || add(list, &volume);
    }
    return failed ? -1 : 0;
}

int volume_list_add(volume_list *list, const char *path, const char *name, int time, int channel,
                    int level)
{
    cvol_context *context = cvol_context_create();
    cvol_series *series = NULL;
    viewer_volume one = {.path = strdup(path), .name = strdup(name), .level = level};
    one.read = cvol_read_options_defaults();
    one.read.has_index = time >= 0;
    one.read.index = time >= 0 ? time : 0;
    one.read.has_channel = channel >= 0;
    one.read.channel = channel >= 0 ? channel : 0;
    list->last = list->count;
    int failed = !context || !one.path || !one.name;
    if (!failed && !cvol_series_read(context, &series, path))
        failed = add_series(list, &one, series);
    else if (!failed)
        failed = add(list, &one);
    cvol_series_free(series);
    cvol_context_free(context);
    return failed ? -1 : 0;
}

void volume_list_set_bricks(volume_list *list, uint8_t *levels, size_t count)
{
    for (int i = list->last; i < list->count; i++) {
        list->volumes[i].brick_levels = levels;
        list->volumes[i].brick_count = count;
    }
}

int volume_list_add_label(volume_list *list, int value, const char *name, const double rgb[3])
{
    for (int i = list->last; i < list->count; i++) {
        viewer_volume *v = &list->volumes[i];
        viewer_label *more = realloc((void *)v->labels, (v->label_count + 1) * sizeof *more);
        char *kept_name = *name ? strdup(name) : NULL;
        if (more)
            v->labels = more;
        if (!more || (*name && !kept_name))
            return -1;
        more[v->label_count++] = (viewer_label){.value = value,
                                                .name = kept_name,
                                                .has_colour = rgb[0] >= 0,
                                                .rgb = {rgb[0], rgb[1], rgb[2]}};
    }
    return 0;
}
