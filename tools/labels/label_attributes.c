/* Labels in the attributes of a .cvol file: a JSON object with
 * "labels": [{"value": 3, "name": "Left ventricle", "colour": [1, 0, 0]}, ...], in which name and
 * colour may be missing. */
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "tools/labels/labels.h"

static const char key[] = "labels";

/* ---- writing ---- */

static json_t *describe_table(const label_table *table)
{
    json_t *list = json_array();
    for (size_t i = 0; i < table->count; i++) {
        const label_entry *entry = &table->entries[i];
        json_t *one = json_pack("{s:i}", "value", entry->value);
        if (entry->name[0])
            json_object_set_new(one, "name", json_text(entry->name));
        if (entry->has_colour)
            json_object_set_new(one, "colour", json_triple(entry->rgb));
        json_array_append_new(list, one);
    }
    return list;
}

/* Adds the table, unless the attributes are no object, or have labels that are to stay. */
static char *add_table(const char *attributes, const label_table *table, int replaces)
{
    json_t *object = attributes ? json_loads(attributes, JSON_DECODE_ANY, NULL) : json_object();
    char *text = NULL;
    if (json_is_object(object) && (replaces || !json_object_get(object, key))) {
        json_object_set_new(object, key, describe_table(table));
        text = json_dumps(object, JSON_COMPACT | JSON_REAL_PRECISION(10));
    }
    json_decref(object);
    return text;
}

int add_label_attributes(char **attributes, const char *file, const char *path)
{
    label_table table;
    int status = read_labels(&table, file, path);
    char *text = !status && table.count ? add_table(*attributes, &table, file != NULL) : NULL;
    if (!status && json_lacks_memory()) { /* the text may lack labels */
        status = report_error(EXIT_FAILED, "%s: not enough memory for the labels", path);
        free(text);
    } else if (text) {
        free(*attributes);
        *attributes = text;
    }
    free_labels_table(&table);
    return status;
}

/* ---- reading ---- */

/* 0 without memory. */
static int read_entry(label_table *out, const json_t *one)
{
    const json_t *value = json_object_get(one, "value"), *colour = json_object_get(one, "colour");
    const char *name = json_string_value(json_object_get(one, "name"));
    if (!json_is_integer(value) || json_integer_value(value) < INT_MIN ||
        json_integer_value(value) > INT_MAX || out->count >= LABELS_MOST)
        return 1;
    label_entry *entry = add_label_entry(out);
    if (!entry)
        return 0;
    entry->value = (int)json_integer_value(value);
    if (name)
        snprintf(entry->name, sizeof entry->name, "%s", name);
    entry->has_colour = json_array_size(colour) == 3;
    for (size_t c = 0; c < 3 && entry->has_colour; c++) {
        entry->rgb[c] = json_number_value(json_array_get(colour, c));
        entry->has_colour = entry->rgb[c] >= 0 && entry->rgb[c] <= 1;
    }
    return 1;
}

static int read_list(label_table *out, const char *attributes)
{
    json_t *object = json_loads(attributes, JSON_DECODE_ANY, NULL);
    const json_t *list = json_object_get(object, key);
    int done = !json_lacks_memory();
    for (size_t i = 0; done && i < json_array_size(list); i++)
        done = read_entry(out, json_array_get(list, i));
    json_decref(object);
    return done;
}

int read_label_attributes(label_table *out, const char *path)
{
    static const size_t begin[3] = {0, 0, 0}, end[3] = {1, 1, 1};
    cvol_context *context = cvol_context_create();
    cvol_array *array = NULL;
    const int code = context ? cvol_array_read_part(
                                   context, &array, NULL, path,
                                   CVOL_FILE_PART(.begin = begin, .end = end, .cut = 1))
                             : CVOL_ERROR_MEMORY;
    int status = EXIT_DONE;
    if (context && (code == CVOL_ERROR_IO || code == CVOL_ERROR_MEMORY))
        status = report_context_error(context, code, code == CVOL_ERROR_MEMORY ? path : NULL);
    else if (!context || (!code && cvol_array_attributes(array) &&
                          !read_list(out, cvol_array_attributes(array))))
        status = report_error(EXIT_FAILED, "%s: not enough memory for the labels", path);
    cvol_array_free(array);
    cvol_context_free(context);
    return status;
}
