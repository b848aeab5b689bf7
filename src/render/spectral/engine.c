/* The transform engine: from a view to slices, from slices to a lattice, from there to pixels. */
#define _POSIX_C_SOURCE 200809L /* clock_gettime */
#include "render/spectral/state.h"

#include <math.h>
#include <string.h>
#include <time.h>

#include "base/context.h"
#include "base/memory.h"
#include "image/picture.h"

/* Shears and distances of two views along one direction differ by rounding. */
#define SAME 1e-9

/* ---- state ----------------------------------------------------------------------------- */

static void transform_free(void *opaque)
{
    cvol_transform_state *state = opaque;
    cvol_baked_free(&state->baked);
    cvol_splat_input_free(&state->input);
    cvol_baked_file_free(&state->file);
    free(state->path);
    free(state);
}

int cvol_transform_create(cvol_context *context, void **state, const cvol_array *array)
{
    return cvol_splat_state_create(context, state, sizeof(cvol_transform_state), array, NULL);
}

int cvol_transform_create_dense(cvol_context *context, void **state, const cvol_volume *volume)
{
    return cvol_splat_state_create(context, state, sizeof(cvol_transform_state), NULL, volume);
}

static int transform_set_transfer(cvol_context *context, void *opaque,
                                  const cvol_transfer *transfer)
{
    cvol_transform_state *state = opaque;
    if (state->path)
        return cvol_baked_file_has_transfer(context, state, transfer);
    state->has_baked = 0;
    return cvol_splat_input_set_transfer(context, &state->input, transfer);
}

int cvol_renderer_get_transform_report(cvol_context *context, cvol_transform_report *out,
                                       const cvol_renderer *renderer)
{
    const cvol_transform_state *state = renderer->state;
    if (renderer->engine != &cvol_transform_engine || !state->has_report)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "this renderer has made no picture by transforms");
    *out = state->report;
    return CVOL_OK;
}

/* ---- requirements of a picture ------------------------------------------------------------- */

static int check_options(cvol_context *context, const cvol_render_options *options)
{
    const cvol_transform_options *own = &options->transform;
    if (own->transform < CVOL_DCT || own->transform > CVOL_DFT)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%d is not a transform",
                         (int)own->transform);
    if (own->schedule != CVOL_SCHEDULE_DEFERRED && own->schedule != CVOL_SCHEDULE_LITERAL)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%d is not a schedule", (int)own->schedule);
    if (!(own->rho > 0 && own->rho <= 1))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "rho is %g, must be above 0 and at most 1",
                         own->rho);
    if (own->tile != 0 && own->tile != 8 && own->tile != 16 && own->tile != 32)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "tile is %d, must be 0, 8, 16 or 32",
                         own->tile);
    if (own->tile != 0 && own->transform != CVOL_DCT)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "tiles need transform dct, not %s",
                         cvol_transform_name(own->transform));
    if (options->splat.footprint == CVOL_FOOTPRINT_CONE)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "a cone is not separable: the transform engine has footprints "
                         "gaussian, sinc and box");
    return CVOL_OK;
}

/* Returns 1 if the slices belong to another axis, lattice, opacity, light or kind of terms. The
 * picture's size and zoom only concern the warp. */
static int is_stale(const cvol_transform_state *state, const cvol_splat_setup *setup,
                    const cvol_intermediate_grid *image_grid, const cvol_footprint_shape *shape,
                    const cvol_transform_options *options)
{
    const cvol_splat_plan *plan = &setup->plan;
    const cvol_transform_options *before = &state->options;
    return !state->has_baked || state->baked.axis_slice != plan->axis_slice ||
           fabs(state->baked.distance - plan->distance) > SAME * plan->distance ||
           before->transform != options->transform || before->tile != options->tile ||
           (state->baked.margin &&
            !cvol_intermediate_grid_same(&state->baked.image_grid, image_grid)) ||
           memcmp(&state->shape, shape, sizeof *shape) != 0 ||
           memcmp(&state->light, &setup->light, sizeof setup->light) != 0;
}

static double now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

/* Makes slices, with rho or with the terms to be stored. */
static int bake(cvol_context *context, cvol_transform_state *state, const cvol_splat_setup *setup,
                const cvol_intermediate_grid *image_grid, const cvol_footprint_shape *shape,
                const cvol_transform_options *options)
{
    state->has_baked = 0;
    cvol_baked_free(&state->baked);
    cvol_splat_input_tabulate(&state->input, setup->plan.distance, 1);
    const cvol_bake_source source = {&state->input.source, &setup->plan, state->input.table,
                                     &setup->light, setup->ascending};
    cvol_transform_options stored = *options;
    stored.rho = fmax(options->rho, options->stored_rho);
    const int code = cvol_bake(context, &state->baked, &source, image_grid, shape, &stored);
    if (code)
        return code;
    state->light = setup->light;
    state->shape = *shape;
    state->options = stored;
    state->has_baked = 1;
    return CVOL_OK;
}

/* ---- from the intermediate grid to pixels ---------------------------------------------------- */

static int warp(cvol_context *context, cvol_image *image, const cvol_composed *composed,
                const cvol_intermediate_grid *image_grid, const cvol_splat_plan *plan,
                const double background[3])
{
    const size_t places = image_grid->dims[0] * image_grid->dims[1];
    float *pixels = cvol_allocate(CVOL_PLANES * places, sizeof *pixels);
    if (!pixels)
        return cvol_fail_memory(context, CVOL_PLANES * places * sizeof *pixels, "a picture");
    for (size_t i = 0; i < places; i++)
        for (size_t c = 0; c < CVOL_PLANES; c++)
            pixels[CVOL_PLANES * i + c] = composed->planes[c] ? composed->planes[c][i]
                                                              : composed->planes[0][i];
    const int code = cvol_intermediate_grid_warp(context, image, pixels, image_grid, plan,
                                                 background);
    free(pixels);
    return code;
}

