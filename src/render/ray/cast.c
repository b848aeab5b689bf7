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
#include <string.h>

#include "base/context.h"
#include "render/view/view_ray.h"

#define TRANSMITTANCE_MIN (1.0 / 1024)

/* Samples that are fetched together. */
#define RUN 64

/* A ray within the drawn box: `steps` whole steps and then `rest` of one, 0 < rest <= 1. */
typedef struct ray_line {
    double entry[3]; /* in sample indices */
    double delta[3]; /* one step */
    size_t steps;
    double rest;
    double depth, rise; /* of the entry, and its change per step */
} ray_line;

/* 1 if the ray of pixel (i, j) meets the drawn box. */
static int cast(ray_line *line, const cvol_ray_job *job, int i, int j)
{
    cvol_view_ray ray;
    if (!cvol_view_ray_make(&ray, job->view, job->state->grid.spacing, i, j))
        return 0;
    const double count = (ray.far - ray.near) / job->step;
    if (!(count > 0))
        return 0;
    for (int a = 0; a < 3; a++) {
        line->entry[a] = ray.start[a] + ray.near * ray.direction[a];
        line->delta[a] = ray.direction[a] * job->step;
    }
    line->steps = (size_t)(ceil(count) - 1);
    line->rest = count - (double)line->steps;
    line->depth = ray.depth + ray.near * ray.rise;
    line->rise = job->step * ray.rise;
    return 1;
}

static void fetch(double *out, double *cover, const cvol_ray_job *job, const ray_line *line,
                  double place, size_t count)
{
    const cvol_ray_state *state = job->state;
    double start[3];
    for (int a = 0; a < 3; a++)
        start[a] = line->entry[a] + place * line->delta[a];
    if (state->field.mask) {
        state->masked(out, cover, &state->field, start, line->delta, count);
        return;
    }
    state->line(out, &state->field, start, line->delta, count);
    for (size_t k = 0; k < count; k++)
        cover[k] = 1;
}

/* The samples in the middle of the whole steps first .. first + count - 1, and the share of each
 * that has a value. */
static void fetch_run(double *out, double *cover, const cvol_ray_job *job, const ray_line *line,
                      size_t first, size_t count)
{
    fetch(out, cover, job, line, (double)first + 0.5, count);
}

/* The sample in the middle of the rest. */
static double fetch_rest(double *cover, const cvol_ray_job *job, const ray_line *line)
{
    double value;
    fetch(&value, cover, job, line, (double)line->steps + line->rest / 2, 1);
    return value;
}

static size_t run_length(const ray_line *line, size_t first)
{
    return line->steps - first < RUN ? line->steps - first : RUN;
}

static const cvol_ray_seen no_light = {{0, 0, 0}, 1, INFINITY};

static cvol_ray_lit light_at(const cvol_ray_job *job, const ray_line *line, double place,
                             double value)
{
    const cvol_ray_reader reader = {&job->state->field, job->state->line, job->state->masked};
    double at[3];
    for (int a = 0; a < 3; a++)
        at[a] = line->entry[a] + place * line->delta[a];
    return cvol_ray_light_at(job->light, &reader, at, value);
}

static double depth_at(const ray_line *line, double place)
{
    return line->depth + place * line->rise;
}

/* ---- composite ------------------------------------------------------------------------- */

/* A value along the ray, its cover, and its cell of the table. Without a cover it has no value. */
typedef struct sample {
    double value, cover;
    size_t cell;
} sample;

static const sample no_sample = {0, 0, 0};

static sample make_sample(const cvol_ray_job *job, double value, double cover)
{
    return (sample){value, cover, cvol_ray_table_cell(&job->table, value)};
}

static sample fetch_one(const cvol_ray_job *job, const ray_line *line, double place)
{
    double value, cover;
    fetch(&value, &cover, job, line, place, 1);
    return make_sample(job, value, cover);
}

/* The value between two samples, a share t of their distance behind the first. */
static sample between(const cvol_ray_job *job, const sample *a, const sample *b, double t)
{
    return make_sample(job, a->value + (b->value - a->value) * t, fmin(a->cover, b->cover));
}

