/* Baked volumes: slices to a file, and a renderer over one (codec/container/baked.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/file.h"
#include "codec/container/plane_file.h"
#include "render/spectral/state.h"
#include "render/view/options.h"

static const char *const axes[] = {"x", "y", "z"};

static int same(double a, double b)
{
    return !(a < b) && !(b < a);
}

/* A footprint must not be larger than a slice. */
static int check_footprint(cvol_context *context, const char *name, const cvol_splat_options *splat,
                           const size_t samples[2])
{
    if ((size_t)splat->size <= samples[0] && (size_t)splat->size <= samples[1])
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                     "%s: a footprint of %d samples is larger than slices of %zu x %zu", name,
                     splat->size, samples[0], samples[1]);
}

/* Files store of the light only if there is one, and its direction. */
static int check_material(cvol_context *context, const char *name, const cvol_shading *asked)
{
    const cvol_shading own = cvol_render_options_defaults().shading;
    if (!asked->on || (same(asked->ambient, own.ambient) && same(asked->diffuse, own.diffuse) &&
                       same(asked->specular, own.specular) && asked->shininess == own.shininess &&
                       same(asked->gradient_opacity, own.gradient_opacity)))
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                     "%s: baked volumes have ambient %g, diffuse %g, specular %g, shininess %d and "
                     "no gradient opacity",
                     name, own.ambient, own.diffuse, own.specular, own.shininess);
}

static cvol_shading shading_of(const cvol_baked_file *file)
{
    cvol_shading shading = cvol_render_options_defaults().shading;
    shading.on = file->shading.on;
    memcpy(shading.light, file->shading.light, sizeof shading.light);
    return shading;
}

/* ---- baking --------------------------------------------------------------------------------- */

static int check_baking(cvol_context *context, const cvol_transform_state *state, const char *path,
                        int axis, const cvol_render_options *options)
{
    const cvol_transform_options *own = &options->transform;
    if (state->path)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s: is baked already", state->path);
    if (!state->input.transfer)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "baking needs a transfer function, none was set");
    if (axis < 0 || axis > 2)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "axis is %d, must be 0, 1 or 2", axis);
    if (!(own->rho > 0 && own->rho <= 1))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "rho is %g, must be above 0 and at most 1",
                         own->rho);
    if (own->transform != CVOL_DCT)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: slices under %s are moved by their phases, and serve one direction "
                         "only: bake them under dct",
                         path, cvol_transform_name(own->transform));
    if (options->splat.footprint == CVOL_FOOTPRINT_CONE)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "a cone is not separable: slices are baked for footprints gaussian, "
                         "sinc and box");
    for (int a = 0; a < 3; a++)
        if (state->input.grid.dims[a] > 65536)
            return cvol_fail(context, CVOL_ERROR_LIMIT,
                             "%s: the volume has %zu samples along %s, a baked one at most 65536",
                             path, state->input.grid.dims[a], axes[a]);
    const int code = check_material(context, path, &options->shading);
    return code ? code : cvol_splat_options_check(context, &options->splat);
}

/* Makes slices along their axis. */
static int make_slices(cvol_context *context, cvol_transform_state *state, cvol_baked *out,
                       int axis, const cvol_render_options *options)
{
    cvol_render_options along = *options;
    cvol_view view;
    cvol_splat_setup setup;
    along.camera = (cvol_camera){
        .azimuth_deg = axis == 0 ? 90 : 0, .elevation_deg = axis == 2 ? 90 : 0, .zoom = 1};
    int code = cvol_view_make(context, &view, &state->input.grid, &along);
    if (code)
        return code;
    cvol_splat_setup_make(&setup, &state->input, &view, &options->shading, 1);
    const cvol_footprint_shape shape = cvol_intermediate_grid_shape(&options->splat);
    const cvol_intermediate_grid image_grid = cvol_intermediate_grid_make(&setup.plan, &shape, 1);
    const cvol_bake_source source = {&state->input.source, &setup.plan, state->input.table,
                                     &setup.light, setup.ascending};
    cvol_splat_input_tabulate(&state->input, setup.plan.distance, 1);
    return cvol_bake(context, out, &source, &image_grid, &shape, &options->transform);
}

