/* Names of channels and units in files. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "volume/io/stored.h"

/* The bytes of the character that begins here and ends before `size`; 0: it is invalid or not
 * printable. */
static size_t letter_bytes(const uint8_t *text, size_t size)
{
    const uint8_t first = text[0];
    if (first < 0x80)
        return first >= ' ' && first != 0x7f;
    const size_t bytes = first >= 0xc2 && first < 0xe0   ? 2
                         : first >= 0xe0 && first < 0xf0 ? 3
                         : first >= 0xf0 && first < 0xf5 ? 4
                                                         : 0;
    if (!bytes || bytes > size)
        return 0;
    for (size_t i = 1; i < bytes; i++)
        if ((text[i] & 0xc0) != 0x80)
            return 0;
    /* Refuses overlong forms, halves of surrogate pairs, codes above U+10FFFF and control codes. */
    const unsigned two = (unsigned)first << 8 | text[1];
    const int odd = (two >= 0xe080 && two < 0xe0a0) || (two >= 0xeda0 && two < 0xee00) ||
                    (two >= 0xf080 && two < 0xf090) || two >= 0xf490 ||
                    (two >= 0xc280 && two < 0xc2a0);
    return odd ? 0 : bytes;
}

void cvol_labels_set_name(cvol_channel_label *channel, const char *text, size_t size)
{
    size_t kept = 0;
    memset(channel->name, 0, sizeof channel->name);
    for (size_t at = 0, bytes; at < size; at += bytes) {
        bytes = letter_bytes((const uint8_t *)text + at, size - at);
        if (!bytes)
            return;
        if (at + bytes < sizeof channel->name)
            kept = at + bytes;
        else
            break;
    }
    memcpy(channel->name, text, kept);
}

void cvol_labels_set_unit(cvol_labels *labels, const char *text, size_t size)
{
    static const char *const names[][2] = {
        {"s", "s"},          {"sec", "s"},          {"seconds", "s"},
        {"second", "s"},     {"ms", "ms"},          {"msec", "ms"},
        {"us", "us"},        {"\xc2\xb5s", "us"},   {"\xce\xbcs", "us"},
        {"ns", "ns"},        {"min", "min"},        {"minutes", "min"},
        {"h", "h"},          {"hour", "h"},         {"hours", "h"},
        {"d", "d"},          {"day", "d"},          {"days", "d"},
        {"minute", "min"},   {"millisecond", "ms"}, {"microsecond", "us"},
        {"nanosecond", "ns"}};
    memset(labels->time_unit, 0, sizeof labels->time_unit);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strlen(names[i][0]) == size && !memcmp(names[i][0], text, size))
            memcpy(labels->time_unit, names[i][1], strlen(names[i][1]));
}

enum { UNIT_BYTES = sizeof((cvol_grid *)0)->unit };

static void take_as_latin(char unit[UNIT_BYTES])
{
    char given[UNIT_BYTES];
    size_t size = 0;
    memcpy(given, unit, sizeof given);
    for (size_t i = 0; given[i] && size + 2 < UNIT_BYTES; i++) {
        const uint8_t c = (uint8_t)given[i];
        if (c >= 0xa0) {
            unit[size++] = (char)(0xc0 | c >> 6);
            unit[size++] = (char)(0x80 | (c & 0x3f));
        } else {
            unit[size++] = (char)(c < ' ' || c > '~' ? '?' : c);
        }
    }
    unit[size] = '\0';
}

void cvol_labels_repair_unit(char unit[UNIT_BYTES])
{
    const size_t size = strlen(unit);
    size_t whole = 0, letter;
    while (whole < size && (letter = letter_bytes((const uint8_t *)unit + whole, size - whole)) > 0)
        whole += letter;
    const int is_cut = size == UNIT_BYTES - 1 && size - whole < 4 && (uint8_t)unit[whole] >= 0xc2;
    if (is_cut)
        unit[whole] = '\0';
    else if (whole < size)
        take_as_latin(unit);
}

int cvol_labels_set_colours(cvol_labels *labels, size_t channels)
{
    static const char *const names[] = {"red", "green", "blue", "alpha"};
    if (channels != 3 && channels != 4)
        return 1;
    cvol_channel_label *channel = calloc(channels, sizeof *channel);
    if (!channel)
        return 0;
    for (size_t c = 0; c < channels; c++) {
        cvol_labels_set_name(&channel[c], names[c], strlen(names[c]));
        channel[c].has_colour = 1;
        if (c < 3)
            channel[c].colour[c] = 1; /* alpha is not a colour */
    }
    free(labels->channel);
    labels->channel = channel;
    labels->channels = channels;
    labels->are_colours = 1;
    return 1;
}

int cvol_labels_append_names(cvol_context *context, const cvol_labels *labels, int code)
{
    char asks[CVOL_MESSAGE_BYTES], names[300];
    size_t length = 0;
    for (size_t c = 0; c < labels->channels; c++) {
        const char *name = labels->channel[c].name;
        if (!name[0] || length + strlen(name) + 16 > sizeof names)
            return code;
        length += (size_t)snprintf(names + length, sizeof names - length, "%s%zu: %s",
                                   c ? ", " : "", c, name);
    }
    if (!length)
        return code;
    snprintf(asks, sizeof asks, "%s", cvol_context_message(context));
    return cvol_fail(context, code, "%s (%s)", asks, names);
}
