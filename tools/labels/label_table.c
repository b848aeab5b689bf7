/* Names and colours of labels, from text files:
 *
 *     ITK-SNAP         3  255 0 0  1 1 1  "Left ventricle"
 *     FreeSurfer       3  Left-Cerebral-Cortex  205 62 78 0
 *     3D Slicer        3  left_ventricle  255 0 0 255
 *
 * one label a line, # before a comment; from the header of an NRRD file of segments, as 3D Slicer
 * writes it: Segment0_LabelValue:=3, Segment0_Name:=Left ventricle, Segment0_Color:=1 0 0; from the
 * attributes of a .cvol file (label_attributes.c); and what cvol_label_list_read finds.
 */
#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/labels/labels.h"

enum { LINE_MOST = 4096 };

/* ---- tables ---- */

static int compare_entries(const void *a, const void *b)
{
    const label_entry *p = a, *q = b;
    return p->value < q->value ? -1 : p->value > q->value;
}

label_entry *add_label_entry(label_table *table)
{
    const size_t count = table->count;
    if (!(count & (count - 1))) { /* full: 0 or a power of two */
        label_entry *more = realloc(table->entries, (count ? 2 * count : 1) * sizeof *more);
        if (!more)
            return NULL;
        table->entries = more;
    }
    memset(&table->entries[count], 0, sizeof *table->entries);
    table->count++;
    return &table->entries[count];
}

void free_labels_table(label_table *table)
{
    free(table->entries);
    *table = (label_table){0};
}

const label_entry *find_label(const label_table *table, int value)
{
    const label_entry key = {.value = value};
    return table->count ? bsearch(&key, table->entries, table->count, sizeof key, compare_entries)
                        : NULL;
}

/* Copies a name without the spaces and the quotes around it. */
static void set_name(label_entry *entry, const char *text, size_t length)
{
    while (length && (isspace((unsigned char)*text) || *text == '"')) {
        text++;
        length--;
    }
    while (length && (isspace((unsigned char)text[length - 1]) || text[length - 1] == '"'))
        length--;
    if (length >= LABEL_NAME)
        for (length = LABEL_NAME - 1; length && ((unsigned char)text[length] & 0xc0) == 0x80;)
            length--; /* not inside a character of UTF-8 */
    memcpy(entry->name, text, length);
    entry->name[length] = '\0';
}

/* Reads an integer and moves on; 0 if there is none. */
static int take_integer(int *out, const char **at)
{
    char *end;
    const long value = strtol(*at, &end, 10);
    if (end == *at || value < INT_MIN || value > INT_MAX || (*end && !isspace((unsigned char)*end)))
        return 0;
    *out = (int)value;
    *at = end;
    return 1;
}

/* Reads `count` numbers, of which the first three are a colour of this range; 0 if there are not so
 * many, or one is no part of a colour. */
static int take_colour(label_entry *entry, const char **at, int count, double range)
{
    for (int k = 0; k < count; k++) {
        char *end;
        const double value = strtod(*at, &end);
        if (end == *at || (k < 3 && !(value >= 0 && value <= range)))
            return 0;
        if (k < 3)
            entry->rgb[k] = value / range;
        *at = end;
    }
    entry->has_colour = 1;
    return 1;
}

/* ---- files of labels ---- */

/* Reads one line; 0: it is none of the formats. */
static int read_line(label_entry *entry, const char *line)
{
    const char *at = line;
    if (!take_integer(&entry->value, &at))
        return 0;
    const char *const rest = at;
    if (take_colour(entry, &at, 6, 255)) { /* ITK-SNAP; a name of its own kind follows */
        set_name(entry, at, strlen(at));
        return entry->name[0] != '\0';
    }
    at = rest + strspn(rest, " \t");
    const char *end = *at == '"' ? strchr(at + 1, '"') : at + strcspn(at, " \t\r\n");
    if (!end || end == at)
        return 0;
    end += *end == '"';
    set_name(entry, at, (size_t)(end - at));
    return take_colour(entry, &end, 3, 255);
}

static int fail_memory(const char *path)
{
    return report_error(EXIT_FAILED, "%s: not enough memory for the labels", path);
}

static int read_file(label_table *out, FILE *file, const char *path)
{
    char line[LINE_MOST];
    for (int number = 1; fgets(line, sizeof line, file); number++) {
        const char *at = line + strspn(line, " \t\r\n");
        if (!*at || *at == '#')
            continue;
        label_entry one = {0}, *entry;
        if (!read_line(&one, at))
            return report_error(EXIT_FAILED,
                                "%s, line %d: is no label of ITK-SNAP, FreeSurfer or 3D Slicer, as "
                                "in 3 left_ventricle 255 0 0 255",
                                path, number);
        if (out->count >= LABELS_MOST)
            return report_error(EXIT_FAILED, "%s: has more than %d labels", path, LABELS_MOST);
        if (!(entry = add_label_entry(out)))
            return fail_memory(path);
        *entry = one;
    }
    if (ferror(file))
        return report_error(EXIT_FAILED, "%s: %s", path, strerror(errno));
    return out->count ? EXIT_DONE : report_error(EXIT_FAILED, "%s: has no label", path);
}

/* ---- headers of segments ---- */

