/* Transfer functions from JSON files: cvol's own and ParaView's.
 *
 * cvol's:     {"points": [[value, r, g, b, opacity], ...]}
 * ParaView's: an object, or an array whose first object counts, with
 *             "RGBPoints": [value, r, g, b, ...] and optionally
 *             "Points": [value, opacity, midpoint, sharpness, ...]
 *
 * ParaView stores colour and opacity separately. cvol joins them: at each value of either, both are
 * evaluated (on both sides of a jump). This loses nothing, since both are linear in between. A file
 * without opacities gets a ramp from 0 to 1 over its range. ParaView's midpoint and sharpness bend
 * a segment of the opacity; short straight segments along VTK's curve (vtkPiecewiseFunction)
 * replace a bent one. Colours are interpolated in RGB, for any "ColorSpace" of the file. */
#include "render/transfer/transfer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/file.h"
#include "base/json_text.h"
#include "base/memory.h"

#define FILE_BYTES_MAX ((size_t)16 << 20)

/* Straight segments for one bent segment. */
#define CURVE_SEGMENTS 16

typedef struct point_list {
    cvol_transfer_point *points;
    size_t count, capacity;
} point_list;

static int reserve_points(cvol_context *context, point_list *list, size_t capacity)
{
    *list = (point_list){cvol_allocate(capacity, sizeof *list->points), 0, capacity};
    if (!list->points)
        return cvol_fail_memory(context, capacity * sizeof *list->points, "a transfer function");
    return CVOL_OK;
}

static int fail_count(cvol_context *context, const char *path, const char *field, size_t count)
{
    return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: \"%s\" has %zu points, must be 1 to %d", path,
                     field, count, CVOL_TRANSFER_POINTS_MAX);
}

/* ---- cvol's own ----------------------------------------------------------------------- */

static int read_point(cvol_context *context, cvol_transfer_point *point, const json_t *json,
                      size_t index, const char *path)
{
    static const char *const names[5] = {"value", "r", "g", "b", "opacity"};
    if (!json_is_array(json))
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: point %zu is not an array [value, r, g, b, opacity]", path, index);
    if (json_array_size(json) != 5)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: point %zu has %zu values, must be 5: value, r, g, b, opacity", path,
                         index, json_array_size(json));
    double values[5];
    for (size_t i = 0; i < 5; i++) {
        const json_t *number = json_array_get(json, i);
        if (!json_is_number(number))
            return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: point %zu: %s is not a number", path,
                             index, names[i]);
        values[i] = json_number_value(number);
    }
    *point = (cvol_transfer_point){values[0], values[1], values[2], values[3], values[4]};
    return CVOL_OK;
}

static int read_points(cvol_context *context, cvol_transfer **out, const json_t *points,
                       const char *path)
{
    if (!json_is_array(points))
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: \"points\" is not an array", path);
    size_t count = json_array_size(points);
    if (count < 1 || count > CVOL_TRANSFER_POINTS_MAX)
        return fail_count(context, path, "points", count);
    point_list list;
    int code = reserve_points(context, &list, count);
    if (code)
        return code;
    for (; !code && list.count < list.capacity; list.count++)
        code = read_point(context, &list.points[list.count], json_array_get(points, list.count),
                          list.count, path);
    if (!code)
        code = cvol_transfer_make(context, out, list.points, list.count, CVOL_ERROR_FORMAT, path);
    free(list.points);
    return code;
}

/* ---- ParaView's ------------------------------------------------------------------------ */

/* A flat array of numbers in fours. */
static int check_fours(cvol_context *context, const json_t *json, const char *field,
                       const char *path)
{
    if (!json_is_array(json))
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: \"%s\" is not an array", path, field);
    size_t count = json_array_size(json);
    if (count == 0 || count % 4)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: \"%s\" has %zu values, must be 4 for each point", path, field, count);
    if (count / 4 > CVOL_TRANSFER_POINTS_MAX)
        return fail_count(context, path, field, count / 4);
    for (size_t i = 0; i < count; i++)
        if (!json_is_number(json_array_get(json, i)))
            return cvol_fail(context, CVOL_ERROR_FORMAT,
                             "%s: \"%s\": value %zu of point %zu is not a number", path, field,
                             i % 4, i / 4);
    return CVOL_OK;
}

static double number_at(const json_t *json, size_t index)
{
    return json_number_value(json_array_get(json, index));
}

