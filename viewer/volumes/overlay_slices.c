/* Overlays on slices.
 *
 * A slice shows an overlay as a layer of THICKNESS samples of the volume: with opacity o of a
 * sample the layer has 1 - (1 - o)^THICKNESS, so that opacities of a transfer function for rays are
 * visible on a slice. Labels have one opacity, which leaves the slice visible. */
#include <math.h>
#include <stdlib.h>

#include "viewer/volumes/overlays.h"
#include "viewer/volumes/samples.h"

#define THICKNESS 16
#define LABEL_OPACITY 0.6

/* Colour and opacity at a place of a slice. */
typedef struct tint {
    double rgb[3], opacity;
} tint;

/* The samples of two planes of an overlay, and where a slice lies between them. */
typedef struct planes {
    double *values; /* [count][dims[rows]][dims[columns]] */
    size_t dims[2], count;
    double share[2], between;
} planes;

/* The colour of a value, between the control points around it. */
static tint colour_of(const cvol_transfer *transfer, double value)
{
    size_t from = 0, to = cvol_transfer_count(transfer) - 1;
    while (from + 1 < to) {
        const size_t middle = (from + to) / 2;
        if (cvol_transfer_point_at(transfer, middle).value <= value)
            from = middle;
        else
            to = middle;
    }
    const cvol_transfer_point a = cvol_transfer_point_at(transfer, from),
                              b = cvol_transfer_point_at(transfer, to);
    const double t = b.value > a.value ? fmin(fmax((value - a.value) / (b.value - a.value), 0), 1)
                     : value < a.value ? 0
                                       : 1;
    const double opacity = a.opacity + t * (b.opacity - a.opacity);
    return (tint){{a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b)},
                  1 - pow(1 - fmin(opacity, 1), THICKNESS)};
}

/* The interpolated value of a row and a column of the slice; NaN: none. */
static double value_at(const planes *p, size_t column, size_t row)
{
    const double at[2] = {(double)column * p->share[0], (double)row * p->share[1]};
    size_t low[2], high[2];
    double part[2], sum = 0;
    for (int a = 0; a < 2; a++) {
        low[a] = (size_t)at[a] < p->dims[a] ? (size_t)at[a] : p->dims[a] - 1;
        high[a] = low[a] + 1 < p->dims[a] ? low[a] + 1 : low[a];
        part[a] = at[a] - (double)low[a];
    }
    for (int k = 0; k < 8; k++) {
        const double weight = (k & 1 ? part[0] : 1 - part[0]) * (k & 2 ? part[1] : 1 - part[1]) *
                              (k & 4 ? p->between : 1 - p->between);
        const size_t x = k & 1 ? high[0] : low[0], y = k & 2 ? high[1] : low[1],
                     z = k & 4 ? p->count - 1 : 0;
        if (weight > 0)
            sum += weight * p->values[(z * p->dims[1] + y) * p->dims[0] + x];
    }
    return sum;
}

/* Reads the planes around sample `index` of the volume. */
static int read_planes(cvol_context *context, planes *out, const overlay *o, int axis, size_t index)
{
    const size_t *dims = cvol_array_grid(o->array)->dims;
    const int across[2] = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
    size_t begin[3] = {0, 0, 0}, end[3] = {dims[0], dims[1], dims[2]};
    const double at = (double)index * o->share[axis];
    begin[axis] = (size_t)at < dims[axis] ? (size_t)at : dims[axis] - 1;
    end[axis] = begin[axis] + 2 <= dims[axis] ? begin[axis] + 2 : dims[axis];
    *out = (planes){.count = end[axis] - begin[axis]};
    out->between = out->count > 1 ? at - (double)begin[axis] : 0;
    for (int k = 0; k < 2; k++) {
        out->dims[k] = dims[across[k]];
        out->share[k] = o->share[across[k]];
    }
    double *values;
    const int code = samples_read_array(context, &values, o->array, begin, end);
    if (code || axis == 2) { /* planes follow each other */
        out->values = values;
        return code;
    }
    const size_t count = out->count * out->dims[0] * out->dims[1];
    out->values = calloc(count, sizeof *values);
    for (size_t i = 0; i < count && out->values; i++) {
        const size_t x = axis == 0 ? i / out->count % out->dims[0] : i % out->dims[0],
                     z = axis == 0 ? i % out->count : i / out->dims[0] % out->count,
                     y = i / (out->count * out->dims[0]);
        out->values[(z * out->dims[1] + y) * out->dims[0] + x] = values[i];
    }
    free(values);
    return out->values ? CVOL_OK : CVOL_ERROR_MEMORY;
}

