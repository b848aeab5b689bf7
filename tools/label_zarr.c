/* Labels of an image of OME-Zarr: the attribute image-label of its group, with "colors":
 * [{"label-value": 1, "rgba": [255, 0, 0, 255]}, ...] and "properties": [{"label-value": 1, "name":
 * "cell"}, ...], in which the name may also be a "class". */
#define _GNU_SOURCE
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "labels.h"

/* The attribute of a folder, in *root, which the caller releases; NULL: there is none. */
static const json_t *find_mark(json_t **root, const char *folder)
{
    static const char *const names[] = {"zarr.json", ".zattrs"};
    *root = NULL;
    for (size_t i = 0; i < 2; i++) {
        char *path;
        json_decref(*root);
        *root = NULL;
        if (asprintf(&path, "%s/%s", folder, names[i]) < 0)
            continue;
        *root = json_load_file(path, 0, NULL);
        free(path);
        const json_t *attributes = i ? *root
                                     : json_object_get(json_object_get(*root, "attributes"), "ome");
        const json_t *mark = json_object_get(attributes, "image-label");
        if (mark)
            return mark;
    }
    return NULL;
}

/* The entry of an item's label-value; NULL: it is none. */
static label_entry *entry_of(label_table *out, const json_t *item)
{
    const json_t *value = json_object_get(item, "label-value");
    const json_int_t number = json_integer_value(value);
    if (!json_is_integer(value) || number < INT_MIN || number > INT_MAX)
        return NULL;
    for (size_t i = 0; i < out->count; i++)
        if (out->entries[i].value == (int)number)
            return &out->entries[i];
    label_entry *entry = add_label_entry(out);
    if (entry)
        entry->value = (int)number;
    return entry;
}

static void read_colour(label_entry *entry, const json_t *rgba)
{
    entry->has_colour = json_array_size(rgba) >= 3;
    for (size_t c = 0; c < 3 && entry->has_colour; c++) {
        entry->rgb[c] = json_number_value(json_array_get(rgba, c)) / 255;
        entry->has_colour = entry->rgb[c] >= 0 && entry->rgb[c] <= 1;
    }
}

static void read_mark(label_table *out, const json_t *mark)
{
    size_t i;
    const json_t *item;
    json_array_foreach(json_object_get(mark, "colors"), i, item)
    {
        label_entry *entry = entry_of(out, item);
        if (entry)
            read_colour(entry, json_object_get(item, "rgba"));
    }
    json_array_foreach(json_object_get(mark, "properties"), i, item)
    {
        label_entry *entry = entry_of(out, item);
        const char *name = json_string_value(json_object_get(item, "name"));
        if (!name)
            name = json_string_value(json_object_get(item, "class"));
        if (entry && name)
            snprintf(entry->name, sizeof entry->name, "%s", name);
    }
}

int read_label_zarr(label_table *out, const char *path)
{
    json_t *root;
    char *above, *real = realpath(path, NULL);
    char *slash = real ? strrchr(real, '/') : NULL;
    const json_t *mark = find_mark(&root, path);
    above = slash && !mark ? strndup(real, (size_t)(slash - real)) : NULL;
    if (above && above[0]) { /* the group of a level */
        json_decref(root);
        mark = find_mark(&root, above);
    }
    const int is_found = mark != NULL;
    if (is_found)
        read_mark(out, mark);
    json_decref(root);
    free(above);
    free(real);
    return is_found;
}
