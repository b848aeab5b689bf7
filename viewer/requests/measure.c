/* Distances, angles and statistics of regions. Places are in samples; with origin o, directions d_a
 * and spacings s_a, sample p is at o + sum_a p_a s_a d_a in the world, and a sample has the volume
 * s_0 s_1 s_2 |det d|. The directions need not be perpendicular.
 *
 * An angle is atan2(|u x v|, <u, v>), which is exact near 0 and 180 degrees too, unlike the arc
 * cosine. */
#include "viewer/requests/measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "viewer/volumes/times.h"

#define DEGREES_PER_RADIAN 57.295779513082321

typedef enum measure_kind { DISTANCE, ANGLE, BOX, ELLIPSOID, KINDS } measure_kind;

static const char *const kind_names[] = {"distance", "angle", "box", "ellipsoid"};

typedef struct measurement {
    shown_volume *volume; /* held */
    measure_kind kind;
    int time;
    double points[3][3];     /* of a distance (two) or an angle, in samples */
    size_t begin[3], end[3]; /* of a region */
} measurement;

/* ---- geometry ---------------------------------------------------------------------------------
 */

/* The vector in the world from one point to another. */
static void find_vector(double out[3], const cvol_grid *g, const double from[3], const double to[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = 0;
        for (int a = 0; a < 3; a++)
            out[i] += (to[a] - from[a]) * g->spacing[a] * g->direction[a][i];
    }
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double out[3], const double a[3], const double b[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static double length_of(const double v[3])
{
    return hypot(hypot(v[0], v[1]), v[2]);
}

/* The volume of a sample. */
static double cell_of(const cvol_grid *g)
{
    double normal[3];
    cross(normal, g->direction[0], g->direction[1]);
    return g->spacing[0] * g->spacing[1] * g->spacing[2] * fabs(dot(normal, g->direction[2]));
}

/* Adds the unit of lengths; as in cvol measure, the axes of patients are in mm if the file states
 * no unit. */
static void put_unit(json_t *object, const cvol_grid *g)
{
    const int is_assumed = !*g->unit && g->space != CVOL_SPACE_UNKNOWN;
    json_object_set_new(object, "unit", answer_text(is_assumed ? "mm" : g->unit));
    json_object_set_new(object, "unit_assumed", json_boolean(is_assumed));
}

static answer describe_distance(const measurement *m)
{
    const cvol_grid *g = &m->volume->grid;
    double way[3];
    find_vector(way, g, m->points[0], m->points[1]);
    json_t *object = json_pack("{s:s, s:f}", "kind", kind_names[m->kind], "length", length_of(way));
    put_unit(object, g);
    return answer_exact_json(200, object);
}

/* The angle at the middle point. */
static answer describe_angle(const measurement *m)
{
    double one[3], other[3], normal[3];
    find_vector(one, &m->volume->grid, m->points[1], m->points[0]);
    find_vector(other, &m->volume->grid, m->points[1], m->points[2]);
    cross(normal, one, other);
    return answer_exact_json(
        200, json_pack("{s:s, s:f}", "kind", kind_names[m->kind], "degrees",
                       atan2(length_of(normal), dot(one, other)) * DEGREES_PER_RADIAN));
}

/* ---- regions ----------------------------------------------------------------------------------
 */

/* The figures of a region in the values that the file states: scale s + offset. */
static json_t *describe_region(const cvol_region_statistics *s, const measurement *m)
{
    const shown_volume *v = m->volume;
    const int known = fabs(v->rescale[0]) > 0;
    const double scale = known ? v->rescale[0] : v->grid.value_scale, size = fabs(scale);
    const double offset = known ? v->rescale[1] : v->grid.value_offset;
    const int is_turned = scale < 0; /* the least sample has the largest value */
    const double ends[2] = {is_turned ? s->largest : s->least, is_turned ? s->least : s->largest};
    const double errors[2] = {is_turned ? s->largest_error : s->least_error,
                              is_turned ? s->least_error : s->largest_error};
    const int any = s->samples > 0; /* else there is no mean */
    json_t *object = json_pack("{s:s, s:I, s:f}", "kind", kind_names[m->kind], "samples",
                               (json_int_t)s->samples, "volume",
                               cell_of(&v->grid) * (double)s->samples);
    const struct {
        const char *name;
        double value;
    } figures[] = {{"mean", scale * s->mean + offset},
                   {"mean_error", size * s->mean_error},
                   {"standard_deviation", size * s->standard_deviation},
                   {"standard_deviation_error", size * s->standard_deviation_error},
                   {"min", scale * ends[0] + offset},
                   {"min_error", size * errors[0]},
                   {"max", scale * ends[1] + offset},
                   {"max_error", size * errors[1]}};
    for (size_t i = 0; object && i < sizeof figures / sizeof *figures; i++)
        json_object_set_new(object, figures[i].name, answer_number(any ? figures[i].value : NAN));
    json_object_set_new(object, "value_unit", json_string(known ? "HU" : ""));
    put_unit(object, &v->grid);
    return object;
}

static answer run(job *j, cvol_context *context, void *state)
{
    const measurement *m = state;
    cvol_region_statistics s;
    shown_volume *at;
    int code = times_hold(context, &at, m->volume, m->time);
    if (!code)
        code = cvol_array_compute_region_statistics(context, &s, at->array, m->begin, m->end,
                                                    m->kind == BOX ? CVOL_REGION_BOX
                                                                   : CVOL_REGION_ELLIPSOID);
    volume_release(at);
    return code ? jobs_failed(j, context, code) : answer_exact_json(200, describe_region(&s, m));
}

/* ---- fields -----------------------------------------------------------------------------------
 */

/* A point within the outer faces of the samples at the ends. */
static void take_point(double out[3], fields *f, const json_t *point, size_t number,
                       const cvol_grid *g)
{
    if (!json_is_array(point) || json_array_size(point) != 3) {
        fields_fail(f, "points[%zu] must be three numbers, a place in samples", number);
        return;
    }
    for (size_t a = 0; a < 3; a++) {
        const json_t *part = json_array_get(point, a);
        const double most = (double)g->dims[a] - 0.5;
        out[a] = json_number_value(part);
        if (!json_is_number(part))
            fields_fail(f, "points[%zu] must be three numbers, a place in samples", number);
        else if (!(out[a] >= -0.5 && out[a] <= most))
            fields_fail(f, "points[%zu] has %g along %c, must have -0.5 to %g", number, out[a],
                        "xyz"[a], most);
    }
}

static void take_points(measurement *m, fields *f)
{
    const size_t count = m->kind == ANGLE ? 3 : 2;
    json_t *points = take_any(f, "points");
    if (!points)
        fields_fail(f, "points is missing: give %zu points", count);
    else if (!json_is_array(points) || json_array_size(points) != count)
        fields_fail(f, "points must be %zu points, [x, y, z] each", count);
    for (size_t i = 0; fields_ok(f) && i < count; i++)
        take_point(m->points[i], f, json_array_get(points, i), i, &m->volume->grid);
    json_decref(points);
    for (size_t i = 0; fields_ok(f) && m->kind == ANGLE && i < 3; i += 2)
        if (!memcmp(m->points[i], m->points[1], sizeof m->points[1]))
            fields_fail(f, "points[%zu] is points[1]: there is no angle between them", i);
}

static void take_box(measurement *m, fields *f)
{
    const size_t *dims = m->volume->grid.dims;
    double box[6] = {0};
    if (!take_numbers(f, "box", box, 6))
        fields_fail(f, "box is missing: give [x0, x1, y0, y1, z0, z1], in samples");
    for (int a = 0; fields_ok(f) && a < 3; a++) {
        const double from = box[2 * a], to = box[2 * a + 1];
        if (from < 0 || to > (double)dims[a] || from >= to)
            fields_fail(f, "box has %g to %g along %c, must lie within 0 to %zu", from, to,
                        "xyz"[a], dims[a]);
        else if (from != floor(from) || to != floor(to))
            fields_fail(f, "box has %g to %g along %c, must have whole numbers", from, to,
                        "xyz"[a]);
        else {
            m->begin[a] = (size_t)from;
            m->end[a] = (size_t)to;
        }
    }
}

/* Reads the fields of a measurement of its volume. */
static void take(measurement *m, fields *f)
{
    char kind[16] = "";
    int found = KINDS;
    take_text(f, "kind", kind, sizeof kind);
    for (int k = 0; k < KINDS; k++)
        if (!strcmp(kind, kind_names[k]))
            found = k;
    if (found == KINDS) {
        fields_fail(f, "kind is '%s', must be distance, angle, box or ellipsoid", kind);
        return;
    }
    m->kind = (measure_kind)found;
    take_integer(f, "time", &m->time, 0, m->volume->times - 1);
    if (m->kind == DISTANCE || m->kind == ANGLE)
        take_points(m, f);
    else
        take_box(m, f);
    fields_end(f);
}

static void free_measurement(void *state)
{
    measurement *m = state;
    volume_release(m->volume);
    free(m);
}

answer measure_post(request *r)
{
    answer result = {0};
    char error[512] = "";
    json_t *body;
    measurement *m = calloc(1, sizeof *m);
    if (!m)
        return answer_error(500, "not enough memory for a request");
    m->volume = request_ready_volume(r, &result);
    if (!m->volume) {
        free(m);
        return result;
    }
    fields_parse(&body, r->body, r->body_bytes, error, sizeof error);
    fields f = {body, NULL, "", error, sizeof error};
    if (body)
        take(m, &f);
    json_decref(body);
    if (!error[0] && (m->kind == BOX || m->kind == ELLIPSOID))
        return request_later(r, "", -1, 0, run, m, free_measurement);
    if (error[0])
        result = answer_error(400, "%s", error);
    else
        result = m->kind == ANGLE ? describe_angle(m) : describe_distance(m);
    free_measurement(m);
    return result;
}
