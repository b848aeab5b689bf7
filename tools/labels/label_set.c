/* Labels of a picture: chosen ones, numbered from 1 without gaps.
 *
 * Engines find colours in a table over the range of values, and interpolate between samples. With
 * numbers without gaps each of 255 labels has several entries of that table, however far apart the
 * labels of the file are, and labels that are not drawn are not passed on the way. */
#include <stdlib.h>
#include <string.h>

#include "tools/labels/labels.h"

/* As cvol_transfer_create_auto: opacity, and values this near to a label have its colour. */
#define OPACITY 0.5
#define REACH 0.04
/* The part of the numbers that one label must cover at least, for a few entries of the table. */
#define REACH_SHARE 5e-4

/* ---- missing samples ---- */

int clear_missing_labels(input *in)
{
    const size_t begin[3] = {0, 0, 0};
    cvol_array_info info;
    if (!in->array || !in->volume || !cvol_type_is_integer(in->volume->grid.type))
        return EXIT_DONE;
    cvol_array_get_info(&info, in->array);
    if (!info.missing_samples)
        return EXIT_DONE;
    const size_t count = cvol_grid_samples(&in->volume->grid),
                 size = cvol_type_size(in->volume->grid.type);
    uint8_t *mask = malloc(count);
    if (!mask)
        return report_error(EXIT_FAILED, "not enough memory for a mask of %zu samples", count);
    cvol_array_evaluate_mask(mask, in->array, begin, in->volume->grid.dims);
    for (size_t i = 0; i < count; i++)
        if (mask[i])
            memset((uint8_t *)in->volume->data + i * size, 0, size);
    free(mask);
    return EXIT_DONE;
}

/* ---- numbers ---- */

/* Gives the chosen values their facts, in rising order. Exit status. */
static int fill_set(label_set *out, const label_values *values, const uint8_t *chosen,
                    const label_table *table, const char *option, const char *path)
{
    size_t count = 0;
    for (size_t i = 0; i < values->count; i++)
        count += chosen[i];
    if (count > LABELS_DRAWN_MAX)
        return report_error(EXIT_MISUSED,
                            "%s: has %zu labels, and a picture shows at most %d: choose some with "
                            "%s",
                            path, count, LABELS_DRAWN_MAX, option);
    for (size_t i = 0; i < values->count; i++) {
        if (!chosen[i])
            continue;
        const label_entry *known = find_label(table, values->values[i]);
        label_entry *entry = &out->entries[out->count++];
        *entry = known ? *known : (label_entry){.value = values->values[i]};
        if (!entry->has_colour)
            cvol_label_get_colour(entry->rgb, entry->value);
    }
    return EXIT_DONE;
}

/* The number of a label in the set; 0: it is not in it. */
static uint8_t number_of(const label_set *set, int value)
{
    size_t from = 0, to = set->count;
    while (from < to) {
        const size_t middle = (from + to) / 2;
        if (set->entries[middle].value == value)
            return (uint8_t)(middle + 1);
        if (set->entries[middle].value < value)
            from = middle + 1;
        else
            to = middle;
    }
    return 0;
}

/* Exit status. */
static int renumber(cvol_context *context, cvol_volume **volume, const label_set *set)
{
    cvol_grid grid = (*volume)->grid;
    cvol_volume *out;
    grid.type = CVOL_UINT8;
    grid.value_scale = 1;
    grid.value_offset = 0;
    const int code = cvol_volume_create(context, &out, &grid);
    if (code)
        return report_context_error(context, code, NULL);
    const size_t count = cvol_grid_samples(&grid);
    uint8_t *to = out->data, number = 0;
    int last = label_at(*volume, 0);
    number = number_of(set, last);
    for (size_t i = 0; i < count; i++) {
        const int value = label_at(*volume, i);
        if (value != last)
            number = number_of(set, value);
        last = value;
        to[i] = number;
    }
    cvol_volume_free(*volume);
    *volume = out;
    return EXIT_DONE;
}

int number_labels(cvol_context *context, label_set *out, cvol_volume **volume,
                  const label_choice *choice, const char *path)
{
    label_table table;
    label_values values = {0};
    uint8_t *chosen = NULL;
    out->count = 0;
    int status = read_labels(&table, choice->file, path);
    if (!status)
        status = count_labels(&values, *volume, path);
    if (!status && !(chosen = calloc(values.count, 1)))
        status = report_error(EXIT_FAILED, "not enough memory");
    if (!status)
        status = choose_label_values(chosen, &values, &table, choice, path);
    if (!status)
        status = fill_set(out, &values, chosen, &table, choice->option, path);
    if (!status)
        status = renumber(context, volume, out);
    free(chosen);
    free_values(&values);
    free_labels_table(&table);
    return status;
}

/* ---- colours ---- */

int create_label_transfer(cvol_context *context, cvol_transfer **out, const label_set *set)
{
    cvol_transfer_point points[4 * LABELS_DRAWN_MAX + 1] = {{.value = -1}};
    const double least = REACH_SHARE * (double)set->count,
                 reach = set->count == 1 ? 0.5 /* half way to what is not drawn */
                         : least > REACH ? least
                                         : REACH;
    size_t count = 1;
    for (size_t i = 0; i < set->count; i++)
        for (int k = 0; k < 4; k++) {
            const double *rgb = set->entries[i].rgb;
            points[count++] = (cvol_transfer_point){(double)(i + 1) + (k < 2 ? -reach : reach),
                                                    rgb[0], rgb[1], rgb[2],
                                                    k == 1 || k == 2 ? OPACITY : 0};
        }
    return cvol_transfer_create(context, out, points, count);
}

json_t *describe_labels(const label_set *set)
{
    json_t *list = json_array();
    for (size_t i = 0; i < set->count; i++)
        json_array_append_new(list, json_pack("{s:i, s:o, s:o}", "value", set->entries[i].value,
                                              "name", json_text(set->entries[i].name), "colour",
                                              json_triple(set->entries[i].rgb)));
    return list;
}