/* ---- drawing -------------------------------------------------------------------------------- */

static void fill_report(cvol_transform_state *state, const cvol_baked *baked,
                        const cvol_composed *composed, const cvol_intermediate_grid *image_grid,
                        double bake_ms, double compose_ms)
{
    const size_t planes = cvol_baked_planes(baked);
    const double places = (double)image_grid->dims[0] * (double)image_grid->dims[1];
    const double samples = (double)baked->samples[0] * (double)baked->samples[1];
    cvol_transform_report *report = &state->report;
    *report = (cvol_transform_report){.lattice = {image_grid->dims[0], image_grid->dims[1]},
                                      .step = image_grid->step,
                                      .slices = planes / (size_t)(baked->channels + 1),
                                      .terms = baked->terms,
                                      .bytes = baked->bytes,
                                      .multiply_adds = composed->multiply_adds,
                                      .certified = composed->certified && composed->is_useful,
                                      .bake_ms = bake_ms,
                                      .compose_ms = compose_ms};
    if (report->certified)
        report->bound = composed->bound / sqrt(3 * places);
    if (planes)
        report->rho = (double)baked->terms / ((double)planes * samples);
    state->has_report = 1;
}

/* A view's picture on its lattice. */
typedef struct drawing {
    cvol_splat_setup setup;
    cvol_intermediate_grid image_grid;
    cvol_composed composed; /* the caller frees it */
} drawing;

static int compose(cvol_context *context, cvol_transform_state *state, drawing *out,
                   const cvol_view *view, const cvol_render_options *options)
{
    const cvol_splat_options *splat = &options->splat;
    const cvol_transform_options *own = &options->transform;
    const cvol_splat_setup *setup = &out->setup;
    int code = check_options(context, options);
    if (!code)
        code = cvol_splat_setup_picture(context, &out->setup, &state->input, view, options,
                                        "transform");
    if (code)
        return code;
    const cvol_footprint_shape shape = cvol_intermediate_grid_shape(splat);
    /* All terms need all places, and whole planes that are shifted by phases have them. */
    const int all_places = own->tile == 0 || own->rho >= 1;
    const double finest = all_places ? 1 : cvol_intermediate_grid_step(&shape);
    const double step = cvol_transform_is_periodic(own) ? 1 : fmax(finest, 1 << options->level);
    const cvol_footprint_shape spread = cvol_intermediate_grid_stretch(&shape, step / finest);
    out->image_grid = cvol_intermediate_grid_make(&setup->plan, &spread, step);
    const double start = now_ms();
    const int stale = !state->path && (is_stale(state, setup, &out->image_grid, &shape, own) ||
                                       state->options.rho < fmin(own->rho, 1));
    if (state->path)
        code = cvol_baked_file_serves(context, state, &setup->plan, options);
    else if (stale)
        code = bake(context, state, setup, &out->image_grid, &shape, own);
    cvol_baked fewer = {0};
    if (!code && state->options.rho > own->rho) /* only the strongest of the stored terms */
        code = cvol_baked_reduce(context, &fewer, &state->baked, &state->shape, own->rho);
    if (code)
        return code;
    const cvol_baked *used = fewer.planes ? &fewer : &state->baked;
    const double baked = now_ms();
    code = cvol_compose(context, &out->composed, used, &out->image_grid, &spread,
                        setup->plan.distance, setup->plan.rising, setup->front, own);
    if (!code)
        fill_report(state, used, &out->composed, &out->image_grid, stale ? baked - start : 0,
                    now_ms() - baked);
    cvol_baked_free(&fewer);
    return code;
}

static int transform_draw(cvol_context *context, void *opaque, cvol_image *image,
                          const cvol_view *view, const cvol_render_options *options)
{
    drawing drawn;
    int code = compose(context, opaque, &drawn, view, options);
    if (code)
        return code;
    code = warp(context, image, &drawn.composed, &drawn.image_grid, &drawn.setup.plan,
                options->background);
    cvol_composed_free(&drawn.composed);
    return code;
}

int cvol_transform_picture(cvol_context *context, void *opaque, cvol_picture **out,
                           const cvol_view *view, const cvol_render_options *options,
                           const cvol_picture_options *how)
{
    drawing drawn;
    *out = NULL;
    int code = compose(context, opaque, &drawn, view, options);
    if (code)
        return code;
    cvol_picture_source source = {.lattice = {drawn.image_grid.dims[0], drawn.image_grid.dims[1]},
                                  .width = options->width,
                                  .height = options->height,
                                  .is_over = 1};
    for (int c = 0; c < CVOL_PLANES; c++)
        source.planes[c] = drawn.composed.planes[drawn.composed.planes[c] ? c : 0];
    memcpy(source.background, options->background, sizeof source.background);
    cvol_intermediate_grid_matrix(source.to_intermediate, &drawn.image_grid, &drawn.setup.plan);
    cvol_picture_options kept = *how;
    if (options->transform.schedule == CVOL_SCHEDULE_LITERAL) { /* its coefficients stay */
        kept.transform = options->transform.transform;
        kept.block = options->transform.tile;
    }
    code = cvol_picture_make(context, out, &source, &kept);
    cvol_composed_free(&drawn.composed);
    return code;
}

const cvol_engine_table cvol_transform_engine = {
    .free = transform_free, .set_transfer = transform_set_transfer, .draw = transform_draw};
