/* The ray engine: plain ray casting of dense samples, the reference for all other engines. (Levoy,
 * Display of surfaces from volume data, 1988; Max, Optical models for direct volume rendering,
 * 1995.)
 *
 * Every pixel is computed separately and in one order (cast.c), so the picture does not depend on
 * the number of threads. */
#include "render/ray/cast.h"

#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/ray/certify.h"
#include "render/ray/scattering.h"

/* ---- state ----------------------------------------------------------------------------- */

int cvol_ray_create(cvol_context *context, void **state, const cvol_volume *volume,
                    const uint8_t *mask)
{
    *state = NULL;
    int code = cvol_grid_check(context, &volume->grid, "volume");
    cvol_volume_statistics stats = {0};
    if (!code && mask)
        cvol_ray_field_bound(&stats.min, &stats.max, volume, mask);
    else if (!code)
        code = cvol_volume_compute_statistics(context, &stats, volume);
    if (code)
        return code;
    cvol_ray_state *ray = calloc(1, sizeof *ray);
    if (!ray)
        return cvol_fail_memory(context, sizeof *ray, "a renderer");
    ray->grid = volume->grid;
    ray->field = cvol_ray_field_make(volume, stats.min, stats.max);
    ray->field.mask = mask;
    ray->volume = volume;
    ray->line = cvol_ray_line_of(volume->grid.type);
    ray->masked = cvol_ray_masked_of(volume->grid.type);
    *state = ray;
    return CVOL_OK;
}

static void ray_free(void *state)
{
    cvol_ray_state *ray = state;
    cvol_transfer_free(ray->transfer);
    cvol_reach_free(&ray->reach);
    free(ray);
}

static int ray_set_transfer(cvol_context *context, void *state, const cvol_transfer *transfer)
{
    cvol_ray_state *ray = state;
    cvol_transfer *copy;
    int code = cvol_transfer_copy(context, &copy, transfer);
    if (code)
        return code;
    cvol_transfer_free(ray->transfer);
    ray->transfer = copy;
    cvol_reach_forget(&ray->reach);
    return CVOL_OK;
}

/* ---- pictures -------------------------------------------------------------------------- */

static void put_bytes(uint8_t rgba[4], const cvol_ray_seen *light, const double background[3])
{
    for (int c = 0; c < 3; c++)
        rgba[c] = cvol_ray_to_byte(light->rgb[c] + light->through * background[c]);
    rgba[3] = 255;
}

static void put_values(float values[4], const cvol_ray_seen *light)
{
    for (int c = 0; c < 3; c++)
        values[c] = (float)light->rgb[c];
    values[3] = (float)(1 - light->through);
}

static void draw_row(cvol_image *image, const cvol_ray_job *job, int j)
{
    const size_t first = 4 * (size_t)image->width * (size_t)j;
    for (int i = 0; i < image->width; i++) {
        const cvol_ray_seen light = cvol_ray_cast(job, i, j);
        if (image->values)
            put_values(image->values + first + 4 * (size_t)i, &light);
        else
            put_bytes(image->rgba + first + 4 * (size_t)i, &light, job->background);
        if (image->depth)
            image->depth[first / 4 + (size_t)i] = (float)light.depth;
    }
}

/* In bands; between them it reports progress and checks for cancellation. */
static int draw_rows(cvol_context *context, cvol_image *image, const cvol_ray_job *job)
{
    int threads = cvol_context_threads(context), code = CVOL_OK;
    for (int first = 0; first < image->height && !code; first += CVOL_RAY_BAND) {
        int end = image->height - first < CVOL_RAY_BAND ? image->height : first + CVOL_RAY_BAND;
#pragma omp parallel for schedule(dynamic) num_threads(threads)
        for (int j = first; j < end; j++)
            draw_row(image, job, j);
        code = cvol_report_progress(context, "rendering", (double)end / image->height);
    }
    return code;
}

static double factor_in_cells(const void *source, const double place[3])
{
    return cvol_reach_at(source, place);
}

/* Finds factors of light, the exposure, and cuts of the view. */
static int find_reach(cvol_context *context, cvol_ray_state *ray, cvol_view *view,
                      const cvol_render_options *options)
{
    int code = CVOL_OK;
    if (!cvol_reach_suits(options))
        return CVOL_OK;
    if (!ray->reach.coarse.values) {
        code = cvol_coarse_of_volume(context, &ray->reach.coarse, ray->volume, ray->field.mask);
        if (!code)
            code = cvol_coarse_surround(context, &ray->reach.coarse);
    }
    if (!code)
        code = cvol_reach_find_cuts(context, &ray->reach, view, &ray->grid, ray->transfer, options);
    return code ? code
                : cvol_reach_find(context, &ray->reach, &ray->grid, ray->transfer, view, options);
}

static void use_reach(cvol_ray_light *light, const cvol_ray_state *ray,
                      const cvol_render_options *options)
{
    if (!cvol_reach_suits(options))
        return;
    light->factor_at = factor_in_cells;
    light->source = &ray->reach;
    light->shading.ambient *= ray->reach.exposure;
    light->shading.diffuse *= ray->reach.exposure;
    light->shading.specular *= ray->reach.exposure;
    light->fill *= ray->reach.exposure;
}

/* Prepares rays of light, if the options want them. */
static int find_scattering(cvol_context *context, cvol_ray_scattering *scattering,
                           cvol_ray_light *light, const cvol_ray_job *job,
                           const cvol_render_options *options)
{
    if (!light->factor_at || !options->illumination.samples)
        return CVOL_OK;
    const double *length = job->state->reach.coarse.length;
    light->factor_at = cvol_ray_scattering_at;
    light->source = scattering;
    return cvol_ray_scattering_make(context, scattering, job, options,
                                    (length[0] + length[1] + length[2]) / 3 *
                                        job->view->mean_spacing);
}

static int ray_draw(cvol_context *context, void *state, cvol_image *image, const cvol_view *view,
                    const cvol_render_options *options)
{
    cvol_ray_state *ray = state;
    cvol_ray_light light;
    cvol_ray_scattering scattering = {.job = NULL};
    cvol_view cut = *view;
    int code = find_reach(context, ray, &cut, options);
    if (code)
        return code;
    cvol_ray_job job = cvol_ray_job_make(ray, &light, &cut, options);
    use_reach(&light, ray, options);
    code = find_scattering(context, &scattering, &light, &job, options);
    if (!code && job.mode == CVOL_MODE_COMPOSITE)
        code = cvol_ray_table_make(context, &job.table, ray->transfer, ray->field.min,
                                   ray->field.max, job.table.step);
    if (!code)
        code = draw_rows(context, image, &job);
    cvol_ray_table_free(&job.table);
    cvol_ray_scattering_free(&scattering);
    return code;
}

void cvol_ray_range(const void *state, double range[2])
{
    const cvol_ray_field *field = &((const cvol_ray_state *)state)->field;
    range[0] = field->min;
    range[1] = field->max;
}

const cvol_engine_table cvol_ray_engine = {.free = ray_free,
                                           .set_transfer = ray_set_transfer,
                                           .draw = ray_draw,
                                           .certify = cvol_ray_certify,
                                           .has_clip = 1,
                                           .has_perspective = 1,
                                           .has_depth = 1,
                                           .has_illumination = 1};
