/* Ambient occlusion, shadows and exposure (reach.h).
 *
 * Ambient light comes from all directions. For each cell it is the mean transmittance of six cones,
 * one along each half of an axis, within a limited distance: what lies further away hides less.
 * The shadow of a cell is its transmittance towards the light. With the strengths a and s of
 * occlusion and shadows, and S the part of light that is not ambient, the factor of light is
 *
 *     (1 - a + a min(ambient / OPEN, 1)) (1 - s S + s S shadow)
 *
 * where OPEN is what a convex corner sees.
 *
 * Then each cell gets a mean of those around, in which the transparent ones count.
 *
 * The exposure is the ratio of the brightness without light to that with it, over the cells that
 * the eye sees, each with the weight of its opacity behind what is before it. It is up to a tenth
 * less where much would be white. */
#include "render/light/reach.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/light/extinction.h"
#include "render/light/sweep.h"
#include "render/view/shading.h"

/* The distance at which matter hides 1/e of what it would nearby, as a share of the longest side of
 * the volume. */
#define REACH 0.1
/* A flat opaque face sees about 0.4: 1 above, about 0.3 on four sides, 0 below; a convex corner
 * about this: */
#define OPEN 0.67
/* The least part of light that occlusion leaves. */
#define DARKEST 0.15
/* The weight of opaque cells where factors are spread. */
#define OPAQUE_WEIGHT 0.02f
#define DIMMER 0.9
#define BURNT 0.01
#define MUCH_BURNT 0.15
#define DIMMEST 0.75
/* Levels of brightness that are counted, up to the last. */
#define LEVELS 256
#define LEVEL_MOST 4.0
#define EXPOSURE_MIN 0.5
#define EXPOSURE_MAX 3.0

int cvol_reach_suits(const cvol_render_options *options)
{
    const int lit = options->mode == CVOL_MODE_ISO ||
                    (options->mode == CVOL_MODE_COMPOSITE && options->shading.on);
    return lit && cvol_illumination_needs_volume(&options->illumination);
}

void cvol_reach_forget(cvol_reach *reach)
{
    reach->is_known = 0;
}

void cvol_reach_free(cvol_reach *reach)
{
    cvol_coarse_free(&reach->coarse);
    free(reach->extinction);
    free(reach->ambient);
    free(reach->factors);
    *reach = (cvol_reach){.is_known = 0};
}

static int allocate(cvol_context *context, cvol_reach *reach)
{
    const size_t count = cvol_coarse_count(&reach->coarse);
    float **const arrays[] = {&reach->extinction, &reach->ambient, &reach->factors};
    for (int k = 0; k < 3; k++)
        if (!*arrays[k] && !(*arrays[k] = cvol_allocate(count, sizeof(float))))
            return cvol_fail_memory(context, count * sizeof(float), "the light in a volume");
    return CVOL_OK;
}

/* ---- ambient light and shadows ----------------------------------------------------------- */

static void add_cone(void *user, const float *depths, size_t first, size_t count, size_t stride)
{
    float *ambient = user;
    for (size_t i = 0; i < count; i++)
        ambient[first + i * stride] += 1.0f / 6 * cvol_sweep_transmittance(depths[i]);
}

static int find_ambient(cvol_context *context, cvol_reach *reach)
{
    const cvol_coarse *coarse = &reach->coarse;
    double longest = 0;
    int code = CVOL_OK;
    for (int a = 0; a < 3; a++)
        longest = fmax(longest, (double)coarse->dims[a] * coarse->length[a]);
    memset(reach->ambient, 0, cvol_coarse_count(coarse) * sizeof *reach->ambient);
    for (int k = 0; k < 6 && !code; k++) {
        cvol_sweep cone = {.blur = 1, .keep = exp(-coarse->length[k / 2] / (REACH * longest))};
        cone.way[k / 2] = k % 2 ? 1 : -1;
        code = cvol_sweep_run(context, coarse, reach->extinction, &cone, add_cone, reach->ambient);
    }
    return code;
}

static int is_same(const cvol_reach *reach, const cvol_render_options *options)
{
    return reach->is_known && reach->mode == options->mode &&
           !(reach->surface < options->surface.value) &&
           !(reach->surface > options->surface.value) &&
           !memcmp(&reach->clip, &options->clip, sizeof reach->clip);
}

