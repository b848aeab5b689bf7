/* Ambient occlusion, shadows, and light that is scattered once (reach.h).
 *
 * Ambient light comes from all directions. For each cell it is the mean transmittance of six cones,
 * one along each half of an axis, within a limited distance: what lies further away hides less.
 * The shadow of a cell is its transmittance towards the light. With the strengths a and s of
 * occlusion and shadows, and S the part of light that is not ambient, the factor of light is
 *
 *     (1 - a + a min(ambient / OPEN, 1)) (1 - s S + s S shadow)
 *
 * where OPEN is what a convex corner sees. With cvol_illumination.samples, both are means over
 * directions of the sky and of a disc (directions.h), and the factor is a sum (render.h).
 *
 * Then each cell gets a mean of those around, in which the transparent ones count. */
#include "render/light/reach.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/light/directions.h"
#include "render/light/exposure.h"
#include "render/light/extinction.h"
#include "render/light/sweep.h"
#include "render/view/camera.h"
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
/* The number of directions of the sky up to which sweeps are blurred as cones are. */
#define BLURRED 12.0
/* A face of the volume is a cut from the second mean opacity on, and none up to the first. */
#define FACE_LEAST 0.01
#define FACE_CUT 0.05

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
    free(reach->weights);
    free(reach->scales);
    free(reach->factors);
    *reach = (cvol_reach){.is_known = 0};
}

