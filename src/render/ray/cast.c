/* One ray of the ray engine (cast.h).
 *
 * Each pixel's ray is cut to the box of sample centres, or to the part of it inside the clip. An
 * axis of one sample has the thickness of its spacing, so a single slice is a thin slab. The cut
 * ray is divided into intervals of one step, each with one sample in its middle; the last is
 * shorter, and weighted by its own length:
 *
 *     composite   I += (1 - A) c a,  A += (1 - A) a  front to back, where c and
 *                 a = 1 - (1 - opacity)^(length / mean spacing) come from the transfer function
 *                 at the interpolated sample; then I += (1 - A) background. Where the function
 *                 changes within an interval, the interval is divided (interval.c): the volume is
 *                 then linear between its front, middle and back. Light is that of the middle
 *     xray        sum of sample length / sum of length
 *     mip         the largest sample; min the smallest
 *     iso         the first place whose sample has the value or more, lit; found by halving the
 *                 step that leads to it
 *
 * A ray ends early when its transmittance is below 1/1024: a quarter of a grey level. */
#include "render/ray/cast.h"

#include <math.h>

#include "render/ray/walk.h"

/* The samples in the middle of the whole steps first .. first + count - 1, and the share of each
 * that has a value. */
static void fetch_run(double *out, double *cover, const cvol_ray_job *job,
                      const cvol_ray_path *path, size_t first, size_t count)
{
    cvol_ray_fetch(out, cover, job, path, (double)first + 0.5, count);
}

/* The sample in the middle of the rest. */
static double fetch_rest(double *cover, const cvol_ray_job *job, const cvol_ray_path *path)
{
    double value;
    cvol_ray_fetch(&value, cover, job, path, (double)path->steps + path->rest / 2, 1);
    return value;
}

static size_t run_length(const cvol_ray_path *path, size_t first)
{
    return path->steps - first < CVOL_RAY_RUN ? path->steps - first : CVOL_RAY_RUN;
}

static const cvol_ray_seen no_light = {{0, 0, 0}, 1, INFINITY};

static cvol_ray_lit light_at(const cvol_ray_job *job, const cvol_ray_path *path, double place,
                             double value)
{
    const cvol_ray_reader reader = {&job->state->field, job->state->line, job->state->masked};
    double at[3];
    for (int a = 0; a < 3; a++)
        at[a] = path->entry[a] + place * path->delta[a];
    return cvol_ray_light_at(job->light, &reader, at, value);
}

static double depth_at(const cvol_ray_path *path, double place)
{
    return path->depth + place * path->rise;
}

/* ---- composite ------------------------------------------------------------------------- */

/* The cells of three samples, of which the second has a value. */
typedef struct cells {
    size_t lowest, highest;
} cells;

static cells cells_of(const cvol_ray_point *a, const cvol_ray_point *b, const cvol_ray_point *c)
{
    cells out = {b->cell, b->cell};
    if (a->cover > 0) {
        out.lowest = a->cell < out.lowest ? a->cell : out.lowest;
        out.highest = a->cell > out.highest ? a->cell : out.highest;
    }
    if (c->cover > 0) {
        out.lowest = c->cell < out.lowest ? c->cell : out.lowest;
        out.highest = c->cell > out.highest ? c->cell : out.highest;
    }
    return out;
}

/* Adds the interval to the light, user; 1 if the ray ends. */
static int add_interval(void *user, const cvol_ray_job *job, const cvol_ray_step *step)
{
    cvol_ray_seen *light = user;
    const cvol_ray_table *table = &job->table;
    const cvol_ray_path *path = step->path;
    const cvol_ray_point *s = step->s, *middle = &s[2], *before = step->front ? step->front : &s[1],
                         *after = step->back ? step->back : &s[3];
    if (!(middle->cover > 0))
        return 0;
    const cells around = cells_of(before, middle, after);
    if (cvol_ray_table_hides(table, around.lowest, around.highest))
        return 0;
    const double rise = fmax(fabs(middle->value - before->value),
                             fabs(after->value - middle->value));
    int is_smooth = cvol_ray_table_is_smooth(table, around.lowest, around.highest, rise);
    double values[3] = {0, middle->value, 0};
    if (!is_smooth) {
        cvol_ray_point ends[2];
        cvol_ray_step_ends(ends, job, step);
        const cells within = cells_of(&ends[0], middle, &ends[1]);
        if (cvol_ray_table_hides(table, within.lowest, within.highest))
            return 0;
        values[0] = ends[0].value;
        values[2] = ends[1].value;
        is_smooth = cvol_ray_table_is_smooth(
            table, within.lowest, within.highest,
            2 * fmax(fabs(values[1] - values[0]), fabs(values[2] - values[1])));
    }
    cvol_ray_interval interval = {.share = step->length * middle->cover,
                                  .lit = {1, 0, 1},
                                  .depth = depth_at(path, step->place),
                                  .rise = step->length * path->rise};
    if (job->light)
        interval.lit = light_at(job, path, step->place + step->length / 2, middle->value);
    interval.share *= interval.lit.density;
    if (is_smooth)
        cvol_ray_interval_add(light, table, &interval, middle->value);
    else
        cvol_ray_interval_add_divided(light, table, &interval, values);
    return light->through < CVOL_RAY_TRANSMITTANCE_MIN;
}