/* Finds extinction and ambient light, if they have changed. */
static int find_matter(cvol_context *context, cvol_reach *reach, const cvol_grid *grid,
                       const cvol_transfer *transfer, const cvol_render_options *options)
{
    int code = allocate(context, reach);
    if (code || is_same(reach, options))
        return code;
    reach->is_known = 0;
    code = cvol_extinction_find(context, reach->extinction, &reach->coarse, grid, transfer,
                                options);
    if (!code)
        code = find_ambient(context, reach);
    if (code)
        return code;
    reach->is_known = 1;
    reach->mode = options->mode;
    reach->surface = options->surface.value;
    reach->clip = options->clip;
    return CVOL_OK;
}

/* Factors from ambient light, which become those with shadows. */
typedef struct shadow_job {
    const float *ambient;
    float *factors, occlusion, shadows;
} shadow_job;

static float factor_of(const shadow_job *job, size_t i)
{
    const float seen = job->ambient[i] * (float)(1 / OPEN);
    const float most = seen < 1 ? seen : 1;
    return 1 - job->occlusion + job->occlusion * (most < (float)DARKEST ? (float)DARKEST : most);
}

static void add_shadow(void *user, const float *depths, size_t first, size_t count, size_t stride)
{
    const shadow_job *job = user;
    for (size_t i = 0; i < count; i++) {
        const size_t at = first + i * stride;
        const float through = cvol_sweep_transmittance(depths[i]);
        job->factors[at] = factor_of(job, at) * (1 - job->shadows + job->shadows * through);
    }
}

/* The part of light that casts shadows, of all. */
static double direct_share(const cvol_render_options *options)
{
    const double direct = options->shading.diffuse,
                 all = direct + options->shading.ambient + options->illumination.fill;
    return all > 0 ? direct / all : 0;
}

static int find_factors(cvol_context *context, cvol_reach *reach, const cvol_view *view,
                        const cvol_render_options *options)
{
    const cvol_illumination *light = &options->illumination;
    const double *given = options->shading.light;
    const int from_eye = !(hypot(hypot(given[0], given[1]), given[2]) > 0);
    const size_t count = cvol_coarse_count(&reach->coarse);
    shadow_job job = {reach->ambient, reach->factors, (float)light->occlusion,
                      (float)(light->shadows * direct_share(options))};
    if (!(light->shadows > 0)) {
        for (size_t i = 0; i < count; i++)
            reach->factors[i] = factor_of(&job, i);
        return CVOL_OK;
    }
    cvol_sweep sweep = {.keep = 1};
    memcpy(sweep.way, from_eye ? view->eye : given, sizeof sweep.way);
    return cvol_sweep_run(context, &reach->coarse, reach->extinction, &sweep, add_shadow, &job);
}

/* ---- light on surfaces -------------------------------------------------------------------- */

/* A row along an axis: weights 1 2 1 of its cells; cells beyond its ends count as those there. */
static void blur_row(float *row, size_t count, size_t stride, size_t lanes)
{
    for (size_t lane = 0; lane < lanes; lane++) {
        float before = row[lane];
        for (size_t i = 0; i < count; i++) {
            float *here = row + lane + i * stride;
            const float now = *here, next = i + 1 < count ? here[stride] : now;
            *here = 0.25f * (before + 2 * now + next);
            before = now;
        }
    }
}

static void blur(cvol_context *context, float *values, const size_t n[3])
{
    const int threads = cvol_context_threads(context);
#pragma omp parallel for num_threads(threads)
    for (size_t z = 0; z < n[2]; z++) {
        float *slice = values + z * n[0] * n[1];
        for (size_t y = 0; y < n[1]; y++)
            blur_row(slice + y * n[0], n[0], 1, 1);
        blur_row(slice, n[1], n[0], n[0]);
    }
#pragma omp parallel for num_threads(threads)
    for (size_t y = 0; y < n[1]; y++)
        blur_row(values + y * n[0], n[2], n[0] * n[1], n[0]);
}

/* Factors fall steeply within an opaque surface, and the grid of cells would show there. So each
 * cell gets a mean of the cells around, in which the transparent ones count: the light that falls
 * onto a surface. */
