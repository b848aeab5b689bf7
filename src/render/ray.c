/* The ray engine: plain ray casting of dense samples, the truth that others are measured against.
 *
 * Each pixel's ray is cut to the box of sample centres, or what the clip leaves of it; an axis of
 * one sample is as thick as its spacing, so that a single slice is a thin slab. Along the cut ray
 * lie intervals of one step, each with one sample in its middle; the last is shorter, and weighted
 * by its own length:
 *
 *     composite   I += (1 - A) c a,  A += (1 - A) a  front to back, where c and
 *                 a = 1 - (1 - opacity)^(length / mean spacing) are the transfer function's at
 *                 the interpolated sample; then I += (1 - A) background
 *     xray        sum of sample length / sum of length
 *     mip         the largest sample; min the smallest
 *     iso         the first place whose sample has the value or more, found by halving the step
 * that leads to it, lit
 *
 * (Levoy, Display of surfaces from volume data, 1988; Max, Optical models for direct volume
 * rendering, 1995.) A ray ends early when less than 1/1024 of the light would still come through:
 * a quarter of a grey level. Every pixel is worked out on its own and in one order, so that the
 * picture is the same for any number of threads.
 */
#include "render/engine.h"

#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/ray_light.h"
#include "render/ray_sample.h"
#include "render/ray_table.h"
#include "render/view_ray.h"

#define DEFAULT_STEP 0.5
#define TRANSMITTANCE_MIN (1.0 / 1024)

/* Samples that are fetched at a time. */
#define RUN 64

/* Rows between two reports of progress. */
#define BAND 32

typedef struct ray_state {
    cvol_grid grid;
    cvol_ray_field field;
    cvol_ray_line_fn line;
    cvol_ray_masked_fn masked; /* with a mask */
    cvol_transfer *transfer;
} ray_state;

/* What all pixels of one picture share. */
typedef struct ray_job {
    const ray_state *state;
    const cvol_view *view;
    cvol_mode mode;
    double background[3];
    double step; /* world length of one step */
    cvol_ray_table table;
    const cvol_ray_light *light; /* NULL: colours are as they are */
    const cvol_surface *surface;
} ray_job;

/* A ray within what is drawn: `steps` whole steps and then `rest` of one, 0 < rest <= 1. */
typedef struct ray_line {
    double entry[3]; /* in sample indices */
    double delta[3]; /* one step */
    size_t steps;
    double rest;
    double depth, rise; /* of the entry, and what a step adds */
} ray_line;

/* ---- state ----------------------------------------------------------------------------- */

int cvol_ray_create(cvol_context *context, void **state, const cvol_volume *volume,
                    const uint8_t *mask)
{
    *state = NULL;
    int code = cvol_grid_check(context, &volume->grid, "volume");
    cvol_sample_stats stats = {0};
    if (!code && mask)
        cvol_ray_field_bound(&stats.min, &stats.max, volume, mask);
    else if (!code)
        code = cvol_volume_stats(context, &stats, volume);
    if (code)
        return code;
    ray_state *ray = calloc(1, sizeof *ray);
    if (!ray)
        return cvol_fail_memory(context, sizeof *ray, "a renderer");
    ray->grid = volume->grid;
    ray->field = cvol_ray_field_make(volume, stats.min, stats.max);
    ray->field.mask = mask;
    ray->line = cvol_ray_line_of(volume->grid.type);
    ray->masked = cvol_ray_masked_of(volume->grid.type);
    *state = ray;
    return CVOL_OK;
}

static void ray_free(void *state)
{
    ray_state *ray = state;
    cvol_transfer_free(ray->transfer);
    free(ray);
}

static int ray_set_transfer(cvol_context *context, void *state, const cvol_transfer *transfer)
{
    ray_state *ray = state;
    cvol_transfer *copy;
    int code = cvol_transfer_copy(context, &copy, transfer);
    if (code)
        return code;
    cvol_transfer_free(ray->transfer);
    ray->transfer = copy;
    return CVOL_OK;
}

/* ---- one ray --------------------------------------------------------------------------- */

/* 1 if the ray of pixel (i, j) runs through what is drawn. */
static int cast(ray_line *line, const ray_job *job, int i, int j)
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

