/* OME-XML, schema 2016-06 (docs.openmicroscopy.org/ome-model): one image, whose pixels have sizes,
 * lengths with units, a time step, and channels with names and colours. */
#include "volume/formats/tiff/ome.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "volume/io/format.h"
#include "volume/io/text.h"
#include "volume/io/time_step.h"

int cvol_tiff_is_ome(const char *path)
{
    return cvol_text_ends(path, ".ome.tif") || cvol_text_ends(path, ".ome.tiff");
}

static void put_attribute(cvol_bytes *bytes, const char *name, const char *value)
{
    cvol_bytes_put_text(bytes, " ");
    cvol_bytes_put_text(bytes, name);
    cvol_bytes_put_text(bytes, "=\"");
    cvol_bytes_put_text(bytes, value);
    cvol_bytes_put_text(bytes, "\"");
}

static void put_count(cvol_bytes *bytes, const char *name, size_t count)
{
    char text[24];
    snprintf(text, sizeof text, "%zu", count);
    put_attribute(bytes, name, text);
}

static void put_number(cvol_bytes *bytes, const char *name, double value)
{
    char text[CVOL_TEXT_NUMBER_BYTES];
    cvol_text_format(text, value);
    put_attribute(bytes, name, text);
}

/* ---- units ---------------------------------------------------------------------------- */

/* The specification's name of a unit; `instead` if it has none. */
static const char *unit_name(const char *unit, const char *const names[][2], size_t count,
                             const char *instead)
{
    for (size_t i = 0; unit && i < count; i++)
        if (!strcmp(unit, names[i][0]))
            return names[i][1];
    return instead;
}

static const char *length_unit(const char *unit)
{
    static const char *const names[][2] = {{"A", "\xc3\x85"},
                                           {"\xc3\x85", "\xc3\x85"},
                                           {"pm", "pm"},
                                           {"nm", "nm"},
                                           {"um", "\xc2\xb5m"},
                                           {"\xc2\xb5m", "\xc2\xb5m"},
                                           {"\xce\xbcm", "\xc2\xb5m"},
                                           {"mm", "mm"},
                                           {"cm", "cm"},
                                           {"m", "m"},
                                           {"inch", "in"}};
    return unit_name(unit, names, sizeof names / sizeof *names, "reference frame");
}

/* NULL: none. */
static const char *time_unit(const char *unit)
{
    static const char *const names[][2] = {{"s", "s"},   {"ms", "ms"},   {"us", "\xc2\xb5s"},
                                           {"ns", "ns"}, {"min", "min"}, {"h", "h"},
                                           {"d", "d"}};
    return unit_name(unit, names, sizeof names / sizeof *names, NULL);
}

/* ---- elements ------------------------------------------------------------------------- */

static const char *type_name(cvol_type type)
{
    return type == CVOL_FLOAT32 ? "float" : type == CVOL_FLOAT64 ? "double" : cvol_type_name(type);
}

/* A text of printable UTF-8, with entities for the letters that have a meaning in XML. */
static void put_name(cvol_bytes *bytes, const char *name)
{
    cvol_bytes_put_text(bytes, " Name=\"");
    for (const char *c = name; *c; c++)
        switch (*c) {
        case '&':
            cvol_bytes_put_text(bytes, "&amp;");
            break;
        case '<':
            cvol_bytes_put_text(bytes, "&lt;");
            break;
        case '>':
            cvol_bytes_put_text(bytes, "&gt;");
            break;
        case '"':
            cvol_bytes_put_text(bytes, "&quot;");
            break;
        default:
            cvol_bytes_append(bytes, c, 1);
        }
    cvol_bytes_put_text(bytes, "\"");
}

/* Colours are the bytes red, green, blue and opacity of one signed number. */
static void put_colour(cvol_bytes *bytes, const double rgb[3])
{
    char text[16];
    uint32_t colour = 255;
    for (int k = 0; k < 3; k++)
        colour |= (uint32_t)lround(255 * fmin(fmax(rgb[k], 0), 1)) << (24 - 8 * k);
    const long long number = colour > INT32_MAX ? (long long)colour - (1LL << 32) : colour;
    snprintf(text, sizeof text, "%lld", number);
    put_attribute(bytes, "Color", text);
}

