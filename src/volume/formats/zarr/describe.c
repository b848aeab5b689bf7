/* The metadata of an image of OME-Zarr, as text: its numbers are the shortest that read back as
 * the same. */
#include "volume/formats/zarr/describe.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "volume/io/input.h"
#include "volume/io/text.h"
#include "volume/io/time_step.h"

static const char *const length_units[][2] = {
    {"pm", "picometer"},  {"A", "angstrom"},    {"nm", "nanometer"}, {"um", "micrometer"},
    {"mm", "millimeter"}, {"cm", "centimeter"}, {"m", "meter"},      {"inch", "inch"}};
static const char *const time_units[][2] = {
    {"s", "second"},   {"ms", "millisecond"}, {"us", "microsecond"}, {"ns", "nanosecond"},
    {"min", "minute"}, {"h", "hour"},         {"d", "day"}};

static const char *find(const char *const table[][2], size_t count, const char *unit)
{
    for (size_t i = 0; i < count; i++)
        if (!strcmp(unit, table[i][0]))
            return table[i][1];
    return NULL;
}

const char *cvol_zarr_time_unit(const char *unit)
{
    return find(time_units, sizeof time_units / sizeof *time_units, unit);
}

static char *quote(const char *text, size_t size)
{
    json_t *value = json_stringn(text, size);
    char *quoted = value ? json_dumps(value, JSON_ENCODE_ANY) : NULL;
    json_decref(value);
    return quoted;
}

/* A text in quotes; `instead` if it is not UTF-8. Jansson does not tell that from a lack of memory,
 * but a text that is not UTF-8 fails twice. */
static void put_text(cvol_bytes *out, const char *text, size_t size, const char *instead)
{
    char *quoted = quote(text, size);
    if (!quoted) {
        void *memory = malloc(4096 + 16 * size); /* more than quote needs */
        out->failed = out->failed || !memory;
        free(memory);
        quoted = quote(text, size);
    }
    cvol_bytes_put_text(out, quoted ? quoted : instead);
    free(quoted);
}

/* ---- axes ----------------------------------------------------------------------------- */

static void put_axis(cvol_bytes *out, const char *name, const char *type, const char *unit,
                     const char *end)
{
    char text[128];
    snprintf(text, sizeof text, "        {\"name\": \"%s\", \"type\": \"%s\"%s%s%s}%s\n", name,
             type, unit ? ", \"unit\": \"" : "", unit ? unit : "", unit ? "\"" : "", end);
    cvol_bytes_put_text(out, text);
}

static void put_axes(cvol_bytes *out, const cvol_zarr_written *w)
{
    const char *unit = find(length_units, sizeof length_units / sizeof *length_units, w->grid.unit);
    const char *of_time = w->series->time_unit;
    cvol_bytes_put_text(out, "      \"axes\": [\n");
    if (w->has_times)
        put_axis(out, "t", "time",
                 of_time && cvol_series_time_step(w->series) > 0 ? cvol_zarr_time_unit(of_time)
                                                                 : NULL,
                 ",");
    if (w->has_channels)
        put_axis(out, "c", "channel", NULL, ",");
    put_axis(out, "z", "space", unit, ",");
    put_axis(out, "y", "space", unit, ",");
    put_axis(out, "x", "space", unit, "");
    cvol_bytes_put_text(out, "      ],\n");
}

/* One number for each axis; those of z, y, x are given as x, y, z. */
static void put_numbers(cvol_bytes *out, const cvol_zarr_written *w, const char *type, double time,
                        double channel, const double spatial[3])
{
    char text[64];
    snprintf(text, sizeof text, "          {\"type\": \"%s\", \"%s\": [", type, type);
    cvol_bytes_put_text(out, text);
    if (w->has_times)
        cvol_text_put_number(out, "", time);
    if (w->has_channels)
        cvol_text_put_number(out, w->has_times ? ", " : "", channel);
    for (int a = 2; a >= 0; a--)
        cvol_text_put_number(out, a == 2 && !w->has_times && !w->has_channels ? "" : ", ",
                             spatial[a]);
    cvol_bytes_put_text(out, "]}");
}

/* Level k: samples are the means of boxes of 2^k, whose centres are shifted; labels are not. */
static void put_level(cvol_bytes *out, const cvol_zarr_written *w, int level)
{
    char text[64];
    const double factor = (double)(1 << level), shift = w->labels ? 0 : (factor - 1) / 2;
    const double step = cvol_series_time_step(w->series), *times = w->series->time_values;
    double scale[3], translation[3];
    for (int a = 0; a < 3; a++) {
        scale[a] = w->grid.spacing[a] * factor;
        translation[a] = w->grid.origin[a] + shift * w->grid.spacing[a];
    }
    snprintf(text, sizeof text, "        {\"path\": \"%d\", \"coordinateTransformations\": [\n",
             level);
    cvol_bytes_put_text(out, text);
    put_numbers(out, w, "scale", step > 0 ? step : 1, 1, scale);
    cvol_bytes_put_text(out, ",\n");
    put_numbers(out, w, "translation", step > 0 ? times[0] : 0, 0, translation);
    cvol_bytes_put_text(out, level + 1 < w->levels ? "\n        ]},\n" : "\n        ]}\n");
}

