/* The labels of a volume. A picture shows their shape, coloured by the label at its depth
 * (cvol/look.h). */
#include "viewer/volumes/labels.h"

#include <math.h>
#include <stdlib.h>

#include "tools/overlay/overlay.h"
#include "viewer/base/answer.h"

/* Labels take fewer bits per sample. */
static const double bits_most = 1;
/* The most values from the least to the largest label. */
enum { RANGE_MOST = 1 << 20 };

static int32_t sample_at(const cvol_volume *v, size_t i)
{
    switch (v->grid.type) {
    case CVOL_UINT8:
        return ((const uint8_t *)v->data)[i];
    case CVOL_INT8:
        return ((const int8_t *)v->data)[i];
    case CVOL_UINT16:
        return ((const uint16_t *)v->data)[i];
    case CVOL_INT16:
        return ((const int16_t *)v->data)[i];
    default:
        return ((const int32_t *)v->data)[i];
    }
}

/* 1 if it is worth looking at the samples. */
static int may_be_labels(const shown_volume *v)
{
    const cvol_histogram *h = &v->histogram;
    const int type = (int)v->grid.type;
    return volume_is_exact(v) && h->integers && (h->distinct > 2 || !h->distinct) &&
           (type == CVOL_UINT8 || type == CVOL_INT8 || type == CVOL_UINT16 || type == CVOL_INT16 ||
            type == CVOL_INT32) &&
           h->max - h->min < RANGE_MOST &&
           8 * (double)v->compressed_bytes < bits_most * (double)cvol_grid_samples(&v->grid);
}

/* *out: 1 if the samples are labels, or have so few values that the usual colours are those of
 * labels. */
static int find_whether_labels(cvol_context *context, int *out, const shown_volume *v,
                               const cvol_volume *samples)
{
    cvol_transfer *transfer = NULL;
    cvol_kind kind = CVOL_KIND_GENERAL;
    int code = cvol_volume_compute_is_labels(context, out, samples, v->path);
    if (code || *out)
        return code;
    code = cvol_transfer_create_auto(context, &transfer, &kind, NULL, &v->histogram, &v->grid, 1);
    cvol_transfer_free(transfer);
    *out = kind == CVOL_KIND_LABELS;
    return code;
}

/* The known facts about a label; NULL: none. */
static const viewer_label *find_named(const shown_volume *v, int value)
{
    for (size_t i = 0; i < v->named_count; i++)
        if (v->named[i].value == value)
            return &v->named[i];
    return NULL;
}

static void set_colour(double rgb[3], const shown_volume *v, int value)
{
    const viewer_label *known = find_named(v, value);
    cvol_label_get_colour(rgb, value);
    for (int c = 0; c < 3 && known && known->has_colour; c++)
        rgb[c] = known->rgb[c];
}

/* The samples, and which of them have no value: their fills need not lie near the labels. */
typedef struct label_samples {
    const cvol_volume *volume;
    uint8_t *is_void; /* not 0: no value; NULL: all have one */
    int32_t least;    /* of those with a value */
    size_t width;     /* number of values from the least to the largest; 0: too many, or none */
} label_samples;

static int has_value(const label_samples *s, size_t i)
{
    return !s->is_void || !s->is_void[i];
}

/* Finds the range of the samples. That of the histogram is no limit of what a file holds. */
static int find_range(label_samples *s, const shown_volume *v)
{
    static const size_t begin[3] = {0, 0, 0};
    const size_t count = cvol_grid_samples(&s->volume->grid);
    int64_t least = INT32_MAX, largest = INT32_MIN;
    cvol_array_info info;
    cvol_array_get_info(&info, v->array);
    if (info.missing_samples && !(s->is_void = malloc(count)))
        return CVOL_ERROR_MEMORY;
    if (s->is_void)
        cvol_array_evaluate_mask(s->is_void, v->array, begin, v->grid.dims);
    for (size_t i = 0; i < count; i++) {
        const int64_t value = sample_at(s->volume, i);
        if (!has_value(s, i))
            continue;
        least = value < least ? value : least;
        largest = value > largest ? value : largest;
    }
    if (least <= largest && largest - least < RANGE_MOST) {
        s->least = (int32_t)least;
        s->width = (size_t)(largest - least) + 1;
    }
    return CVOL_OK;
}

/* Gives each label its number in `number`, by its distance from the least sample, and its colour; 0
 * if there are too many. */
static int number_labels(shown_labels *out, uint8_t *number, const shown_volume *v,
                         const label_samples *s)
{
    const size_t count = cvol_grid_samples(&s->volume->grid), width = s->width;
    const int32_t least = s->least;
    for (size_t i = 0; i < count; i++)
        if (has_value(s, i))
            number[sample_at(s->volume, i) - least] = 1;
    for (size_t k = 0; k < width; k++) {
        const int32_t label = least + (int32_t)k;
        if (!number[k] || !label) {
            number[k] = 0;
            continue;
        }
        if (out->count == LABELS_SHOWN_MAX)
            return 0;
        set_colour(out->colours + 3 * out->count, v, label);
        out->values[out->count] = label;
        number[k] = (uint8_t)++out->count;
    }
    return out->count > 0;
}