static void mix(uint8_t *pixel, const tint *t, double opacity)
{
    for (int c = 0; c < 3; c++)
        pixel[c] = (uint8_t)(pixel[c] + opacity * t->opacity * (255 * t->rgb[c] - pixel[c]) + 0.5);
}

/* The label at a sample of the volume. */
static tint label_at(const overlay *o, const size_t place[3])
{
    const size_t *n = o->numbers->grid.dims;
    size_t at[3];
    for (int a = 0; a < 3; a++) {
        at[a] = (size_t)((double)place[a] * o->share[a] + 0.5);
        at[a] = at[a] < n[a] ? at[a] : n[a] - 1;
    }
    const size_t number =
        ((const uint8_t *)o->numbers->data)[at[0] + n[0] * (at[1] + n[1] * at[2])];
    const double *rgb = o->of->colours + 3 * (number ? number - 1 : 0);
    return (tint){{rgb[0], rgb[1], rgb[2]}, number ? LABEL_OPACITY : 0};
}

/* Paints one overlay; of labels transfer and planes are NULL. */
static void paint(cvol_image *image, const overlay *o, const cvol_transfer *transfer,
                  const planes *p, double opacity, int axis, size_t index, int is_up)
{
    const int across[2] = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
    for (int row = 0; row < image->height; row++) {
        const size_t line = (size_t)(is_up ? image->height - 1 - row : row);
        uint8_t *pixel = image->rgba + 4 * (size_t)row * (size_t)image->width;
        for (size_t i = 0; i < (size_t)image->width; i++, pixel += 4) {
            size_t place[3];
            place[axis] = index;
            place[across[0]] = i;
            place[across[1]] = line;
            const double value = p ? value_at(p, i, line) : 0;
            const tint t = p ? colour_of(transfer, value) : label_at(o, place);
            if (!isnan(value) && t.opacity > 0)
                mix(pixel, &t, opacity);
        }
    }
}

static int paint_one(cvol_context *context, const shown_volume *v, int i,
                     const overlay_choice *choice, cvol_image *image, int axis, size_t index,
                     int is_up)
{
    cvol_transfer *colours = NULL, *depths = NULL;
    held_overlay *held = NULL;
    const overlay *o;
    planes p = {.values = NULL};
    int code = overlays_hold(context, &held, &o, v, i, choice);
    if (!code && o->numbers) {
        paint(image, o, NULL, NULL, choice->opacity, axis, index, is_up);
    } else if (!code) {
        code = overlays_create_transfers(context, &colours, &depths, v, i, choice, 1);
        if (!code)
            code = read_planes(context, &p, o, axis, index);
        if (!code)
            paint(image, o, colours, &p, choice->opacity, axis, index, is_up);
    }
    free(p.values);
    cvol_transfer_free(colours);
    cvol_transfer_free(depths);
    overlays_release(v, held);
    return code;
}

int overlays_paint_slice(cvol_context *context, const shown_volume *v,
                         const overlay_choice *choices, int count, cvol_image *image, int axis,
                         size_t index, int is_up)
{
    int code = CVOL_OK;
    for (int i = 0; i < count && !code; i++)
        if (overlays_is_drawn(&choices[i], overlays_given(v, i)))
            code = paint_one(context, v, i, &choices[i], image, axis, index, is_up);
    return code;
}