/* The text after "Segment<number>_<key>:=", or NULL; sets *number. */
static const char *segment_field(int *number, const char *line, const char *key)
{
    char *end;
    if (strncmp(line, "Segment", 7) || !isdigit((unsigned char)line[7]))
        return NULL;
    const long value = strtol(line + 7, &end, 10);
    const size_t length = strlen(key);
    if (value >= LABELS_MOST || *end != '_' || strncmp(end + 1, key, length) ||
        strncmp(end + 1 + length, ":=", 2))
        return NULL;
    *number = (int)value;
    return end + 1 + length + 2;
}

/* In values of NRRD keys "\\n" is a line end, which becomes a blank, and "\\\\" a backslash. */
static void set_escaped_name(label_entry *entry, const char *text)
{
    char plain[LINE_MOST];
    size_t length = 0;
    for (; *text && length < sizeof plain; text++) {
        const int is_escape = text[0] == '\\' && (text[1] == 'n' || text[1] == '\\');
        text += is_escape;
        plain[length++] = is_escape && *text == 'n' ? ' ' : *text;
    }
    set_name(entry, plain, length);
}

/* A segment of a header, in the order of the file. */
typedef struct segment {
    int number, has_value;
    label_entry entry;
} segment;

static segment *segment_of(segment **list, size_t *count, int number)
{
    for (size_t i = *count; i > 0; i--)
        if ((*list)[i - 1].number == number)
            return &(*list)[i - 1];
    segment *more = realloc(*list, (*count + 1) * sizeof *more);
    if (!more)
        return NULL;
    *list = more;
    more[*count] = (segment){.number = number};
    return &more[(*count)++];
}

/* 0 without memory. */
static int read_segment_line(segment **list, size_t *count, const char *line)
{
    static const char *const keys[] = {"LabelValue", "Name", "Color"};
    for (int k = 0; k < 3; k++) {
        int number;
        const char *text = segment_field(&number, line, keys[k]);
        if (!text)
            continue;
        segment *of = segment_of(list, count, number);
        if (!of)
            return 0;
        if (k == 0)
            of->has_value = take_integer(&of->entry.value, &text);
        else if (k == 1)
            set_escaped_name(&of->entry, text);
        else
            take_colour(&of->entry, &text, 3, 1);
    }
    return 1;
}

/* Nothing if the file is no NRRD file, or has no segments. Exit status. */
static int read_segments(label_table *out, FILE *file, const char *path)
{
    char line[LINE_MOST];
    segment *list = NULL;
    size_t count = 0;
    int has_memory = 1;
    const int is_nrrd = fgets(line, sizeof line, file) && !strncmp(line, "NRRD", 4);
    while (is_nrrd && has_memory && fgets(line, sizeof line, file) &&
           strspn(line, "\r\n") != strlen(line))
        if (count < LABELS_MOST)
            has_memory = read_segment_line(&list, &count, line);
    const int reason = ferror(file) ? errno : 0;
    for (size_t i = 0; i < count && has_memory; i++) {
        label_entry *entry = list[i].has_value ? add_label_entry(out) : NULL;
        if (entry)
            *entry = list[i].entry;
        else
            has_memory = !list[i].has_value;
    }
    free(list);
    if (reason && reason != EISDIR)
        return report_error(EXIT_FAILED, "%s: %s", path, strerror(reason));
    return has_memory ? EXIT_DONE : fail_memory(path);
}

/* Those that the library finds in files of other formats. Exit status. */
static int read_stated(label_table *out, const char *path)
{
    cvol_context *context = cvol_context_create();
    cvol_label *labels = NULL;
    size_t count = 0;
    if (!context)
        return fail_memory(path);
    const int code = cvol_label_list_read(context, &labels, &count, path);
    int status = code ? report_context_error(context, code, NULL) : EXIT_DONE;
    for (size_t i = 0; i < count && !status; i++) {
        label_entry *entry = add_label_entry(out);
        if (!entry) {
            status = fail_memory(path);
            break;
        }
        entry->value = labels[i].value;
        snprintf(entry->name, sizeof entry->name, "%s", labels[i].name);
        entry->has_colour = labels[i].rgb[0] >= 0;
        if (entry->has_colour)
            memcpy(entry->rgb, labels[i].rgb, sizeof entry->rgb);
    }
    free(labels);
    cvol_context_free(context);
    return status;
}

int read_labels(label_table *out, const char *file, const char *path)
{
    *out = (label_table){0};
    FILE *stream = fopen(file ? file : path, "rb");
    if (!stream && !file && (errno == ENOENT || errno == ENOTDIR)) /* FILE.h5:/a/dataset */
        return EXIT_DONE;
    if (!stream)
        return report_error(EXIT_FAILED, "%s: cannot be read: %s", file ? file : path,
                            strerror(errno));
    int status = EXIT_DONE, is_zarr = 0;
    if (file)
        status = read_file(out, stream, file);
    else if (is_cvol(path))
        status = read_label_attributes(out, path);
    else {
        status = read_label_zarr(out, &is_zarr, path);
        if (!status && !is_zarr)
            status = read_segments(out, stream, path);
        if (!status && !is_zarr && !out->count)
            status = read_stated(out, path);
    }
    fclose(stream);
    if (out->count)
        qsort(out->entries, out->count, sizeof *out->entries, compare_entries);
    return status;
}