static int spread_factors(cvol_context *context, cvol_reach *reach)
{
    const cvol_coarse *coarse = &reach->coarse;
    const size_t count = cvol_coarse_count(coarse);
    const float length = (float)((coarse->length[0] + coarse->length[1] + coarse->length[2]) / 3);
    float *weights = cvol_allocate(count, sizeof *weights);
    if (!weights)
        return cvol_fail_memory(context, count * sizeof *weights, "the light in a volume");
    for (size_t i = 0; i < count; i++) {
        const float through = cvol_sweep_transmittance(length * reach->extinction[i]);
        weights[i] = through > OPAQUE_WEIGHT ? through : OPAQUE_WEIGHT;
        reach->factors[i] *= weights[i];
    }
    blur(context, weights, coarse->dims);
    blur(context, reach->factors, coarse->dims);
    for (size_t i = 0; i < count; i++)
        reach->factors[i] /= weights[i];
    free(weights);
    return CVOL_OK;
}

/* ---- exposure ------------------------------------------------------------------------------ */

/* Sums over the rows of a slice, which add to them one after the other. */
typedef struct brightness_job {
    const cvol_reach *reach;
    const cvol_transfer *transfer;
    const cvol_render_options *options;
    const cvol_view *view;
    double light[3], rise[3], flat;
    float *unlit, *lit, *seen; /* of each cell: brightness, and the share of it in the picture */
} brightness_job;

static double brightness_of(const brightness_job *job, double value)
{
    if (job->options->mode == CVOL_MODE_ISO) {
        const double *c = job->options->surface.colour;
        return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    }
    const cvol_transfer_point p = cvol_transfer_at(job->transfer, value);
    return 0.2126 * p.r + 0.7152 * p.g + 0.0722 * p.b;
}

/* The factor of Phong's model in a cell, by its neighbours. */
static double phong_of(const brightness_job *job, size_t i)
{
    const cvol_coarse *coarse = &job->reach->coarse;
    const size_t *n = coarse->dims, apart[3] = {1, n[0], n[0] * n[1]};
    const size_t cell[3] = {i % n[0], i / n[0] % n[1], i / n[0] / n[1]};
    const cvol_shading *shading = &job->options->shading;
    const double *eye = job->view->eye;
    double normal[3], facing = 0, lit = 0, seen = 0;
    for (int a = 0; a < 3; a++) {
        const size_t behind = cell[a] + 1 < n[a] ? i + apart[a] : i,
                     before = cell[a] ? i - apart[a] : i;
        normal[a] = job->rise[a] * (double)(coarse->values[behind] - coarse->values[before]);
    }
    const double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] +
                               normal[2] * normal[2]);
    for (int a = 0; a < 3; a++) {
        const double part = length > 0 ? normal[a] / length : eye[a];
        lit += part * job->light[a];
        seen += part * eye[a];
        facing += eye[a] * job->light[a];
    }
    const double flat = job->flat * job->flat, flatness = flat / (length * length + flat + 1e-30);
    lit = (seen < 0 ? -lit : lit) * (1 - flatness) + facing * flatness;
    seen = fabs(seen) * (1 - flatness) + flatness;
    return shading->ambient + shading->diffuse * fmax(lit, 0) +
           job->options->illumination.fill * seen;
}

static void add_brightness(void *user, const float *depths, size_t first, size_t count,
                           size_t stride)
{
    const brightness_job *job = user;
    const cvol_reach *reach = job->reach;
    double cell = 0;
    for (int a = 0; a < 3; a++)
        cell += reach->coarse.length[a] / 3;
    for (size_t k = 0; k < count; k++) {
        const size_t i = first + k * stride;
        const double depth = cell * (double)reach->extinction[i];
        job->unlit[i] = job->lit[i] = 0;
        if (!(depth > 1e-3) || depths[k] > 6)
            continue;
        const double seen = (1 - exp(-depth)) * (double)cvol_sweep_transmittance(depths[k]);
        const double unlit = seen * brightness_of(job, (double)reach->coarse.values[i]);
        job->seen[i] = (float)seen;
        job->unlit[i] = (float)unlit;
        job->lit[i] = (float)(unlit * phong_of(job, i)) * reach->factors[i];
    }
}

/* The ratio of both sums, or down to DIMMER of it so that all but BURNT of what is seen stays below
 * white; down to DIMMEST if much would be white even so, as on white objects. */