static void fetch(double *out, double *cover, const ray_job *job, const ray_line *line,
                  double place, size_t count)
{
    const ray_state *state = job->state;
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

/* The samples in the middle of the whole steps first .. first + count - 1, and how much of each is
 * of samples that have a value. */
static void fetch_run(double *out, double *cover, const ray_job *job, const ray_line *line,
                      size_t first, size_t count)
{
    fetch(out, cover, job, line, (double)first + 0.5, count);
}

/* The sample in the middle of the rest. */
static double fetch_rest(double *cover, const ray_job *job, const ray_line *line)
{
    double value;
    fetch(&value, cover, job, line, (double)line->steps + line->rest / 2, 1);
    return value;
}

static size_t run_length(const ray_line *line, size_t first)
{
    return line->steps - first < RUN ? line->steps - first : RUN;
}

/* Light that has reached the eye, the share that still comes through, and how deep half of it was
 * lost: infinity where it never was. */
typedef struct ray_light {
    double rgb[3], through, depth;
} ray_light;

static const ray_light no_light = {{0, 0, 0}, 1, INFINITY};

static void add_light(ray_light *light, const double colour[4], double opacity)
{
    for (int c = 0; c < 3; c++)
        light->rgb[c] += light->through * opacity * colour[c];
    light->through *= 1 - opacity;
}

/* How thick matter is, `place` steps along the ray. */
static double light_up(double colour[3], const ray_job *job, const ray_line *line, double place,
                       double value)
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

/* One sample, `place` steps along the ray, in the middle of so much of a step, of which a share has
 * a value. */
static void add_sample(ray_light *light, const ray_job *job, const ray_line *line, double value,
                       double place, double length, double cover)
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

static ray_light composite(const ray_job *job, const ray_line *line)
{
    ray_light light = no_light;
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

/* Whether the surface is at or before a place along the ray, of steps; its value is kept. */
static int is_within(double *value, const ray_job *job, const ray_line *line, double place)
{
    double cover;
    fetch(value, &cover, job, line, place, 1);
    return cover >= 0.5 && *value >= job->surface->value;
}

static ray_light surface(const ray_job *job, const ray_line *line)
{
    const double length = (double)line->steps + line->rest;
    ray_light light = no_light;
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

/* NaN where no sample along the ray has a value; so below. */
static double mean_along(const ray_job *job, const ray_line *line)
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

/* Of places of which at least half has a value; the smallest, if sign is -1. */
static double largest_along(const ray_job *job, const ray_line *line, double sign)
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

/* ---- pictures -------------------------------------------------------------------------- */

/* Anything but a number above 0 is black. */
static uint8_t to_byte(double level)
{
    if (!(level > 0))
        return 0;
    return level < 1 ? (uint8_t)(level * 255 + 0.5) : 255;
}

/* The ray's level within the samples' range; a volume of one value is black. Nothing where no
 * sample has a value. */
static ray_light grey(const ray_job *job, const ray_line *line)
{
    const cvol_ray_field *field = &job->state->field;
    const double sign = job->mode == CVOL_MODE_MIN ? -1 : 1;
    double value = job->mode == CVOL_MODE_XRAY ? mean_along(job, line)
                                               : largest_along(job, line, sign);
    if (isnan(value))
        return no_light;
    double level = field->max > field->min ? (value - field->min) / (field->max - field->min) : 0;
    return (ray_light){.rgb = {level, level, level}};
}

static ray_light light_of(const ray_job *job, int i, int j)
{
    ray_line line;
    if (!cast(&line, job, i, j))
        return no_light;
    return job->mode == CVOL_MODE_COMPOSITE ? composite(job, &line)
           : job->mode == CVOL_MODE_ISO     ? surface(job, &line)
                                            : grey(job, &line);
}

static void put_bytes(uint8_t rgba[4], const ray_light *light, const double background[3])
{
    for (int c = 0; c < 3; c++)
        rgba[c] = to_byte(light->rgb[c] + light->through * background[c]);
    rgba[3] = 255;
}

static void put_values(float values[4], const ray_light *light)
{
    for (int c = 0; c < 3; c++)
        values[c] = (float)light->rgb[c];
    values[3] = (float)(1 - light->through);
}

static void draw_row(cvol_image *image, const ray_job *job, int j)
{
    const size_t first = 4 * (size_t)image->width * (size_t)j;
    for (int i = 0; i < image->width; i++) {
        const ray_light light = light_of(job, i, j);
        if (image->values)
            put_values(image->values + first + 4 * (size_t)i, &light);
        else
            put_bytes(image->rgba + first + 4 * (size_t)i, &light, job->background);
        if (image->depth)
            image->depth[first / 4 + (size_t)i] = (float)light.depth;
    }
}

/* In bands, between which progress is told and a wish to stop is heard. */
static int draw_rows(cvol_context *context, cvol_image *image, const ray_job *job)
{
    int threads = cvol_context_threads(context), code = CVOL_OK;
    for (int first = 0; first < image->height && !code; first += BAND) {
        int end = image->height - first < BAND ? image->height : first + BAND;
#pragma omp parallel for schedule(dynamic) num_threads(threads)
        for (int j = first; j < end; j++)
            draw_row(image, job, j);
        code = cvol_report_progress(context, "rendering", (double)end / image->height);
    }
    return code;
}

static int ray_draw(cvol_context *context, void *state, cvol_image *image, const cvol_view *view,
                    const cvol_render_options *options)
{
    const ray_state *ray = state;
    double step = options->step_voxels > 0 ? options->step_voxels : DEFAULT_STEP;
    ray_job job = {.state = ray, .view = view, .mode = options->mode};
    job.step = step * view->mean_spacing;
    for (int c = 0; c < 3; c++)
        job.background[c] = options->background[c];
    const cvol_ray_light light = cvol_ray_light_make(&options->shading, view, &ray->grid);
    job.surface = &options->surface;
    if (options->shading.on || job.mode == CVOL_MODE_ISO)
        job.light = &light;
    int code = CVOL_OK;
    if (job.mode == CVOL_MODE_COMPOSITE)
        code = cvol_ray_table_make(context, &job.table, ray->transfer, ray->field.min,
                                   ray->field.max, step);
    if (!code)
        code = draw_rows(context, image, &job);
    free(job.table.entries);
    return code;
}

void cvol_ray_range(const void *state, double range[2])
{
    const cvol_ray_field *field = &((const ray_state *)state)->field;
    range[0] = field->min;
    range[1] = field->max;
}

const cvol_engine_table cvol_ray_engine = {.free = ray_free,
                                           .set_transfer = ray_set_transfer,
                                           .draw = ray_draw,
                                           .has_clip = 1,
                                           .has_perspective = 1,
                                           .has_depth = 1};