static int read_colours(cvol_context *context, cvol_transfer **out, const json_t *json,
                        const char *path)
{
    int code = check_fours(context, json, "RGBPoints", path);
    if (code)
        return code;
    point_list list;
    code = reserve_points(context, &list, json_array_size(json) / 4);
    if (code)
        return code;
    for (size_t i = 0; i < list.capacity; i++)
        list.points[i] = (cvol_transfer_point){number_at(json, 4 * i), number_at(json, 4 * i + 1),
                                               number_at(json, 4 * i + 2),
                                               number_at(json, 4 * i + 3), 0};
    code = cvol_transfer_make(context, out, list.points, list.capacity, CVOL_ERROR_FORMAT, path);
    free(list.points);
    return code;
}

/* VTK's curve from 0 to 1 over 0..1: the midpoint is moved to 1/2, the sharpness bends the
 * parameter, and a Hermite curve flattens the ends. */
static double vtk_curve(double s, double midpoint, double sharpness)
{
    s = s < midpoint ? 0.5 * s / midpoint : 0.5 + 0.5 * (s - midpoint) / (1 - midpoint);
    if (sharpness > 0.99)
        return s < 0.5 ? 0 : 1;
    if (sharpness < 0.01)
        return s;
    double bend = 1 + 10 * sharpness;
    s = s < 0.5 ? 0.5 * pow(2 * s, bend) : 1 - 0.5 * pow(2 * (1 - s), bend);
    double ss = s * s, sss = ss * s;
    double value = 3 * ss - 2 * sss + (1 - sharpness) * (2 * sss - 3 * ss + s);
    return fmin(fmax(value, 0), 1);
}

/* Inner points along the bent segment from p to q. */
static void add_curve(point_list *list, cvol_transfer_point p, cvol_transfer_point q,
                      double midpoint, double sharpness)
{
    for (int i = 1; i < CURVE_SEGMENTS; i++) {
        double s = (double)i / CURVE_SEGMENTS;
        cvol_transfer_point point = {.value = p.value + (q.value - p.value) * s};
        point.opacity = p.opacity + (q.opacity - p.opacity) * vtk_curve(s, midpoint, sharpness);
        list->points[list->count++] = point;
    }
}

/* Checked here, since inner points shift the indices that cvol_transfer_make would report. */
static int check_opacity(cvol_context *context, double opacity, size_t index, const char *path)
{
    if (opacity >= 0 && opacity <= 1)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_FORMAT,
                     "%s: \"Points\": opacity of point %zu is %g, must be within 0 and 1", path,
                     index, opacity);
}

static int read_opacities(cvol_context *context, cvol_transfer **out, const json_t *json,
                          const char *path)
{
    int code = check_fours(context, json, "Points", path);
    if (code)
        return code;
    size_t count = json_array_size(json) / 4;
    point_list list;
    code = reserve_points(context, &list, count * CURVE_SEGMENTS);
    if (code)
        return code;
    for (size_t i = 0; i < count && !code; i++) {
        cvol_transfer_point p = {.value = number_at(json, 4 * i),
                                 .opacity = number_at(json, 4 * i + 1)};
        code = check_opacity(context, p.opacity, i, path);
        list.points[list.count++] = p;
        double midpoint = number_at(json, 4 * i + 2), sharpness = number_at(json, 4 * i + 3);
        int bent = midpoint > 0 && midpoint < 1 && (midpoint != 0.5 || sharpness >= 0.01);
        if (bent && i + 1 < count) {
            cvol_transfer_point q = {.value = number_at(json, 4 * i + 4),
                                     .opacity = number_at(json, 4 * i + 5)};
            add_curve(&list, p, q, midpoint, sharpness);
        }
    }
    if (!code)
        code = cvol_transfer_make(context, out, list.points, list.count, CVOL_ERROR_FORMAT, path);
    free(list.points);
    return code;
}

/* From 0 to 1 over the range of the colours. */
static int make_opacity_ramp(cvol_context *context, cvol_transfer **out,
                             const cvol_transfer *colours)
{
    const cvol_transfer_point ends[2] = {
        {.value = colours->points[0].value, .opacity = 0},
        {.value = colours->points[colours->count - 1].value, .opacity = 1}};
    return cvol_transfer_make(context, out, ends, 2, CVOL_ERROR_FORMAT, "opacity ramp");
}