/* The value half way between the second and the third of four samples: that of the cubic
 * polynomial through all, limited to values between these two. */
static sample halfway(const cvol_ray_job *job, const sample s[4])
{
    const double a = s[1].value, b = s[2].value, cover = fmin(s[1].cover, s[2].cover);
    if (!(s[0].cover > 0 && s[3].cover > 0))
        return between(job, &s[1], &s[2], 0.5);
    const double cubic = (9 * (a + b) - (s[0].value + s[3].value)) / 16;
    return make_sample(job, fmin(fmax(cubic, fmin(a, b)), fmax(a, b)), cover);
}

/* The cells of three samples, of which the second has a value. */
typedef struct cells {
    size_t lowest, highest;
} cells;

static cells cells_of(const sample *a, const sample *b, const sample *c)
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

/* An end without a value has that of the middle. */
static sample end_of(sample end, const sample *middle)
{
    return end.cover > 0 ? end : *middle;
}

/* Adds the interval around s[2], which begins `place` steps along the ray. Its ends are half way
 * to the neighbours, or these where they are not NULL. */
static void add_interval(cvol_ray_seen *light, const cvol_ray_job *job, const ray_line *line,
                         const sample s[5], const sample *front, const sample *back, double place,
                         double length)
{
    const cvol_ray_table *table = &job->table;
    const sample *middle = &s[2], *before = front ? front : &s[1], *after = back ? back : &s[3];
    if (!(middle->cover > 0))
        return;
    const cells around = cells_of(before, middle, after);
    if (cvol_ray_table_hides(table, around.lowest, around.highest))
        return;
    const double rise = fmax(fabs(middle->value - before->value),
                             fabs(after->value - middle->value));
    int is_smooth = cvol_ray_table_is_smooth(table, around.lowest, around.highest, rise);
    double values[3] = {0, middle->value, 0};
    if (!is_smooth) {
        const sample ends[2] = {end_of(front ? *front : halfway(job, s), middle),
                                end_of(back ? *back : halfway(job, s + 1), middle)};
        const cells within = cells_of(&ends[0], middle, &ends[1]);
        if (cvol_ray_table_hides(table, within.lowest, within.highest))
            return;
        values[0] = ends[0].value;
        values[2] = ends[1].value;
        is_smooth = cvol_ray_table_is_smooth(
            table, within.lowest, within.highest,
            2 * fmax(fabs(values[1] - values[0]), fabs(values[2] - values[1])));
    }
    cvol_ray_interval interval = {.share = length * middle->cover,
                                  .lit = {1, 0, 1},
                                  .depth = depth_at(line, place),
                                  .rise = length * line->rise};
    if (job->light)
        interval.lit = light_at(job, line, place + length / 2, middle->value);
    interval.share *= interval.lit.density;
    if (is_smooth)
        cvol_ray_interval_add(light, table, &interval, middle->value);
    else
        cvol_ray_interval_add_divided(light, table, &interval, values);
}

static cvol_ray_seen composite(const cvol_ray_job *job, const ray_line *line)
{
    cvol_ray_seen light = no_light;
    const size_t steps = line->steps;
    double values[RUN], covers[RUN];
    sample window[RUN + 4] = {no_sample, no_sample, no_sample, no_sample};
    const sample entry = fetch_one(job, line, 0);
    for (size_t first = 0; first < steps; first += RUN) {
        const size_t count = run_length(line, first);
        fetch_run(values, covers, job, line, first, count);
        for (size_t k = 0; k < count; k++) {
            window[k + 4] = make_sample(job, values[k], covers[k]);
            if (first + k < 2)
                continue;
            const size_t at = first + k - 2;
            add_interval(&light, job, line, window + k, at ? NULL : &entry, NULL, (double)at, 1);
            if (light.through < TRANSMITTANCE_MIN)
                return light;
        }
        memmove(window, window + count, 4 * sizeof *window);
    }
    const double whole = (double)steps;
    const sample rest = fetch_one(job, line, whole + line->rest / 2),
                 end = fetch_one(job, line, whole + line->rest),
                 last = between(job, &window[3], &rest, 1 / (1 + line->rest));
    window[4] = window[5] = no_sample;
    if (steps > 1)
        add_interval(&light, job, line, window, steps > 2 ? NULL : &entry, NULL, whole - 2, 1);
    if (steps > 0)
        add_interval(&light, job, line, window + 1, steps > 1 ? NULL : &entry, &last, whole - 1, 1);
    window[2] = rest;
    add_interval(&light, job, line, window, steps > 0 ? &last : &entry, &end, whole, line->rest);
    return light;
}

