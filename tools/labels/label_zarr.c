/* Labels of an image of OME-Zarr: the attribute image-label of its group, with "colors":
 * [{"label-value": 1, "rgba": [255, 0, 0, 255]}, ...] and "properties": [{"label-value": 1, "name":
 * "cell"}, ...], in which the name may also be a "class". */
#define _GNU_SOURCE
#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "tools/labels/labels.h"

static int fail_memory(const char *path)
{
    return report_error(EXIT_FAILED, "%s: not enough memory for the labels", path);
}

/* ---- files ---- */

/* Parses a file; *root NULL: it does not exist, or is not JSON. Exit status. */
static int load(json_t **root, const char *path)
{
    FILE *file = fopen(path, "rb");
    *root = NULL;
    if (!file && (errno == ENOENT || errno == ENOTDIR || errno == ENAMETOOLONG || errno == EACCES))
        return EXIT_DONE;
    if (!file)
        return report_error(EXIT_FAILED, "%s: %s", path, strerror(errno));
    errno = 0;
    *root = json_loadf(file, 0, NULL);
    const int reason = ferror(file) ? errno : 0;
    fclose(file);
    if (reason && reason != EISDIR)
        return report_error(EXIT_FAILED, "%s: %s", path, strerror(reason));
    return json_lacks_memory() ? fail_memory(path) : EXIT_DONE;
}

/* The attribute of a folder; *root holds it, and the caller releases it. *mark NULL: there is none.
 * Exit status. */
static int find_mark(const json_t **mark, json_t **root, const char *folder)
{
    static const char *const names[] = {"zarr.json", ".zattrs"};
    int status = EXIT_DONE;
    *root = NULL;
    *mark = NULL;
    for (size_t i = 0; i < 2 && !status && !*mark; i++) {
        char *path;
        json_decref(*root);
        *root = NULL;
        if (asprintf(&path, "%s/%s", folder, names[i]) < 0)
            return fail_memory(folder);
        status = load(root, path);
        free(path);
        const json_t *attributes = i ? *root
                                     : json_object_get(json_object_get(*root, "attributes"), "ome");
        *mark = json_object_get(attributes, "image-label");
    }
    return status;
}

/* ---- labels ---- */

static void read_colour(label_entry *entry, const json_t *rgba)
{
    entry->has_colour = json_array_size(rgba) >= 3;
    for (size_t c = 0; c < 3 && entry->has_colour; c++) {
        entry->rgb[c] = json_number_value(json_array_get(rgba, c)) / 255;
        entry->has_colour = entry->rgb[c] >= 0 && entry->rgb[c] <= 1;
    }
}

static void read_name(label_entry *entry, const json_t *item)
{
    const char *name = json_string_value(json_object_get(item, "name"));
    if (!name)
        name = json_string_value(json_object_get(item, "class"));
    if (name)
        snprintf(entry->name, sizeof entry->name, "%s", name);
}

/* An item of a list, and its place: colours before names. */
typedef struct part {
    int value, is_colour;
    size_t order;
    const json_t *item;
} part;

static int compare_parts(const void *a, const void *b)
{
    const part *p = a, *q = b;
    if (p->value != q->value)
        return p->value < q->value ? -1 : 1;
    return p->order < q->order ? -1 : p->order > q->order;
}

/* Appends the items that have a label-value; the array has room for them. */
static void add_parts(part *parts, size_t *count, const json_t *list, int are_colours)
{
    size_t i;
    const json_t *item;
    json_array_foreach(list, i, item)
    {
        const json_t *value = json_object_get(item, "label-value");
        const json_int_t number = json_integer_value(value);
        if (!json_is_integer(value) || number < INT_MIN || number > INT_MAX)
            continue;
        parts[*count] = (part){(int)number, are_colours, *count, item};
        ++*count;
    }
}

/* Adds one entry for the parts of each value, which follow each other. Exit status. */
static int join_parts(label_table *out, const part *parts, size_t count, const char *path)
{
    label_entry *entry = NULL;
    for (size_t i = 0; i < count; i++) {
        if (!i || parts[i].value != parts[i - 1].value) {
            if (out->count >= LABELS_MOST)
                return report_error(EXIT_FAILED, "%s: has more than %d labels", path, LABELS_MOST);
            if (!(entry = add_label_entry(out)))
                return fail_memory(path);
            entry->value = parts[i].value;
        }
        if (parts[i].is_colour)
            read_colour(entry, json_object_get(parts[i].item, "rgba"));
        else
            read_name(entry, parts[i].item);
    }
    return EXIT_DONE;
}

static int read_mark(label_table *out, const json_t *mark, const char *path)
{
    const json_t *colours = json_object_get(mark, "colors");
    const json_t *names = json_object_get(mark, "properties");
    size_t count = 0;
    part *parts = malloc((json_array_size(colours) + json_array_size(names) + 1) * sizeof *parts);
    if (!parts)
        return fail_memory(path);
    add_parts(parts, &count, colours, 1);
    add_parts(parts, &count, names, 0);
    qsort(parts, count, sizeof *parts, compare_parts);
    const int status = join_parts(out, parts, count, path);
    free(parts);
    return status;
}

/* The folder above; *above NULL: there is none. Exit status. */
static int find_above(char **above, const char *path)
{
    *above = NULL;
    char *real = realpath(path, NULL);
    if (!real)
        return errno == ENOMEM ? fail_memory(path) : EXIT_DONE;
    char *slash = strrchr(real, '/');
    if (slash == real) {
        free(real);
        return EXIT_DONE;
    }
    *slash = '\0';
    *above = real;
    return EXIT_DONE;
}

int read_label_zarr(label_table *out, int *found, const char *path)
{
    json_t *root;
    const json_t *mark;
    char *above = NULL;
    int status = find_mark(&mark, &root, path);
    if (!status && !mark)
        status = find_above(&above, path);
    if (!status && above) { /* the group of a level */
        json_decref(root);
        status = find_mark(&mark, &root, above);
    }
    *found = mark != NULL;
    if (!status && mark)
        status = read_mark(out, mark, path);
    json_decref(root);
    free(above);
    return status;
}
