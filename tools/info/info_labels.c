/* The labels of a volume, as cvol info lists them. */
#include <stdlib.h>
#include <string.h>

#include "tools/labels/labels.h"

/* A .cvol file that needs fewer bits for a sample, without loss, may hold labels. */
#define LABEL_BITS 1
/* More values are not listed. */
#define LISTED_MOST 4096

static int has_whole_samples(const input *in)
{
    cvol_array_info info;
    cvol_array_get_info(&info, in->array);
    return is_exact(info.psnr_db) && !in->level && !in->cut &&
           cvol_type_is_integer(cvol_array_grid(in->array)->type);
}

int check_whole_samples(const input *in, const char *path)
{
    if (!in->array || has_whole_samples(in))
        return EXIT_DONE;
    if (!cvol_type_is_integer(cvol_array_grid(in->array)->type))
        return report_error(EXIT_MISUSED, "%s: its samples are not whole numbers, so no labels",
                            path);
    return report_error(EXIT_MISUSED, "%s: its samples are not exact, so no labels: %s", path,
                        in->level ? "leave out --level"
                                  : "compress the original with --labels yes");
}

int may_be_labels(cvol_context *context, const input *in, int least)
{
    cvol_histogram h;
    const double samples = (double)cvol_grid_samples(cvol_array_grid(in->array));
    return has_whole_samples(in) && 8 * (double)in->file_bytes < LABEL_BITS * samples &&
           !cvol_array_compute_histogram(context, &h, in->array) && h.integers &&
           (h.distinct > least || !h.distinct);
}

int find_label_kind(cvol_context *context, int *out, const cvol_volume *volume, const char *path)
{
    cvol_histogram histogram;
    cvol_transfer *transfer = NULL;
    cvol_kind kind = CVOL_KIND_GENERAL;
    int code = cvol_volume_compute_is_labels(context, out, volume, path);
    if (code)
        return report_context_error(context, code, code == CVOL_ERROR_MEMORY ? path : NULL);
    *out = *out && has_label_range(volume);
    if (*out || !cvol_type_is_integer(volume->grid.type))
        return EXIT_DONE;
    code = cvol_volume_compute_histogram(context, &histogram, volume);
    if (!code)
        code = cvol_transfer_create_auto(context, &transfer, &kind, NULL, &histogram, &volume->grid,
                                         1);
    cvol_transfer_free(transfer);
    *out = kind == CVOL_KIND_LABELS && has_label_range(volume);
    return code ? report_context_error(context, code, path) : EXIT_DONE;
}

/* Decodes the samples if they may be labels; in->volume stays NULL if not. Exit status. */
static int find_samples(cvol_context *context, input *in, const char *file, const char *path)
{
    if (!in->array)
        return EXIT_DONE;
    if (file && check_whole_samples(in, path))
        return EXIT_MISUSED;
    return file || may_be_labels(context, in, 1) ? need_volume(context, in) : EXIT_DONE;
}

static json_t *make_list(const label_values *values, const label_table *table,
                         const cvol_grid *grid)
{
    json_t *list = json_array();
    const double size = grid->spacing[0] * grid->spacing[1] * grid->spacing[2];
    for (size_t i = 0; i < values->count; i++) {
        const label_entry *known = find_label(table, values->values[i]);
        json_t *entry = json_pack("{s:i, s:o, s:I, s:f}", "value", values->values[i], "name",
                                  json_text(known ? known->name : ""), "samples",
                                  (json_int_t)values->samples[i], "volume",
                                  size * (double)values->samples[i]);
        json_array_append_new(list, entry);
    }
    return list;
}

int list_labels_of(cvol_context *context, json_t **out, input *in, const char *file,
                   const char *path)
{
    label_table table = {0};
    label_values values = {0};
    *out = NULL;
    int status = find_samples(context, in, file, path);
    int are_labels = file != NULL;
    if (!status && in->volume && !are_labels)
        status = find_label_kind(context, &are_labels, in->volume, path);
    if (status || !in->volume || !are_labels)
        return status;
    status = read_labels(&table, file, path);
    if (!status)
        status = count_labels(&values, in->volume, path);
    if (!status && values.count <= LISTED_MOST)
        *out = make_list(&values, &table, &in->volume->grid);
    free_values(&values);
    free_labels_table(&table);
    return status;
}

void print_label_list(const json_t *list, const cvol_grid *grid)
{
    printf("  %-16s %zu\n", "labels", json_array_size(list));
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *entry = json_array_get(list, i);
        printf("    %-14lld %s%s%lld samples, %.5g %s%s\n",
               (long long)json_integer_value(json_object_get(entry, "value")),
               json_string_value(json_object_get(entry, "name")),
               json_string_length(json_object_get(entry, "name")) ? ", " : "",
               (long long)json_integer_value(json_object_get(entry, "samples")),
               json_number_value(json_object_get(entry, "volume")), grid->unit,
               grid->unit[0] ? "^3" : "cubic units");
    }
}