/* RGB, or RGBA. Programs expect bytes or 16-bit samples in pages of colours. */
unsigned cvol_tiff_ome_components(const cvol_grid *grid, const cvol_series_options *series)
{
    const int is_usual = grid->type == CVOL_UINT8 || grid->type == CVOL_UINT16;
    return series->colours && is_usual && (series->channels == 3 || series->channels == 4)
               ? (unsigned)series->channels
               : 1;
}

static void put_channel(cvol_bytes *bytes, const cvol_series_options *series, int channel)
{
    char text[64];
    cvol_channel_label label = {.name = ""};
    const char *name = series->channel_names ? series->channel_names[channel] : NULL;
    snprintf(text, sizeof text, "<Channel ID=\"Channel:0:%d\"", channel);
    cvol_bytes_put_text(bytes, text);
    if (name)
        cvol_labels_set_name(&label, name, strlen(name));
    if (label.name[0])
        put_name(bytes, label.name);
    if (series->channel_colours)
        put_colour(bytes, series->channel_colours + 3 * (size_t)channel);
    cvol_bytes_put_text(bytes, " SamplesPerPixel=\"1\"/>");
}

static void put_pixels(cvol_bytes *bytes, const cvol_grid *grid, const cvol_series_options *series)
{
    static const char *const sizes[] = {"PhysicalSizeX", "PhysicalSizeY", "PhysicalSizeZ"};
    static const char *const units[] = {"PhysicalSizeXUnit", "PhysicalSizeYUnit",
                                        "PhysicalSizeZUnit"};
    const double step = cvol_series_time_step(series);
    cvol_bytes_put_text(bytes,
                        "<Pixels ID=\"Pixels:0\" DimensionOrder=\"XYZCT\" BigEndian=\"false\"");
    put_attribute(bytes, "Type", type_name(grid->type));
    put_count(bytes, "SizeX", grid->dims[0]);
    put_count(bytes, "SizeY", grid->dims[1]);
    put_count(bytes, "SizeZ", grid->dims[2]);
    put_count(bytes, "SizeC", (size_t)series->channels);
    put_count(bytes, "SizeT", (size_t)series->times);
    for (int a = 0; a < 3; a++) {
        put_number(bytes, sizes[a], grid->spacing[a]);
        put_attribute(bytes, units[a], length_unit(grid->unit));
    }
    if (step > 0 && time_unit(series->time_unit)) {
        put_number(bytes, "TimeIncrement", step);
        put_attribute(bytes, "TimeIncrementUnit", time_unit(series->time_unit));
    }
    cvol_bytes_put_text(bytes, ">");
}

void cvol_tiff_put_ome(cvol_bytes *bytes, const cvol_grid *grid, const cvol_series_options *series)
{
    cvol_bytes_put_text(
        bytes, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>"
               "<OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\""
               " xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\""
               " xsi:schemaLocation=\"http://www.openmicroscopy.org/Schemas/OME/2016-06"
               " http://www.openmicroscopy.org/Schemas/OME/2016-06/ome.xsd\" Creator=\"cvol\">"
               "<Image ID=\"Image:0\">");
    const unsigned components = cvol_tiff_ome_components(grid, series);
    const size_t channels = (size_t)series->channels / components;
    put_pixels(bytes, grid, series);
    if (components > 1) {
        cvol_bytes_put_text(bytes, "<Channel ID=\"Channel:0:0\"");
        put_count(bytes, "SamplesPerPixel", components);
        cvol_bytes_put_text(bytes, "/>");
    }
    for (int c = 0; c < series->channels && components == 1; c++)
        put_channel(bytes, series, c);
    cvol_bytes_put_text(bytes, "<TiffData IFD=\"0\"");
    put_count(bytes, "PlaneCount", grid->dims[2] * channels * (size_t)series->times);
    cvol_bytes_put_text(bytes, "/></Pixels></Image></OME>");
    cvol_bytes_put_u8(bytes, 0);
}