/* ---- channels -------------------------------------------------------------------------- */

static void put_channel(cvol_bytes *out, const cvol_zarr_written *w, int channel)
{
    char colour[40];
    double rgb[3];
    const cvol_series_options *s = w->series;
    const char *name = s->channel_names ? s->channel_names[channel] : NULL;
    const double *given = s->channel_colours ? s->channel_colours + (ptrdiff_t)(3 * channel) : NULL;
    if (given)
        memcpy(rgb, given, sizeof rgb);
    else
        rgb[0] = rgb[1] = rgb[2] = 1;
    for (int k = 0; k < 3; k++)
        rgb[k] = rgb[k] > 0 ? fmin(rgb[k], 1) : 0;
    snprintf(colour, sizeof colour, ", \"color\": \"%02X%02X%02X\", ",
             (unsigned)lround(255 * rgb[0]), (unsigned)lround(255 * rgb[1]),
             (unsigned)lround(255 * rgb[2]));
    cvol_bytes_put_text(out, "      {\"label\": ");
    put_text(out, name ? name : "", name ? strlen(name) : 0, "\"\"");
    cvol_bytes_put_text(out, colour);
    const int has_range = w->least[channel] <= w->most[channel];
    const double least = has_range ? w->least[channel] : 0, most = has_range ? w->most[channel] : 1;
    cvol_text_put_number(out, "\"active\": true, \"window\": {\"start\": ", least);
    cvol_text_put_number(out, ", \"end\": ", most);
    cvol_text_put_number(out, ", \"min\": ", least);
    cvol_text_put_number(out, ", \"max\": ", most);
    cvol_bytes_put_text(out, channel + 1 < w->channels ? "}},\n" : "}}\n");
}

/* ---- labels ---------------------------------------------------------------------------- */

static void put_label_value(cvol_bytes *out, const cvol_label *label, int is_first)
{
    char text[64];
    snprintf(text, sizeof text, "%s\n      {\"label-value\": %d, ", is_first ? "" : ",",
             label->value);
    cvol_bytes_put_text(out, text);
}

static void put_label_colours(cvol_bytes *out, const cvol_label *labels, size_t count)
{
    int is_first = 1;
    for (size_t i = 0; i < count; i++) {
        if (!(labels[i].rgb[0] >= 0))
            continue;
        cvol_bytes_put_text(out, is_first ? ",\n    \"colors\": [" : "");
        put_label_value(out, &labels[i], is_first);
        for (int k = 0; k < 3; k++)
            cvol_text_put_number(out, k ? ", " : "\"rgba\": [",
                                 (double)lround(255 * fmin(fmax(labels[i].rgb[k], 0), 1)));
        cvol_bytes_put_text(out, ", 255]}");
        is_first = 0;
    }
    cvol_bytes_put_text(out, is_first ? "" : "\n    ]");
}

static void put_label_names(cvol_bytes *out, const cvol_label *labels, size_t count)
{
    int is_first = 1;
    for (size_t i = 0; i < count; i++) {
        if (!labels[i].name || !labels[i].name[0])
            continue;
        cvol_bytes_put_text(out, is_first ? ",\n    \"properties\": [" : "");
        put_label_value(out, &labels[i], is_first);
        cvol_bytes_put_text(out, "\"name\": ");
        put_text(out, labels[i].name, strlen(labels[i].name), "\"\"");
        cvol_bytes_put_text(out, "}");
        is_first = 0;
    }
    cvol_bytes_put_text(out, is_first ? "" : "\n    ]");
}

void cvol_zarr_describe_labels(cvol_bytes *out, const cvol_series_options *series)
{
    put_label_colours(out, series->labels, series->labels ? series->label_count : 0);
    put_label_names(out, series->labels, series->labels ? series->label_count : 0);
}

/* ---- files ------------------------------------------------------------------------------ */

/* Format 3 has one version for the image, format 2 one for each of its parts. */
static void put_version(cvol_bytes *out, const cvol_zarr_written *w, const char *after)
{
    if (w->format == 3)
        return;
    cvol_bytes_put_text(out, "\"version\": \"0.4\"");
    cvol_bytes_put_text(out, after);
}

