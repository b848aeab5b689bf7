/* Section LIST: times, channels, and the places of their volumes; and its form in memory. */
#define _GNU_SOURCE
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "codec/container/series.h"
#include "codec/section/section.h"

/* Sizes of its fields in bytes. */
enum {
    LIST_HEAD = 8 + CVOL_TIME_UNIT_BYTES,
    LIST_CHANNEL = 24 + CVOL_CHANNEL_NAME_BYTES,
    LIST_TIME = 8,
    LIST_VOLUME = 16,
    LIST_TAIL = 4 /* files without colours lack it */
};

int cvol_series_make(cvol_context *context, cvol_series **out, int times, int channels)
{
    const size_t count = (size_t)times * (size_t)channels;
    cvol_series *series = calloc(1, sizeof *series);
    *out = NULL;
    if (series) {
        series->times = times;
        series->channels = channels;
        series->channel = calloc((size_t)channels, sizeof *series->channel);
        series->time = calloc((size_t)times, sizeof *series->time);
        series->volumes = calloc(count, sizeof *series->volumes);
    }
    if (!series || !series->channel || !series->time || !series->volumes) {
        cvol_series_free(series);
        return cvol_fail_memory(context, count * sizeof *series->volumes, "a list of volumes");
    }
    *out = series;
    return CVOL_OK;
}

void cvol_series_free(cvol_series *series)
{
    if (!series)
        return;
    free(series->channel);
    free(series->time);
    free(series->volumes);
    free(series);
}

/* ---- queries ---------------------------------------------------------------------------- */

int cvol_series_times(const cvol_series *series)
{
    return series->times;
}

int cvol_series_channels(const cvol_series *series)
{
    return series->channels;
}

int cvol_series_is_list(const cvol_series *series)
{
    return series->is_list;
}

int cvol_series_has_colours(const cvol_series *series)
{
    return series->are_colours;
}

double cvol_series_time(const cvol_series *series, int time)
{
    return time < 0 || time >= series->times ? 0 : series->time[time];
}

const char *cvol_series_time_unit(const cvol_series *series)
{
    return series->unit;
}

const char *cvol_series_channel_name(const cvol_series *series, int channel)
{
    return channel < 0 || channel >= series->channels ? "" : series->channel[channel].name;
}

void cvol_series_get_channel_colour(double rgb[3], const cvol_series *series, int channel)
{
    static const double white[3] = {1, 1, 1};
    const int known = channel >= 0 && channel < series->channels;
    memcpy(rgb, known ? series->channel[channel].colour : white, sizeof white);
}

static cvol_extent extent_of(const cvol_series *series, int time, int channel)
{
    if (time < 0 || time >= series->times || channel < 0 || channel >= series->channels)
        return (cvol_extent){0, 0};
    return series->volumes[(size_t)time * (size_t)series->channels + (size_t)channel];
}

uint64_t cvol_series_volume_bytes(const cvol_series *series, int time, int channel)
{
    return extent_of(series, time, channel).length;
}

uint64_t cvol_series_volume_offset(const cvol_series *series, int time, int channel)
{
    return extent_of(series, time, channel).offset;
}

void cvol_series_get_default_colour(double rgb[3], int channel, int channels)
{
    /* Bits: red 1, green 2, blue 4. Two channels are green and magenta, which colour-blind readers
     * distinguish; more channels follow the order of the most common dyes. */
    static const int two[] = {2, 5}, many[] = {4, 2, 1, 3, 5, 6, 7};
    const int bits = channels < 2    ? 7
                     : channels == 2 ? two[channel == 1]
                                     : many[channel < 0 ? 0 : channel % 7];
    for (int k = 0; k < 3; k++)
        rgb[k] = bits >> k & 1;
}

/* ---- writing ---------------------------------------------------------------------------- */

/* Without LIST_TAIL. */
static uint64_t least_list_bytes(uint64_t times, uint64_t channels)
{
    return LIST_HEAD + LIST_CHANNEL * channels + LIST_TIME * times + LIST_VOLUME * times * channels;
}

uint64_t cvol_series_list_bytes(const cvol_series *series)
{
    const uint64_t times = (uint64_t)series->times, channels = (uint64_t)series->channels;
    return least_list_bytes(times, channels) + LIST_TAIL;
}

void cvol_series_put(cvol_bytes *out, const cvol_series *series)
{
    cvol_bytes_put_u32(out, (uint32_t)series->times);
    cvol_bytes_put_u32(out, (uint32_t)series->channels);
    cvol_bytes_append(out, series->unit, sizeof series->unit);
    for (int c = 0; c < series->channels; c++) {
        for (int k = 0; k < 3; k++)
            cvol_bytes_put_f64(out, series->channel[c].colour[k]);
        cvol_bytes_append(out, series->channel[c].name, sizeof series->channel[c].name);
    }
    for (int t = 0; t < series->times; t++)
        cvol_bytes_put_f64(out, series->time[t]);
    for (size_t i = 0; i < (size_t)series->times * (size_t)series->channels; i++) {
        cvol_bytes_put_u64(out, series->volumes[i].offset);
        cvol_bytes_put_u64(out, series->volumes[i].length);
    }
    cvol_bytes_put_u32(out, series->are_colours ? 1 : 0);
}