static int write_file(cvol_context *context, const cvol_baked_file *file, const char *path,
                      uint64_t *file_bytes)
{
    cvol_bytes bytes = {0};
    const int code = cvol_baked_file_put(context, &bytes, file);
    return cvol_plane_file_end(context, &bytes, code, path, file_bytes);
}

int cvol_renderer_bake(cvol_context *context, cvol_renderer *renderer, const char *path, int axis,
                       const char *transfer_name, const cvol_render_options *options,
                       uint64_t *file_bytes)
{
    cvol_transform_state *state = renderer->state;
    cvol_render_options full;
    if (renderer->engine != &cvol_transform_engine)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "only engine transform bakes volumes");
    int code = cvol_render_options_complete(context, &full, options);
    if (!code)
        code = check_baking(context, state, path, axis, &full);
    if (code)
        return code;
    cvol_baked_file file = {.grid = state->input.grid,
                            .axis = axis,
                            .transform = full.transform.transform,
                            .tile = full.transform.tile,
                            .rho = full.transform.rho,
                            .splat = full.splat,
                            .shading = full.shading,
                            .point_count = state->input.transfer->count,
                            .points = state->input.transfer->points};
    size_t samples[2];
    cvol_baked baked = {0};
    cvol_baked_file_samples(samples, &file);
    if (transfer_name && strlen(transfer_name) < sizeof file.transfer_name)
        strcpy(file.transfer_name, transfer_name);
    code = check_footprint(context, path, &full.splat, samples);
    if (!code)
        code = make_slices(context, state, &baked, axis, &full);
    if (!code) {
        file.channels = baked.channels;
        file.distance = baked.distance;
        file.slices = baked.slices;
        file.planes = baked.planes;
        file.step = cvol_baked_file_step(&file);
        code = write_file(context, &file, path, file_bytes);
    }
    cvol_baked_free(&baked);
    return code;
}

/* ---- a renderer over a file ----------------------------------------------------------------- */

/* Takes over the planes. */
static int adopt(cvol_context *context, cvol_transform_state *state)
{
    cvol_baked_file *file = &state->file;
    state->input.grid = file->grid;
    state->baked = (cvol_baked){.slices = file->slices,
                                .axis_slice = file->axis,
                                .transform = file->transform,
                                .tile = file->tile,
                                .channels = file->channels,
                                .distance = file->distance,
                                .planes = file->planes};
    cvol_baked_file_samples(state->baked.samples, file);
    file->planes = NULL;
    state->has_baked = 1;
    state->shape = cvol_intermediate_grid_shape(&file->splat);
    state->options = (cvol_transform_options){
        .transform = file->transform, .tile = file->tile, .rho = file->rho};
    return cvol_baked_count(context, &state->baked);
}

static int create(cvol_context *context, cvol_transform_state **out, const char *path)
{
    cvol_map map;
    *out = NULL;
    int code = cvol_file_map(context, &map, path);
    if (code)
        return code;
    cvol_transform_state *state = calloc(1, sizeof *state);
    if (state && (state->path = malloc(strlen(path) + 1)))
        strcpy(state->path, path);
    if (!state || !state->path)
        code = cvol_fail_memory(context, sizeof *state, "a renderer");
    if (!code)
        code = cvol_baked_file_take(context, &state->file, map.data, map.size, path);
    cvol_file_unmap(&map);
    if (code) {
        free(state ? state->path : NULL);
        free(state);
        return code;
    }
    code = adopt(context, state);
    if (code)
        cvol_transform_engine.free(state);
    else
        *out = state;
    return code;
}

int cvol_transform_create_baked(cvol_context *context, void **state, const char *path)
{
    cvol_transform_state *made = NULL;
    const int code = create(context, &made, path);
    *state = made;
    return code;
}