void cvol_zarr_describe_group(cvol_bytes *out, const cvol_zarr_written *w)
{
    const char *title = cvol_input_name(w->path);
    if (w->format == 3)
        cvol_bytes_put_text(out, "{\n  \"zarr_format\": 3,\n  \"node_type\": \"group\",\n"
                                 "  \"attributes\": {\"ome\": {\n  \"version\": \"0.5\",\n");
    else
        cvol_bytes_put_text(out, "{\n");
    cvol_bytes_put_text(out, "  \"multiscales\": [\n    {\n      ");
    put_version(out, w, ",\n      ");
    cvol_bytes_put_text(out, "\"name\": ");
    put_text(out, title, strcspn(title, "."), "\"image\"");
    cvol_bytes_put_text(out, ",\n");
    put_axes(out, w);
    cvol_bytes_put_text(out, "      \"datasets\": [\n");
    for (int k = 0; k < w->levels; k++)
        put_level(out, w, k);
    cvol_bytes_put_text(out, "      ],\n      \"type\": ");
    cvol_bytes_put_text(out, w->labels ? "\"nearest\"\n    }\n  ]" : "\"mean\"\n    }\n  ]");
    if (w->labels) {
        const size_t comma = w->format == 3 && w->label_list.size > 0; /* behind no version */
        cvol_bytes_put_text(out, ",\n  \"image-label\": {");
        put_version(out, w, "");
        if (w->label_list.size)
            cvol_bytes_append(out, w->label_list.data + comma, w->label_list.size - comma);
        cvol_bytes_put_text(out, "}");
    } else if (w->has_channels) {
        cvol_bytes_put_text(out, ",\n  \"omero\": {\n    ");
        put_version(out, w, ",\n    ");
        cvol_bytes_put_text(out, "\"channels\": [\n");
        for (int c = 0; c < w->channels; c++)
            put_channel(out, w, c);
        cvol_bytes_put_text(out, "    ]\n  }");
    }
    cvol_bytes_put_text(out, w->format == 3 ? "\n  }}\n}\n" : "\n}\n");
}

/* One size for each axis, slowest first. */
static void put_sizes(cvol_bytes *out, const cvol_zarr_written *w, int times, int channels,
                      const size_t sizes[3])
{
    char text[160] = "";
    int length = 0;
    if (w->has_times)
        length += snprintf(text + length, sizeof text - (size_t)length, "%d, ", times);
    if (w->has_channels)
        length += snprintf(text + length, sizeof text - (size_t)length, "%d, ", channels);
    snprintf(text + length, sizeof text - (size_t)length, "%zu, %zu, %zu", sizes[2], sizes[1],
             sizes[0]);
    cvol_bytes_put_text(out, text);
}

static void describe_array_2(cvol_bytes *out, const cvol_zarr_written *w, const size_t dims[3],
                             const size_t chunk[3])
{
    static const char *const types[] = {
        [CVOL_UINT8] = "|u1",   [CVOL_INT8] = "|i1",   [CVOL_UINT16] = "<u2",
        [CVOL_INT16] = "<i2",   [CVOL_UINT32] = "<u4", [CVOL_INT32] = "<i4",
        [CVOL_FLOAT32] = "<f4", [CVOL_FLOAT64] = "<f8"};
    cvol_bytes_put_text(out, "{\n  \"zarr_format\": 2,\n  \"shape\": [");
    put_sizes(out, w, w->times, w->channels, dims);
    cvol_bytes_put_text(out, "],\n  \"chunks\": [");
    put_sizes(out, w, 1, 1, chunk);
    cvol_bytes_put_text(out, "],\n  \"dtype\": \"");
    cvol_bytes_put_text(out, types[w->grid.type]);
    cvol_bytes_put_text(out, "\",\n  \"compressor\": {\"id\": \"zstd\", \"level\": 3},\n"
                             "  \"fill_value\": 0,\n  \"filters\": null,\n  \"order\": \"C\",\n"
                             "  \"dimension_separator\": \"/\"\n}\n");
}

static void describe_array_3(cvol_bytes *out, const cvol_zarr_written *w, const size_t dims[3],
                             const size_t chunk[3])
{
    cvol_bytes_put_text(out,
                        "{\n  \"zarr_format\": 3,\n  \"node_type\": \"array\",\n  \"shape\": [");
    put_sizes(out, w, w->times, w->channels, dims);
    cvol_bytes_put_text(out, "],\n  \"data_type\": \"");
    cvol_bytes_put_text(out, cvol_type_name(w->grid.type));
    cvol_bytes_put_text(out, "\",\n  \"chunk_grid\": {\"name\": \"regular\", \"configuration\": "
                             "{\"chunk_shape\": [");
    put_sizes(out, w, 1, 1, chunk);
    cvol_bytes_put_text(
        out, "]}},\n  \"chunk_key_encoding\": {\"name\": \"default\", \"configuration\": "
             "{\"separator\": \"/\"}},\n  \"fill_value\": 0,\n  \"codecs\": [\n"
             "    {\"name\": \"bytes\", \"configuration\": {\"endian\": \"little\"}},\n"
             "    {\"name\": \"zstd\", \"configuration\": {\"level\": 3, \"checksum\": false}}\n"
             "  ],\n  \"attributes\": {},\n  \"dimension_names\": [");
    cvol_bytes_put_text(out, w->has_times ? "\"t\", " : "");
    cvol_bytes_put_text(out, w->has_channels ? "\"c\", " : "");
    cvol_bytes_put_text(out, "\"z\", \"y\", \"x\"]\n}\n");
}

void cvol_zarr_describe_array(cvol_bytes *out, const cvol_zarr_written *w, const size_t dims[3],
                              const size_t chunk[3])
{
    (w->format == 3 ? describe_array_3 : describe_array_2)(out, w, dims, chunk);
}