static cvol_ray_seen composite(const cvol_ray_job *job, const cvol_ray_path *path)
{
    cvol_ray_seen light = no_light;
    cvol_ray_walk(job, path, add_interval, &light);
    return light;
}

/* ---- other modes ----------------------------------------------------------------------- */

/* Returns 1 if the surface is at or before a place along the ray, in steps; stores the value
 * there. */
static int is_within(double *value, const cvol_ray_job *job, const cvol_ray_path *path,
                     double place)
{
    double cover;
    cvol_ray_fetch(value, &cover, job, path, place, 1);
    return cover >= 0.5 && *value >= job->surface->value;
}

/* A ray that enters the volume beyond the surface's value meets a cut face, which shows the values
 * there. */
static cvol_ray_lit cut_face(const cvol_ray_job *job, double value)
{
    const double level = (value - job->cuts[0]) / (job->cuts[1] - job->cuts[0]);
    return (cvol_ray_lit){.factor = fmin(fmax(level, 0), 1), .density = 1};
}

static cvol_ray_seen surface(const cvol_ray_job *job, const cvol_ray_path *path)
{
    const double length = (double)path->steps + path->rest;
    cvol_ray_seen light = no_light;
    double before = 0, at = 0, value;
    while (!is_within(&value, job, path, at)) {
        if (!(at < length))
            return light;
        before = at;
        at = at + 1 < length ? at + 1 : length;
    }
    while (at - before > 1e-4) {
        const double middle = (before + at) / 2;
        if (is_within(&value, job, path, middle))
            at = middle;
        else
            before = middle;
    }
    is_within(&value, job, path, at);
    const int is_cut = !(at > 0) && !job->state->field.mask;
    const cvol_ray_lit lit = is_cut ? cut_face(job, value) : light_at(job, path, at, value);
    for (int c = 0; c < 3; c++)
        light.rgb[c] = job->surface->colour[c] * lit.factor + lit.gloss;
    light.through = 0;
    light.depth = depth_at(path, at);
    return light;
}

/* NaN if no sample along the ray has a value; also below. */
static double mean_along(const cvol_ray_job *job, const cvol_ray_path *path)
{
    double values[CVOL_RAY_RUN], covers[CVOL_RAY_RUN], sum = 0, weight = 0;
    for (size_t first = 0; first < path->steps; first += CVOL_RAY_RUN) {
        size_t count = run_length(path, first);
        fetch_run(values, covers, job, path, first, count);
        for (size_t k = 0; k < count; k++) {
            sum += covers[k] * values[k];
            weight += covers[k];
        }
    }
    sum += path->rest * fetch_rest(covers, job, path) * covers[0];
    weight += path->rest * covers[0];
    return weight > 0 ? sum / weight : NAN;
}

/* Over places with at least half a cover; the smallest, if sign is -1. */
static double largest_along(const cvol_ray_job *job, const cvol_ray_path *path, double sign)
{
    double values[CVOL_RAY_RUN], covers[CVOL_RAY_RUN], rest = fetch_rest(covers, job, path);
    double largest = covers[0] >= 0.5 ? rest : NAN;
    for (size_t first = 0; first < path->steps; first += CVOL_RAY_RUN) {
        size_t count = run_length(path, first);
        fetch_run(values, covers, job, path, first, count);
        for (size_t k = 0; k < count; k++)
            if (covers[k] >= 0.5 && !(sign * values[k] <= sign * largest))
                largest = values[k];
    }
    return largest;
}

/* The ray's grey level within the samples' range; a volume of one value is black. Empty if no
 * sample has a value. */
static cvol_ray_seen grey(const cvol_ray_job *job, const cvol_ray_path *path)
{
    const cvol_ray_field *field = &job->state->field;
    const double sign = job->mode == CVOL_MODE_MIN ? -1 : 1;
    double value = job->mode == CVOL_MODE_XRAY ? mean_along(job, path)
                                               : largest_along(job, path, sign);
    if (isnan(value))
        return no_light;
    double level = field->max > field->min ? (value - field->min) / (field->max - field->min) : 0;
    return (cvol_ray_seen){.rgb = {level, level, level}};
}

cvol_ray_seen cvol_ray_cast(const cvol_ray_job *job, int i, int j)
{
    cvol_ray_path path;
    if (!cvol_ray_path_make(&path, job, i, j))
        return no_light;
    return job->mode == CVOL_MODE_COMPOSITE ? composite(job, &path)
           : job->mode == CVOL_MODE_ISO     ? surface(job, &path)
                                            : grey(job, &path);
}