/* ---- reading ---------------------------------------------------------------------------- */

static int fail(cvol_context *context, const char *name, const char *what)
{
    return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: section LIST: %s", name, what);
}

/* Reads text that ends within its bytes; the rest must be zeros. */
static int take_text(cvol_cursor *content, char *out, size_t size)
{
    const uint8_t *bytes = cvol_cursor_take(content, size);
    if (!bytes)
        return 0;
    memcpy(out, bytes, size);
    size_t length = strnlen(out, size);
    int padded = length < size;
    for (size_t i = length; i < size; i++)
        padded &= !out[i];
    return padded;
}

static int take_counts(cvol_context *context, cvol_series **out, cvol_cursor *content,
                       const char *name)
{
    const uint32_t times = cvol_cursor_u32(content), channels = cvol_cursor_u32(content);
    if (content->failed || !times || !channels)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section LIST: has %u times and %u channels", name, times, channels);
    if ((uint64_t)times * channels > CVOL_SERIES_MOST)
        return cvol_fail(context, CVOL_ERROR_LIMIT,
                         "%s: section LIST: has %u times and %u channels, more than %d "
                         "volumes",
                         name, times, channels, (int)CVOL_SERIES_MOST);
    if (least_list_bytes(times, channels) > content->size)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section LIST: %u times and %u channels take %llu bytes, it has %zu",
                         name, times, channels,
                         (unsigned long long)least_list_bytes(times, channels), content->size);
    return cvol_series_make(context, out, (int)times, (int)channels);
}

static int take_channel(cvol_context *context, cvol_channel *channel, int number,
                        cvol_cursor *content, const char *name)
{
    int sound = 1;
    for (int k = 0; k < 3; k++) {
        channel->colour[k] = cvol_cursor_f64(content);
        sound &= channel->colour[k] >= 0 && channel->colour[k] <= 1;
    }
    sound &= take_text(content, channel->name, sizeof channel->name);
    return sound ? CVOL_OK
                 : cvol_fail(context, CVOL_ERROR_CORRUPT,
                             "%s: section LIST: channel %d has a colour beyond 0 to 1, or a name "
                             "without an end",
                             name, number);
}

/* Reads the volumes; each must begin after the end of the previous one. */
static int take_volumes(cvol_context *context, cvol_series *series, cvol_cursor *content,
                        const char *name)
{
    uint64_t free_at = 0;
    for (size_t i = 0; i < (size_t)series->times * (size_t)series->channels; i++) {
        cvol_extent *extent = &series->volumes[i];
        uint64_t end;
        extent->offset = cvol_cursor_u64(content);
        extent->length = cvol_cursor_u64(content);
        if (extent->offset < CVOL_SECTION_HEADER_BYTES ||
            extent->offset - CVOL_SECTION_HEADER_BYTES < free_at ||
            __builtin_add_overflow(extent->offset, extent->length, &end))
            return cvol_fail(context, CVOL_ERROR_CORRUPT,
                             "%s: section LIST: volume %zu of %llu bytes at byte %llu overlaps the "
                             "content before it, which ends at byte %llu",
                             name, i, (unsigned long long)extent->length,
                             (unsigned long long)extent->offset, (unsigned long long)free_at);
        free_at = end;
    }
    return CVOL_OK;
}

static int take_rest(cvol_context *context, cvol_series *series, cvol_cursor *content,
                     const char *name)
{
    int code = CVOL_OK;
    series->is_list = 1;
    if (!take_text(content, series->unit, sizeof series->unit))
        return fail(context, name, "the unit of time is not text");
    for (int c = 0; c < series->channels && !code; c++)
        code = take_channel(context, &series->channel[c], c, content, name);
    for (int t = 0; t < series->times && !code; t++) {
        series->time[t] = cvol_cursor_f64(content);
        if (!isfinite(series->time[t]))
            code = fail(context, name, "a time is not a number");
    }
    if (!code)
        code = take_volumes(context, series, content, name);
    if (!code && content->size - content->at >= LIST_TAIL)
        series->are_colours = (cvol_cursor_u32(content) & 1) &&
                              (series->channels == 3 || series->channels == 4);
    return code;
}

int cvol_series_take_list(cvol_context *context, cvol_series **out, cvol_cursor *content,
                          const char *name)
{
    *out = NULL;
    int code = take_counts(context, out, content, name);
    if (!code)
        code = take_rest(context, *out, content, name);
    if (code) {
        cvol_series_free(*out);
        *out = NULL;
    }
    return code;
}
