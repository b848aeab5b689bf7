/* Spacing, channels and times from a TIFF's description.
 *
 * ImageJ: lines "key=value" behind "ImageJ=VERSION"; channels run fastest, then slices, then times;
 * x and y resolution are tags, in pixels per unit (imagej.net, ij.io.TiffEncoder). OME: XML, whose
 * first Pixels element has SizeZ, SizeC, SizeT, DimensionOrder and PhysicalSizeX..Z
 * (docs.openmicroscopy.org/ome-model). The reader uses only these attributes, and for labels
 * TimeIncrement, and Name and Color of the Channel elements within. */
#define _GNU_SOURCE
#include "volume/formats/tiff/stack.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "volume/io/text.h"
#include "volume/io/xml.h"

/* ---- values -------------------------------------------------------------------------- */

/* The text of length `size` as a count from 1 to 2^31; 0 if it is none. */
static size_t read_count(const char *text, size_t size)
{
    int64_t value;
    return cvol_text_integer(text, size, &value) && value >= 1 && value <= INT32_MAX ? (size_t)value
                                                                                     : 0;
}

/* Positive and finite, else 0. */
static double read_length(const char *text, size_t size)
{
    double value;
    return cvol_text_number(text, size, &value) && value > 0 && isfinite(value) ? value : 0;
}

static void set_unit(char unit[16], const char *text, size_t size)
{
    snprintf(unit, 16, "%.*s", (int)(size < 16 ? size : 15), text);
}

/* ---- ImageJ -------------------------------------------------------------------------- */

static void read_imagej_line(cvol_tiff_stack *s, const char *line, size_t size)
{
    const char *equals = memchr(line, '=', size);
    if (!equals)
        return;
    size_t name = (size_t)(equals - line), rest = size - name - 1;
    const char *value = equals + 1;
    size_t *count = NULL;
    if (name == 6 && !memcmp(line, "images", 6))
        count = &s->images;
    else if (name == 6 && !memcmp(line, "slices", 6))
        count = &s->slices;
    else if (name == 8 && !memcmp(line, "channels", 8))
        count = &s->channels;
    else if (name == 6 && !memcmp(line, "frames", 6))
        count = &s->times;
    else if (name == 7 && !memcmp(line, "spacing", 7))
        s->spacing[2] = read_length(value +
                                        (rest && *value == '-'), /* ImageJ allows negative ones */
                                    rest - (rest && *value == '-'));
    else if (name == 4 && !memcmp(line, "unit", 4)) /* yunit and zunit follow, if they differ */
        for (int a = 0; a < 3; a++)
            set_unit(s->unit[a], value, rest);
    else if (name == 5 && (!memcmp(line, "yunit", 5) || !memcmp(line, "zunit", 5)))
        set_unit(s->unit[line[0] - 'x'], value, rest);
    if (count && read_count(value, rest))
        *count = read_count(value, rest);
}

static void read_imagej(cvol_tiff_stack *s, const char *text)
{
    s->known = s->is_imagej = 1;
    s->slices = s->channels = s->times = s->images = 0;
    while (*text) {
        size_t size = strcspn(text, "\r\n");
        read_imagej_line(s, text, size);
        text += size;
        text += strspn(text, "\r\n");
    }
    s->channels += !s->channels;
    s->times += !s->times;
    /* A plain stack has images only. */
    s->images += !s->images;
    if (!s->slices)
        s->slices = s->images / s->channels / s->times;
    s->slices += !s->slices;
    s->channel_step = 1;
    s->slice_step = s->channels;
    s->time_step = s->channels * s->slices;
}

/* ---- OME ----------------------------------------------------------------------------- */

/* The value of an attribute of the element that begins at `element`, or NULL. */
static const char *find_attribute(const char *element, const char *name, size_t *size)
{
    const char *end = strchr(element, '>');
    size_t length = strlen(name);
    for (const char *at = element; end && (at = strstr(at, name)) && at < end; at += length) {
        const char quote = at[length] == '=' ? at[length + 1] : '\0';
        if ((at[-1] != ' ' && at[-1] != '\n' && at[-1] != '\t' && at[-1] != '\r') ||
            (quote != '"' && quote != '\''))
            continue;
        const char *value = at + length + 2, *close = strchr(value, quote);
        *size = close ? (size_t)(close - value) : 0;
        return close ? value : NULL;
    }
    return NULL;
}

static size_t ome_count(const char *pixels, const char *name)
{
    size_t size;
    const char *value = find_attribute(pixels, name, &size);
    size_t count = value ? read_count(value, size) : 0;
    return count ? count : 1;
}

static int is_order(const char *order)
{
    return memchr(order + 2, 'Z', 3) && memchr(order + 2, 'C', 3) && memchr(order + 2, 'T', 3);
}

/* Pages run along the last three of five letters, XY first. */
static void set_ome_order(cvol_tiff_stack *s, const char *order)
{
    size_t step = 1;
    for (int i = 2; i < 5; i++) {
        size_t *at = order[i] == 'Z'   ? &s->slice_step
                     : order[i] == 'C' ? &s->channel_step
                                       : &s->time_step;
        *at = step;
        step *= order[i] == 'Z' ? s->slices : order[i] == 'C' ? s->channels : s->times;
    }
}