const cvol_grid *cvol_transform_baked_grid(const void *state)
{
    return &((const cvol_transform_state *)state)->file.grid;
}

int cvol_renderer_get_baked_info(cvol_context *context, cvol_baked_info *out,
                                 const cvol_renderer *renderer)
{
    const cvol_transform_state *state = renderer->state;
    if (renderer->engine != &cvol_transform_engine || !state->path)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "this renderer is not over a baked volume");
    const cvol_baked_file *file = &state->file;
    const cvol_baked *baked = &state->baked;
    const size_t planes = cvol_baked_planes(baked);
    const double samples = (double)baked->samples[0] * (double)baked->samples[1];
    *out = (cvol_baked_info){.grid = file->grid,
                             .axis = file->axis,
                             .slices = baked->slices,
                             .visible = planes / (size_t)(file->channels + 1),
                             .channels = file->channels,
                             .rho = file->rho,
                             .step = file->step,
                             .terms = baked->terms,
                             .resident_bytes = baked->bytes,
                             .splat = file->splat,
                             .shading = shading_of(file),
                             .transform = file->transform,
                             .tile = file->tile,
                             .transfer_points = file->points,
                             .transfer_count = file->point_count};
    if (planes)
        out->kept = (double)baked->terms / ((double)planes * samples);
    memcpy(out->transfer_name, file->transfer_name, sizeof out->transfer_name);
    return CVOL_OK;
}

/* ---- views that it can draw ----------------------------------------------------------------- */

int cvol_baked_file_has_transfer(cvol_context *context, const cvol_transform_state *state,
                                 const cvol_transfer *transfer)
{
    const cvol_baked_file *file = &state->file;
    int is_same = transfer->count == file->point_count;
    for (size_t i = 0; is_same && i < file->point_count; i++) {
        const cvol_transfer_point *a = &transfer->points[i], *b = &file->points[i];
        is_same = same(a->value, b->value) && same(a->r, b->r) && same(a->g, b->g) &&
                  same(a->b, b->b) && same(a->opacity, b->opacity);
    }
    if (is_same)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                     "%s: was baked with another transfer function%s%s", state->path,
                     file->transfer_name[0] ? ", " : "", file->transfer_name);
}

static int check_light(cvol_context *context, const cvol_transform_state *state,
                       const cvol_shading *asked)
{
    const cvol_shading *own = &state->file.shading;
    if (!asked->on != !own->on)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s: was baked %s, which cannot be changed",
                         state->path, own->on ? "lit" : "unlit");
    for (int a = 0; a < 3 && own->on; a++)
        if (!same(asked->light[a], own->light[a]))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "%s: was baked with the light at %g,%g,%g (0,0,0: with the eye), not "
                             "%g,%g,%g",
                             state->path, own->light[0], own->light[1], own->light[2],
                             asked->light[0], asked->light[1], asked->light[2]);
    return check_material(context, state->path, asked);
}

int cvol_baked_file_serves(cvol_context *context, const cvol_transform_state *state,
                           const cvol_splat_plan *plan, const cvol_render_options *options)
{
    const cvol_transform_options *asked = &options->transform;
    const cvol_baked_file *file = &state->file;
    if (asked->transform != file->transform || asked->tile != file->tile)
        return cvol_fail(
            context, CVOL_ERROR_ARGUMENT,
            "%s: was baked under %s with tiles of %d (0: whole slices), not %s with %d",
            state->path, cvol_transform_name(file->transform), file->tile,
            cvol_transform_name(asked->transform), asked->tile);
    if (asked->rho > file->rho * (1 + 1e-12))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s: keeps rho %g, %g is requested",
                         state->path, file->rho, asked->rho);
    if (plan->axis_slice != file->axis)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: was baked in slices along %s, from this direction they lie along %s: "
                         "bake it for that axis as well",
                         state->path, axes[file->axis], axes[plan->axis_slice]);
    const int code = check_light(context, state, &options->shading);
    return code ? code
                : check_footprint(context, state->path, &options->splat, state->baked.samples);
}