static int allocate(cvol_context *context, cvol_reach *reach)
{
    const size_t count = cvol_coarse_count(&reach->coarse);
    float **const arrays[] = {&reach->extinction, &reach->ambient, &reach->weights, &reach->scales,
                              &reach->factors};
    for (int k = 0; k < 5; k++)
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

/* Finds extinction and the light of six cones, if they have changed. */
static int find_matter(cvol_context *context, cvol_reach *reach, const cvol_grid *grid,
                       const cvol_transfer *transfer, const cvol_render_options *options)
{
    int code = allocate(context, reach);
    if (code || is_same(reach, options))
        return code;
    reach->is_known = 0;
    code = cvol_extinction_find(context, reach->extinction, &reach->coarse, grid, transfer,
                                options);
    if (code)
        return code;
    reach->has_cones = reach->has_weights = reach->cause.all_known = 0;
    reach->is_known = 1;
    reach->mode = options->mode;
    reach->surface = options->surface.value;
    reach->clip = options->clip;
    return CVOL_OK;
}

/* Finds the light of six cones, unless it is known. */
static int find_cones(cvol_context *context, cvol_reach *reach)
{
    if (reach->has_cones)
        return CVOL_OK;
    const int code = find_ambient(context, reach);
    reach->has_cones = !code;
    return code;
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

/* ---- light that is scattered once ---------------------------------------------------------- */

typedef struct mean_job {
    float *sum, share;
} mean_job;

static void add_transmittance(void *user, const float *depths, size_t first, size_t count,
                              size_t stride)
{
    const mean_job *job = user;
    for (size_t i = 0; i < count; i++)
        job->sum[first + i * stride] += job->share * cvol_sweep_transmittance(depths[i]);
}

/* Adds the part of the sky, or of the disc: `share` in all. A sweep stands for the directions
 * between its neighbours, too, so few of them are blurred more. */
static int add_directions(cvol_context *context, cvol_reach *reach, const cvol_directions *of,
                          int is_sky, double share)
{
    static const double none[2] = {0, 0};
    const int count = is_sky ? of->sky : of->disc;
    mean_job job = {reach->factors, (float)(share / count)};
    int code = CVOL_OK;
    for (int i = 0; i < count && !code; i++) {
        cvol_sweep sweep = {.keep = 1, .blur = is_sky ? fmin(1, BLURRED / count) : 0};
        (is_sky ? cvol_direction_to_sky : cvol_direction_to_disc)(sweep.way, of, i, none);
        code = cvol_sweep_run(context, &reach->coarse, reach->extinction, &sweep, add_transmittance,
                              &job);
    }
    return code;
}

static int find_scattered(cvol_context *context, cvol_reach *reach, const cvol_view *view,
                          const cvol_render_options *options)
{
    const cvol_illumination *light = &options->illumination;
    const cvol_directions directions = cvol_directions_make(view, options);
    const double direct = direct_share(options), from_sky = (1 - direct) * light->occlusion,
                 from_disc = direct * light->shadows;
    const size_t count = cvol_coarse_count(&reach->coarse);
    for (size_t i = 0; i < count; i++)
        reach->factors[i] = (float)(1 - from_sky - from_disc);
    int code = CVOL_OK;
    if (from_sky > 0)
        code = add_directions(context, reach, &directions, 1, from_sky);
    if (!code && from_disc > 0)
        code = add_directions(context, reach, &directions, 0, from_disc);
    return code;
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

/* The weights of cells in spread_factors, and one by their means. */
static void find_weights(cvol_context *context, cvol_reach *reach)
{
    const cvol_coarse *coarse = &reach->coarse;
    const size_t count = cvol_coarse_count(coarse);
    const float length = (float)((coarse->length[0] + coarse->length[1] + coarse->length[2]) / 3);
    for (size_t i = 0; i < count; i++) {
        const float through = cvol_sweep_transmittance(length * reach->extinction[i]);
        reach->weights[i] = through > OPAQUE_WEIGHT ? through : OPAQUE_WEIGHT;
        reach->scales[i] = reach->weights[i];
    }
    blur(context, reach->scales, coarse->dims);
    for (size_t i = 0; i < count; i++)
        reach->scales[i] = 1 / reach->scales[i];
    reach->has_weights = 1;
}

/* Factors fall steeply within an opaque surface, and the grid of cells would show there. So each
 * cell gets a mean of the cells around, in which the transparent ones count: the light that falls
 * onto a surface. */
static void spread_factors(cvol_context *context, cvol_reach *reach)
{
    const size_t count = cvol_coarse_count(&reach->coarse);
    if (!reach->has_weights)
        find_weights(context, reach);
    for (size_t i = 0; i < count; i++)
        reach->factors[i] *= reach->weights[i];
    blur(context, reach->factors, reach->coarse.dims);
    for (size_t i = 0; i < count; i++)
        reach->factors[i] *= reach->scales[i];
}

static cvol_reach_cause cause_of(const cvol_view *view, const cvol_render_options *options)
{
    const cvol_shading *shading = &options->shading;
    const cvol_illumination *more = &options->illumination;
    cvol_reach_cause out;
    memset(&out, 0, sizeof out); /* the padding too, to be compared */
    for (int k = 0; k < 3; k++) {
        out.eye[k] = view->eye[k];
        out.light[k] = shading->light[k];
        out.colour[k] = options->surface.colour[k];
    }
    out.ambient = shading->ambient;
    out.diffuse = shading->diffuse;
    out.specular = shading->specular;
    out.gradient_opacity = shading->gradient_opacity;
    out.fill = more->fill;
    out.occlusion = more->occlusion;
    out.shadows = more->shadows;
    out.shininess = shading->shininess;
    out.keeps_brightness = more->keeps_brightness;
    out.samples = more->samples;
    out.all_known = 1;
    return out;
}

/* The mean opacity of the outermost cells at a face, which the empty cells around the volume
 * surround. */
static double opacity_of_face(const cvol_reach *reach, int axis, int is_upper)
{
    const size_t *n = reach->coarse.dims, strides[3] = {1, n[0], n[0] * n[1]};
    const int across = axis == 0 ? 1 : 0, along = 3 - axis - across;
    const double length = (reach->coarse.length[0] + reach->coarse.length[1] +
                           reach->coarse.length[2]) /
                          3;
    const float *face = reach->extinction + (is_upper ? n[axis] - 2 : 1) * strides[axis];
    double sum = 0;
    for (size_t j = 1; j + 1 < n[along]; j++)
        for (size_t i = 1; i + 1 < n[across]; i++)
            sum += 1 - exp(-length * (double)face[i * strides[across] + j * strides[along]]);
    return sum / ((double)(n[along] - 2) * (double)(n[across] - 2));
}

int cvol_reach_find_cuts(cvol_context *context, cvol_reach *reach, cvol_view *view,
                         const cvol_grid *grid, const cvol_transfer *transfer,
                         const cvol_render_options *options)
{
    const int code = find_matter(context, reach, grid, transfer, options);
    const int thin = cvol_view_thin_axis(grid); /* its faces are cuts already */
    for (int k = 0; k < 6 && !code; k++) {
        const int axis = k / 2, is_upper = k % 2;
        const double share = axis == thin ? 0 : opacity_of_face(reach, axis, is_upper);
        if (share > FACE_LEAST)
            cvol_view_add_face(view, grid, axis, is_upper,
                               fmin((share - FACE_LEAST) / (FACE_CUT - FACE_LEAST), 1));
    }
    return code;
}

int cvol_reach_find(cvol_context *context, cvol_reach *reach, const cvol_grid *grid,
                    const cvol_transfer *transfer, const cvol_view *view,
                    const cvol_render_options *options)
{
    int code = find_matter(context, reach, grid, transfer, options);
    const cvol_reach_cause cause = cause_of(view, options);
    if (code || !memcmp(&reach->cause, &cause, sizeof cause)) /* as for strips of a picture */
        return code;
    reach->cause.all_known = 0;
    if (options->illumination.samples)
        code = find_scattered(context, reach, view, options);
    else if (!(code = find_cones(context, reach)))
        code = find_factors(context, reach, view, options);
    if (!code)
        spread_factors(context, reach);
    reach->exposure = 1;
    if (!code && options->illumination.keeps_brightness)
        code = cvol_exposure_find(
            context, &reach->exposure,
            &(cvol_lit_cells){&reach->coarse, reach->extinction, reach->factors}, grid, transfer,
            view, options);
    if (!code)
        reach->cause = cause;
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