static double choose_exposure(const brightness_job *job, size_t count)
{
    double unlit = 0, lit = 0, all = 0, above = 0, seen[LEVELS] = {0};
    int level = LEVELS;
    for (size_t i = 0; i < count; i++) {
        if (!(job->unlit[i] > 0))
            continue;
        unlit += (double)job->unlit[i];
        lit += (double)job->lit[i];
        all += (double)job->seen[i];
        const double at = (double)(job->lit[i] / job->seen[i]) * LEVELS / LEVEL_MOST;
        seen[at < LEVELS ? (int)at : LEVELS - 1] += (double)job->seen[i];
    }
    if (!(lit > 0))
        return 1;
    while (level > 1 && above + seen[level - 1] <= BURNT * all)
        above += seen[--level];
    const double wanted = unlit / lit, white = LEVELS / (level * LEVEL_MOST);
    above = 0; /* what is white at DIMMER */
    for (int k = LEVELS - 1; k > 0 && k * LEVEL_MOST * DIMMER * wanted >= LEVELS; k--)
        above += seen[k];
    const double least = above > MUCH_BURNT * all ? DIMMEST : DIMMER;
    return fmin(fmax(fmax(fmin(wanted, white), least * wanted), EXPOSURE_MIN), EXPOSURE_MAX);
}

static int find_exposure(cvol_context *context, cvol_reach *reach, const cvol_grid *grid,
                         const cvol_transfer *transfer, const cvol_view *view,
                         const cvol_render_options *options)
{
    const size_t count = cvol_coarse_count(&reach->coarse);
    const double *given = options->shading.light;
    const double length = hypot(hypot(given[0], given[1]), given[2]);
    brightness_job job = {reach, transfer, options, view, {0}, {0}, 0, NULL, NULL, NULL};
    cvol_sweep sweep = {.keep = 1};
    memcpy(sweep.way, view->eye, sizeof sweep.way);
    for (int a = 0; a < 3; a++) {
        job.light[a] = length > 0 ? given[a] / length : view->eye[a];
        job.rise[a] = 0.5 * view->mean_spacing / (reach->coarse.pitch[a] * grid->spacing[a]);
    }
    if (options->mode != CVOL_MODE_ISO)
        job.flat = cvol_flat_gradient(cvol_transfer_width(transfer));
    job.unlit = cvol_allocate(3 * count, sizeof *job.unlit);
    if (!job.unlit)
        return cvol_fail_memory(context, 3 * count * sizeof *job.unlit, "the light in a volume");
    job.lit = job.unlit + count;
    job.seen = job.lit + count;
    const int code = cvol_sweep_run(context, &reach->coarse, reach->extinction, &sweep,
                                    add_brightness, &job);
    if (!code)
        reach->exposure = choose_exposure(&job, count);
    free(job.unlit);
    return code;
}

int cvol_reach_find(cvol_context *context, cvol_reach *reach, const cvol_grid *grid,
                    const cvol_transfer *transfer, const cvol_view *view,
                    const cvol_render_options *options)
{
    int code = find_matter(context, reach, grid, transfer, options);
    if (!code)
        code = find_factors(context, reach, view, options);
    if (!code)
        code = spread_factors(context, reach);
    reach->exposure = 1;
    if (!code && options->illumination.keeps_brightness)
        code = find_exposure(context, reach, grid, transfer, view, options);
    return code;
}

double cvol_reach_at(const cvol_reach *reach, const double place[3])
{
    const cvol_coarse *coarse = &reach->coarse;
    const size_t *n = coarse->dims;
    size_t low[3], high[3];
    double part[3], value = 0;
    for (int a = 0; a < 3; a++) {
        const double at = fmin(fmax((place[a] - coarse->first[a]) / coarse->pitch[a], 0),
                               (double)(n[a] - 1));
        low[a] = (size_t)at;
        high[a] = low[a] + 1 < n[a] ? low[a] + 1 : low[a];
        part[a] = at - (double)low[a];
    }
    for (int k = 0; k < 8; k++) {
        double weight = 1;
        size_t i[3];
        for (int a = 0; a < 3; a++) {
            i[a] = k >> a & 1 ? high[a] : low[a];
            weight *= k >> a & 1 ? part[a] : 1 - part[a];
        }
        value += weight * (double)reach->factors[i[0] + n[0] * (i[1] + n[1] * i[2])];
    }
    return value;
}