/* ---- other modes ----------------------------------------------------------------------- */

/* Returns 1 if the surface is at or before a place along the ray, in steps; stores the value
 * there. */
static int is_within(double *value, const cvol_ray_job *job, const ray_line *line, double place)
{
    double cover;
    fetch(value, &cover, job, line, place, 1);
    return cover >= 0.5 && *value >= job->surface->value;
}

static cvol_ray_seen surface(const cvol_ray_job *job, const ray_line *line)
{
    const double length = (double)line->steps + line->rest;
    cvol_ray_seen light = no_light;
    double before = 0, at = 0, value;
    while (!is_within(&value, job, line, at)) {
        if (!(at < length))
            return light;
        before = at;
        at = at + 1 < length ? at + 1 : length;
    }
    while (at - before > 1e-4) {
        const double middle = (before + at) / 2;
        if (is_within(&value, job, line, middle))
            at = middle;
        else
            before = middle;
    }
    is_within(&value, job, line, at);
    const cvol_ray_lit lit = light_at(job, line, at, value);
    for (int c = 0; c < 3; c++)
        light.rgb[c] = job->surface->colour[c] * lit.factor + lit.gloss;
    light.through = 0;
    light.depth = depth_at(line, at);
    return light;
}

/* NaN if no sample along the ray has a value; also below. */
static double mean_along(const cvol_ray_job *job, const ray_line *line)
{
    double values[RUN], covers[RUN], sum = 0, weight = 0;
    for (size_t first = 0; first < line->steps; first += RUN) {
        size_t count = run_length(line, first);
        fetch_run(values, covers, job, line, first, count);
        for (size_t k = 0; k < count; k++) {
            sum += covers[k] * values[k];
            weight += covers[k];
        }
    }
    sum += line->rest * fetch_rest(covers, job, line) * covers[0];
    weight += line->rest * covers[0];
    return weight > 0 ? sum / weight : NAN;
}

/* Over places with at least half a cover; the smallest, if sign is -1. */
static double largest_along(const cvol_ray_job *job, const ray_line *line, double sign)
{
    double values[RUN], covers[RUN], rest = fetch_rest(covers, job, line);
    double largest = covers[0] >= 0.5 ? rest : NAN;
    for (size_t first = 0; first < line->steps; first += RUN) {
        size_t count = run_length(line, first);
        fetch_run(values, covers, job, line, first, count);
        for (size_t k = 0; k < count; k++)
            if (covers[k] >= 0.5 && !(sign * values[k] <= sign * largest))
                largest = values[k];
    }
    return largest;
}

/* The ray's grey level within the samples' range; a volume of one value is black. Empty if no
 * sample has a value. */
static cvol_ray_seen grey(const cvol_ray_job *job, const ray_line *line)
{
    const cvol_ray_field *field = &job->state->field;
    const double sign = job->mode == CVOL_MODE_MIN ? -1 : 1;
    double value = job->mode == CVOL_MODE_XRAY ? mean_along(job, line)
                                               : largest_along(job, line, sign);
    if (isnan(value))
        return no_light;
    double level = field->max > field->min ? (value - field->min) / (field->max - field->min) : 0;
    return (cvol_ray_seen){.rgb = {level, level, level}};
}

cvol_ray_seen cvol_ray_cast(const cvol_ray_job *job, int i, int j)
{
    ray_line line;
    if (!cast(&line, job, i, j))
        return no_light;
    return job->mode == CVOL_MODE_COMPOSITE ? composite(job, &line)
           : job->mode == CVOL_MODE_ISO     ? surface(job, &line)
                                            : grey(job, &line);
}