static void add_joined(point_list *list, cvol_transfer_point colour, double opacity)
{
    colour.opacity = opacity;
    list->points[list->count++] = colour;
}

/* Adds the joined point at `value`, twice if either function jumps there. */
static void join_at(point_list *list, double value, const cvol_transfer *colours,
                    const cvol_transfer *opacities)
{
    cvol_transfer_point before = cvol_transfer_before(colours, value);
    cvol_transfer_point after = cvol_transfer_at(colours, value);
    double opacity_before = cvol_transfer_before(opacities, value).opacity;
    double opacity_after = cvol_transfer_at(opacities, value).opacity;
    if (before.r != after.r || before.g != after.g || before.b != after.b ||
        opacity_before != opacity_after)
        add_joined(list, before, opacity_before);
    add_joined(list, after, opacity_after);
}

static int join(cvol_context *context, cvol_transfer **out, const cvol_transfer *colours,
                const cvol_transfer *opacities, const char *path)
{
    point_list list;
    int code = reserve_points(context, &list, 2 * (colours->count + opacities->count));
    if (code)
        return code;
    size_t i = 0, j = 0;
    while (i < colours->count || j < opacities->count) {
        double value = i < colours->count ? colours->points[i].value : INFINITY;
        if (j < opacities->count)
            value = fmin(value, opacities->points[j].value);
        join_at(&list, value, colours, opacities);
        while (i < colours->count && colours->points[i].value == value)
            i++;
        while (j < opacities->count && opacities->points[j].value == value)
            j++;
    }
    code = cvol_transfer_make(context, out, list.points, list.count, CVOL_ERROR_FORMAT, path);
    free(list.points);
    return code;
}

static int read_paraview(cvol_context *context, cvol_transfer **out, const json_t *object,
                         const char *path)
{
    cvol_transfer *colours = NULL, *opacities = NULL;
    int code = read_colours(context, &colours, json_object_get(object, "RGBPoints"), path);
    const json_t *points = json_object_get(object, "Points");
    if (!code)
        code = points ? read_opacities(context, &opacities, points, path)
                      : make_opacity_ramp(context, &opacities, colours);
    if (!code)
        code = join(context, out, colours, opacities, path);
    cvol_transfer_free(colours);
    cvol_transfer_free(opacities);
    return code;
}

/* ---- recognition ----------------------------------------------------------------------- */

static int read_json(cvol_context *context, cvol_transfer **out, const json_t *root,
                     const char *path)
{
    const json_t *points = json_object_get(root, "points");
    if (points)
        return read_points(context, out, points, path);
    if (json_object_get(root, "RGBPoints"))
        return read_paraview(context, out, root, path);
    for (size_t i = 0; i < json_array_size(root); i++)
        if (json_object_get(json_array_get(root, i), "RGBPoints"))
            return read_paraview(context, out, json_array_get(root, i), path);
    return cvol_fail(context, CVOL_ERROR_FORMAT,
                     "%s: has neither \"points\" nor ParaView's \"RGBPoints\"", path);
}

int cvol_transfer_parse(cvol_context *context, cvol_transfer **out, const char *text, size_t size,
                        const char *path)
{
    *out = NULL;
    static const uint8_t byte_order_mark[3] = {0xef, 0xbb, 0xbf};
    if (size == 0)
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: is empty", path);
    if (size > FILE_BYTES_MAX)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: is larger than the %zu bytes that a transfer function may have", path,
                         FILE_BYTES_MAX);
    if (size >= 3 && !memcmp(text, byte_order_mark, 3)) {
        text += 3;
        size -= 3;
    }
    json_error_t error;
    json_t *root;
    int code = cvol_json_load(context, &root, text, size, JSON_DECODE_INT_AS_REAL, &error, path);
    if (code == CVOL_ERROR_MEMORY)
        return code;
    if (code)
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: line %d, column %d: %s", path, error.line,
                         error.column, error.text);
    code = read_json(context, out, root, path);
    json_decref(root);
    return code;
}

int cvol_transfer_read(cvol_context *context, cvol_transfer **out, const char *path)
{
    *out = NULL;
    uint8_t *data;
    size_t size;
    int code = cvol_file_read(context, &data, &size, path, 0, FILE_BYTES_MAX + 1);
    if (code)
        return code;
    code = cvol_transfer_parse(context, out, (const char *)data, size, path);
    free(data);
    return code;
}
