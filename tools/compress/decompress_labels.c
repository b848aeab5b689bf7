/* cvol decompress into a segmentation of 3D Slicer: an NRRD file whose header lists the segments.
 */
#include <stdlib.h>
#include <string.h>

#include "tools/compress/decompress.h"
#include "tools/labels/labels.h"

/* More are samples of a scan. */
#define SEGMENTS_MAX 4096

/* *out: the samples of the part; the caller frees them, after a failure too. */
static int decode(cvol_context *context, cvol_volume **out, const part *p)
{
    cvol_array *array = NULL;
    int code = cvol_volume_create(context, out, &p->grid);
    if (!code)
        code = open_slab(context, &array, p, p->begin[2], p->end[2]);
    if (!code)
        code = cvol_array_evaluate_box(context, (*out)->data, array, p->begin, p->end);
    cvol_array_free(array);
    return code;
}

/* A label of the file without a name is "Segment 3". *names holds the names that are made up. */
enum { NAME_BYTES = 24 };

static size_t fill_segments(cvol_label *list, char (*names)[NAME_BYTES], const label_values *values,
                            const label_table *table)
{
    size_t count = 0;
    for (size_t i = 0; i < values->count; i++) {
        const int value = values->values[i];
        const label_entry *known = find_label(table, value);
        cvol_label *label = &list[count];
        if (value == values->background)
            continue;
        snprintf(names[count], sizeof *names, "Segment %d", value);
        label->value = value;
        label->name = known && known->name[0] ? known->name : names[count];
        if (known && known->has_colour)
            memcpy(label->rgb, known->rgb, sizeof label->rgb);
        else
            cvol_label_get_colour(label->rgb, value);
        count++;
    }
    return count;
}

static int open_listed(cvol_context *context, cvol_volume_writer **out, const part *p,
                       const char *out_path, const label_values *values, const label_table *table)
{
    if (values->count > SEGMENTS_MAX)
        return report_error(EXIT_FAILED,
                            "%s: has %zu different values, and a segmentation has at most %d",
                            p->path, values->count, SEGMENTS_MAX);
    cvol_label *list = calloc(values->count, sizeof *list);
    char(*names)[NAME_BYTES] = calloc(values->count, sizeof *names);
    int status = EXIT_DONE;
    if (!list || !names)
        status = report_error(EXIT_FAILED, "%s: not enough memory for the labels", p->path);
    else {
        const size_t count = fill_segments(list, names, values, table);
        const int code = cvol_volume_writer_open_labels(context, out, out_path, &p->grid, list,
                                                        count);
        status = code ? report_context_error(context, code, NULL) : EXIT_DONE;
    }
    free(list);
    free(names);
    return status;
}

int open_segments(cvol_context *context, cvol_volume_writer **out, const part *p,
                  const char *out_path)
{
    cvol_volume *volume = NULL;
    label_values values = {0};
    label_table table = {0};
    if (!p->is_exact)
        return report_error(
            EXIT_FAILED,
            "%s: is not lossless, so its samples are no labels: compress the labels "
            "with --labels yes",
            p->path);
    const int code = decode(context, &volume, p);
    int status = code ? report_context_error(context, code, NULL) : EXIT_DONE;
    if (!status)
        status = count_labels(&values, volume, p->path);
    cvol_volume_free(volume);
    if (!status)
        status = read_labels(&table, NULL, p->path);
    if (!status)
        status = open_listed(context, out, p, out_path, &values, &table);
    free_labels_table(&table);
    free_values(&values);
    return status;
}