static void read_ome(cvol_tiff_stack *s, const char *pixels, size_t samples)
{
    static const char *const sizes[] = {"PhysicalSizeX", "PhysicalSizeY", "PhysicalSizeZ"};
    static const char *const units[] = {"PhysicalSizeXUnit", "PhysicalSizeYUnit",
                                        "PhysicalSizeZUnit"};
    size_t size;
    s->known = 1;
    s->slices = ome_count(pixels, "SizeZ");
    s->channels = ome_count(pixels, "SizeC");
    if (samples > 1 && s->channels % samples == 0)
        s->channels /= samples;
    s->times = ome_count(pixels, "SizeT");
    const char *value = find_attribute(pixels, "DimensionOrder", &size);
    set_ome_order(s, value && size == 5 && is_order(value) ? value : "XYZCT");
    for (int a = 0; a < 3; a++) {
        value = find_attribute(pixels, sizes[a], &size);
        s->spacing[a] = value ? read_length(value, size) : 0;
        if (s->spacing[a] > 0) { /* micrometres by default */
            value = find_attribute(pixels, units[a], &size);
            set_unit(s->unit[a], value ? value : "um", value ? size : 2);
        }
    }
}

void cvol_tiff_read_description(cvol_tiff_stack *stack, const char *text, size_t samples)
{
    *stack = (cvol_tiff_stack){.known = 0};
    if (!text)
        return;
    const char *pixels = NULL;
    if (!strncmp(text, "ImageJ=", 7))
        read_imagej(stack, text);
    else if (strstr(text, "<OME") && (pixels = strstr(text, "<Pixels")))
        read_ome(stack, pixels, samples);
}

/* ---- labels -------------------------------------------------------------------------- */

/* ImageJ: seconds unless tunit names another unit. */
static void read_imagej_labels(cvol_labels *labels, const char *text)
{
    snprintf(labels->time_unit, sizeof labels->time_unit, "s");
    while (*text) {
        const size_t size = strcspn(text, "\r\n");
        if (size > 10 && !memcmp(text, "finterval=", 10))
            labels->time_step = read_length(text + 10, size - 10);
        else if (size > 6 && !memcmp(text, "tunit=", 6))
            cvol_labels_set_unit(labels, text + 6, size - 6);
        text += size;
        text += strspn(text, "\r\n");
    }
}

/* An attribute's text with its character entities replaced. */
static void read_name(cvol_channel_label *channel, const char *text, size_t size)
{
    static const struct {
        const char *code;
        char letter;
    } codes[] = {{"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}};
    char plain[256];
    size_t length = 0;
    for (size_t at = 0; at < size && length < sizeof plain; length++) {
        plain[length] = text[at];
        size_t step = 1;
        for (size_t i = 0; i < sizeof codes / sizeof *codes; i++) {
            const size_t code = strlen(codes[i].code);
            if (size - at >= code && !memcmp(text + at, codes[i].code, code)) {
                plain[length] = codes[i].letter;
                step = code;
            }
        }
        at += step;
    }
    cvol_labels_set_name(channel, plain, length);
}

/* Red, green, blue and opacity as the bytes of one signed number. */
static void read_colour(cvol_channel_label *channel, const char *text, size_t size)
{
    int64_t value;
    if (!cvol_text_integer(text, size, &value) || value < INT32_MIN || value > UINT32_MAX)
        return;
    channel->has_colour = 1;
    for (int k = 0; k < 3; k++)
        channel->colour[k] = (double)((uint32_t)value >> (24 - 8 * k) & 255) / 255;
}

/* Channel elements of the first Pixels; those that are samples of one pixel share a name. */
static void read_ome_labels(cvol_labels *labels, const char *text, size_t samples)
{
    cvol_xml_tag tag;
    size_t size, next = 0;
    const char *value;
    int within = 0;
    for (; cvol_xml_next(&tag, text); text = tag.end + 1) {
        if (cvol_xml_is(&tag, "Pixels")) {
            if (within || tag.closes)
                return;
            within = 1;
            value = cvol_xml_attribute(&tag, "TimeIncrement", &size);
            labels->time_step = value ? read_length(value, size) : 0;
            value = cvol_xml_attribute(&tag, "TimeIncrementUnit", &size);
            cvol_labels_set_unit(labels, value ? value : "s", value ? size : 1);
        } else if (within && cvol_xml_is(&tag, "Channel") && !tag.closes) {
            if (samples == 1 && next < labels->channels) {
                cvol_channel_label *channel = &labels->channel[next++];
                if ((value = cvol_xml_attribute(&tag, "Name", &size)))
                    read_name(channel, value, size);
                if ((value = cvol_xml_attribute(&tag, "Color", &size)))
                    read_colour(channel, value, size);
            }
        }
    }
}

int cvol_tiff_read_labels(cvol_labels *labels, const char *text, size_t channels, size_t samples)
{
    if (!text)
        return 1;
    if (!strncmp(text, "ImageJ=", 7)) {
        read_imagej_labels(labels, text);
        return 1;
    }
    if (!strstr(text, "<OME"))
        return 1;
    labels->channel = calloc(channels, sizeof *labels->channel);
    labels->channels = labels->channel ? channels : 0;
    read_ome_labels(labels, text, samples);
    return labels->channel != NULL;
}
