/* One ray of the ray engine (cast.h).
 *
 * Each pixel's ray is cut to the box of sample centres, or to the part of it inside the clip. An
 * axis of one sample has the thickness of its spacing, so a single slice is a thin slab. The cut
 * ray is divided into intervals of one step, each with one sample in its middle; the last is
 * shorter, and weighted by its own length:
 *
 *     composite   I += (1 - A) c a,  A += (1 - A) a  front to back, where c and
 *                 a = 1 - (1 - opacity)^(length / mean spacing) come from the transfer function
 *                 at the interpolated sample; then I += (1 - A) background
 *     xray        sum of sample length / sum of length
 *     mip         the largest sample; min the smallest
 *     iso         the first place whose sample has the value or more, lit; found by halving the
 *                 step that leads to it
 *
 * A ray ends early when its transmittance is below 1/1024: a quarter of a grey level. */
#include "render/ray/cast.h"

#include <math.h>

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

static void add_light(cvol_ray_seen *light, const double colour[4], double opacity)
{
    for (int c = 0; c < 3; c++)
        light->rgb[c] += light->through * opacity * colour[c];
    light->through *= 1 - opacity;
}

/* Lights the colour; returns the density `place` steps along the ray. */
static double light_up(double colour[3], const cvol_ray_job *job, const ray_line *line,
                       double place, double value)
{
    const cvol_ray_reader reader = {&job->state->field, job->state->line, job->state->masked};
    double at[3];
    for (int a = 0; a < 3; a++)
        at[a] = line->entry[a] + place * line->delta[a];
    return cvol_ray_light_up(colour, job->light, &reader, at, value);
}

static double depth_at(const ray_line *line, double place)
{
    return line->depth + place * line->rise;
}

/* Adds one sample, `place` steps along the ray, in the middle of part of a step; a share of the
 * part has a value. */
static void add_sample(cvol_ray_seen *light, const cvol_ray_job *job, const ray_line *line,
                       double value, double place, double length, double cover)
{
    double share = length * cover;
    double colour[4];
    cvol_ray_table_at(colour, &job->table, value);
    if (job->light && colour[3] > 0)
        share *= light_up(colour, job, line, place, value);
    const double before = light->through;
    add_light(light, colour, share < 1 ? cvol_opacity_over(colour[3], share) : colour[3]);
    if (before > 0.5 && light->through <= 0.5)
        light->depth = depth_at(
            line, place + length * ((before - 0.5) / (before - light->through) - 0.5));
}

static cvol_ray_seen composite(const cvol_ray_job *job, const ray_line *line)
{
    cvol_ray_seen light = no_light;
    double values[RUN], covers[RUN], cover;
    for (size_t first = 0; first < line->steps; first += RUN) {
        size_t count = run_length(line, first);
        fetch_run(values, covers, job, line, first, count);
        for (size_t k = 0; k < count; k++) {
            add_sample(&light, job, line, values[k], (double)(first + k) + 0.5, 1, covers[k]);
            if (light.through < TRANSMITTANCE_MIN)
                return light;
        }
    }
    const double value = fetch_rest(&cover, job, line);
    add_sample(&light, job, line, value, (double)line->steps + line->rest / 2, line->rest, cover);
    return light;
}

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
    double colour[4] = {job->surface->colour[0], job->surface->colour[1], job->surface->colour[2],
                        1};
    light_up(colour, job, line, at, value);
    add_light(&light, colour, 1);
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
