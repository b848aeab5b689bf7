/* cvol decompress into OME-Zarr or OME-TIFF: all times and channels, with their names. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/compress/decompress.h"

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

int open_image(cvol_context *context, cvol_volume_writer **out, volume_labels *labels,
               const part *p, common_options *common, const char *out_path)
{
    cvol_series_options series = cvol_series_options_defaults();
    const int is_series = kind_of(p->path) == CVOL_FILE_SERIES;
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
    int code = labels->are_colours ? 0 : find_labels_kind(context, &are_labels, p);
    if (!code)
        code = cvol_volume_writer_open_series(context, out, out_path, &p->grid, &series,
                                              are_labels);
    return code ? report_context_error(context, code, NULL) : EXIT_DONE;
}