/* Makes numbers and shape; *found is 0 if there are too many labels. */
static int make(cvol_context *context, shown_labels *out, int *found, const shown_volume *v,
                const cvol_volume *samples)
{
    label_samples s = {.volume = samples};
    int code = find_range(&s, v);
    uint8_t *number = s.width ? calloc(s.width, 1) : NULL;
    const size_t count = cvol_grid_samples(&samples->grid);
    cvol_grid grid = samples->grid;
    if (!code && s.width && !number)
        code = CVOL_ERROR_MEMORY;
    *found = !code && s.width && number_labels(out, number, v, &s);
    grid.type = CVOL_UINT8;
    grid.value_scale = 1;
    grid.value_offset = 0;
    if (*found)
        code = cvol_volume_create(context, &out->numbers, &grid);
    if (!code && *found) {
        uint8_t *to = out->numbers->data;
        for (size_t i = 0; i < count; i++)
            to[i] = has_value(&s, i) ? number[sample_at(samples, i) - s.least] : 0;
        code = cvol_labels_create_shape(context, &out->shape, out->numbers);
    }
    free(number);
    free(s.is_void);
    return code;
}

int labels_find(cvol_context *context, shown_labels **out, const shown_volume *v)
{
    static const size_t begin[3] = {0, 0, 0};
    const cvol_volume *samples = v->dense;
    cvol_volume *own = NULL;
    int found = 0, code = CVOL_OK;
    *out = NULL;
    if (!may_be_labels(v))
        return CVOL_OK;
    if (!samples) {
        code = cvol_volume_create(context, &own, &v->grid);
        if (!code)
            code = cvol_array_evaluate_box(context, own->data, v->array, begin, v->grid.dims);
        samples = own;
    }
    shown_labels *labels = NULL;
    int are_labels = 0;
    if (!code)
        code = find_whether_labels(context, &are_labels, v, samples);
    if (!code && are_labels) {
        labels = calloc(1, sizeof *labels);
        code = labels ? make(context, labels, &found, v, samples) : CVOL_ERROR_MEMORY;
    }
    if (found && !code)
        *out = labels;
    else
        labels_free(labels);
    cvol_volume_free(own);
    return code;
}

void labels_free(shown_labels *labels)
{
    if (!labels)
        return;
    cvol_volume_free(labels->numbers);
    cvol_array_free(labels->shape);
    free(labels);
}

json_t *labels_describe(const shown_volume *v)
{
    const shown_labels *labels = v->labels;
    if (!labels)
        return json_null();
    json_t *list = json_array();
    for (size_t i = 0; i < labels->count; i++) {
        const double *rgb = labels->colours + 3 * i;
        json_array_append_new(list,
                              json_pack("{s:i, s:o, s:[f, f, f]}", "value", labels->values[i],
                                        "name", answer_text(labels_name(v, labels->values[i])),
                                        "colour", rgb[0], rgb[1], rgb[2]));
    }
    return list;
}

const char *labels_name(const shown_volume *v, double value)
{
    const viewer_label *known = value >= INT32_MIN && value <= INT32_MAX ? find_named(v, (int)value)
                                                                         : NULL;
    return known ? known->name : NULL;
}

void labels_colour(uint8_t rgb[3], const shown_labels *labels, double sample)
{
    size_t from = 0, end = labels->count;
    while (from < end) {
        const size_t middle = (from + end) / 2;
        if (labels->values[middle] < sample)
            from = middle + 1;
        else
            end = middle;
    }
    const int is_one = from < labels->count && !(labels->values[from] > sample);
    for (int c = 0; c < 3; c++)
        rgb[c] = (uint8_t)(is_one ? 255 * labels->colours[3 * from + (size_t)c] + 0.5 : 0);
}

int labels_number_at(const cvol_volume *numbers, const double place[3])
{
    const size_t *n = numbers->grid.dims;
    const uint8_t *samples = numbers->data;
    double sums[UINT8_MAX + 1] = {0};
    int best = 0;
    for (int k = 0; k < 8; k++) {
        size_t at[3];
        double weight = 1;
        for (int a = 0; a < 3; a++) {
            const double low = floor(fmin(fmax(place[a], 0), (double)(n[a] - 1))),
                         part = place[a] - low;
            const int far = k >> a & 1;
            at[a] = (size_t)low + (far && (size_t)low + 1 < n[a]);
            weight *= far ? part : 1 - part;
        }
        const int number = samples[at[0] + n[0] * (at[1] + n[1] * at[2])];
        sums[number] += weight + 1e-9;
        if (number && sums[number] > sums[best] * (best != 0))
            best = number;
    }
    return best;
}

int labels_at(const shown_volume *v, const double place[3])
{
    const int number = labels_number_at(v->labels->numbers, place);
    return number ? v->labels->values[number - 1] : 0;
}

int labels_draw(cvol_context *context, const shown_labels *labels, cvol_renderer *renderer,
                cvol_image *image, const cvol_render_options *options,
                const cvol_transfer *transfer)
{
    cvol_image *floats;
    if (image->values)
        return overlay_draw_labels(context, renderer, image, options, labels->numbers,
                                   labels->colours, labels->count, transfer);
    int code = cvol_image_create_float(context, &floats, image->width, image->height);
    if (!code)
        code = cvol_image_add_depth(context, floats);
    if (!code)
        code = overlay_draw_labels(context, renderer, floats, options, labels->numbers,
                                   labels->colours, labels->count, transfer);
    if (!code)
        code = cvol_image_flatten(context, image, floats, options->background);
    if (!code && image->depth)
        for (size_t i = 0; i < (size_t)image->width * (size_t)image->height; i++)
            image->depth[i] = floats->depth[i];
    cvol_image_free(floats);
    return code;
}
