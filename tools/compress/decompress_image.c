/* cvol decompress into OME-Zarr or OME-TIFF: all times and channels, with their names. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/compress/decompress.h"
#include "tools/labels/labels.h"

int holds_series(const char *path)
{
    static const char *const endings[] = {".zarr", ".ome.tif", ".ome.tiff"};
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++)
        if (has_ending(path, endings[i]))
            return 1;
    return 0;
}

int choose_volumes(cvol_context *context, common_options *common, part *p)
{
    const cvol_read_options *read = &common->read;
    cvol_file_part chosen = {.size = sizeof(cvol_file_part)};
    if (kind_of(p->path) != CVOL_FILE_SERIES)
        return choose_volume(context, common, p->path, &chosen);
    p->time = read->has_index ? read->index : 0;
    p->channel = read->has_channel ? read->channel : 0;
    return count_volumes(context, common, p->path, &p->times, &p->channels);
}

/* Slices that are enough to recognise labels. */
enum { SLICES_OF_LABELS = 32 };

/* *out: the samples in the middle of the first volume look like labels. */
static int find_labels_kind(cvol_context *context, int *out, const part *p)
{
    const size_t count = p->end[2] - p->begin[2];
    const size_t some = count < SLICES_OF_LABELS ? count : SLICES_OF_LABELS;
    const size_t first = p->begin[2] + (count - some) / 2;
    const size_t from[3] = {p->begin[0], p->begin[1], first};
    const size_t to[3] = {p->end[0], p->end[1], first + some};
    cvol_array *array = NULL;
    cvol_volume *volume = NULL;
    cvol_grid grid = p->grid;
    *out = 0;
    if (!p->is_exact || !cvol_type_is_integer(p->grid.type))
        return 0;
    grid.dims[2] = some;
    int code = cvol_volume_create(context, &volume, &grid);
    if (!code)
        code = open_slab(context, &array, p, first, first + some);
    if (!code)
        code = cvol_array_evaluate_box(context, volume->data, array, from, to);
    if (!code)
        code = cvol_volume_compute_is_labels(context, out, volume, NULL);
    cvol_array_free(array);
    cvol_volume_free(volume);
    return code;
}

/* *out: the names and colours of labels of the file, which has exact whole numbers; the names are
 * those of the table. The caller frees both. Exit status. */
static int list_labels(cvol_label **out, label_table *table, const part *p)
{
    *out = NULL;
    *table = (label_table){0};
    if (!p->is_exact || !cvol_type_is_integer(p->grid.type))
        return EXIT_DONE;
    int status = read_labels(table, NULL, p->path);
    if (status || !table->count)
        return status;
    *out = calloc(table->count, sizeof **out);
    if (!*out)
        return report_error(EXIT_FAILED, "%s: not enough memory for the labels", p->path);
    for (size_t i = 0; i < table->count; i++) {
        const label_entry *entry = &table->entries[i];
        (*out)[i] = (cvol_label){.value = entry->value, .name = entry->name, .rgb = {-1, -1, -1}};
        if (entry->has_colour)
            memcpy((*out)[i].rgb, entry->rgb, sizeof entry->rgb);
    }
    return EXIT_DONE;
}

int open_image(cvol_context *context, cvol_volume_writer **out, volume_labels *labels,
               const part *p, common_options *common, const char *out_path)
{
    cvol_series_options series = cvol_series_options_defaults();
    const int is_series = kind_of(p->path) == CVOL_FILE_SERIES;
    label_table table;
    cvol_label *list;
    int are_labels = 0;
    if (is_series && find_labels(context, labels, common, p->path, p->times, p->channels))
        return EXIT_FAILED;
    if (is_series) {
        series.times = p->times;
        series.channels = p->channels;
        series.time_values = labels->times;
        series.time_unit = labels->unit;
        series.channel_names = (const char *const *)labels->names;
        series.channel_colours = labels->colours;
        series.colours = labels->are_colours;
    }
    series.zarr_format = p->zarr_format;
    const int status = list_labels(&list, &table, p);
    series.labels = list;
    series.label_count = table.count;
    are_labels = list != NULL;
    int code = status || are_labels || labels->are_colours
                   ? 0
                   : find_labels_kind(context, &are_labels, p);
    if (!code && !status)
        code = cvol_volume_writer_open_series(context, out, out_path, &p->grid, &series,
                                              are_labels);
    free(list);
    free_labels_table(&table);
    return status ? status : code ? report_context_error(context, code, NULL) : EXIT_DONE;
}
