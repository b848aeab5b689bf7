/* Draws pictures of the sheet engine: a plan for each direction of projection, tile by tile. */
#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/thread.h"
#include "render/sheet/band/lapped.h"
#include "render/sheet/band/work_stealing.h"
#include "render/sheet/frame/kernel_table.h"
#include "render/sheet/frame/plan.h"
#include "render/sheet/frame_light.h"
#include "render/sheet/frame_tile.h"
#include "render/sheet/frame_values.h"
#include "render/sheet/state.h"
#include "render/view/shading.h"

/* The number of samples between slices, so that they are at most this far apart. */
static int choose_parts(const cvol_sheet_plan *plan, double step_voxels)
{
    if (!(step_voxels > 0) || plan->sheets == 1)
        return 1;
    const double parts = ceil(plan->distance / step_voxels - 1e-9);
    return parts < 1 ? 1 : parts > CVOL_PARTS ? CVOL_PARTS : (int)parts;
}

/* The case of a picture, for the policy. */
static cvol_policy_case case_of(const cvol_sheet_state *state, const cvol_sheet_source *source,
                                const cvol_view *view, const cvol_render_options *options,
                                int has_depth)
{
    const cvol_array *array = source->array;
    const size_t *n = state->array->grid.dims;
    const int level = source->level.samples != NULL;
    return (cvol_policy_case){
        .mode = options->mode,
        .asked = options->sheet.ray_order,
        .pixel = view->pixel / view->mean_spacing,
        .rays = view->rays,
        .step = options->step_voxels,
        .lit = options->mode == CVOL_MODE_ISO ||
               (options->mode == CVOL_MODE_COMPOSITE && options->shading.on),
        .planes = view->planes,
        .perspective = view->perspective,
        .level = level,
        .is_wide = state->wide.reach != 0,
        .has_depth = has_depth,
        .counts = state->counts,
        .traits = state->traits,
        .fits_lit_int16 = cvol_frame_fits_lit_int16(array, state->array->lapped && !level),
        .masked = cvol_sheet_source_masked(source, state->array->mask),
        .is_thin = n[0] == 1 || n[1] == 1 || n[2] == 1,
        .has_range = array->range_max > array->range_min,
        .cpu = cvol_cpu_best(),
    };
}

/* The inputs of a plan's frame, in addition to its plan and its image. */
typedef struct drawing {
    cvol_sheet_state *state;
    const cvol_sheet_source *source;
    const cvol_view *view;
    const cvol_render_options *options;
    const cvol_reach *reach; /* NULL: all light reaches everything */
    cvol_visibility by_surface;
    int extras;
    size_t spare; /* bytes, see cvol_frame_tiles */
} drawing;

/* A value minus the array's offset, in the units of the stored samples. */
static double to_stored_units(const cvol_sheet_plan *plan, double value)
{
    const cvol_int16_scale *int16 = &plan->int16;
    return int16->scale > 0 ? value * (double)int16->scale + (double)int16->offset : value;
}

/* Draws the intermediate image of a plan, or of a tile of it. */
static int draw_intermediate(cvol_context *context, const drawing *of, const cvol_image *image,
                             cvol_sheet_plan *plan, const double progress[2])
{
    cvol_sheet_state *state = of->state;
    const cvol_sheet_source *source = of->source;
    const cvol_render_options *options = of->options;
    const cvol_array *array = state->array;
    const int threads = cvol_context_threads(context);
    const int colour = !cvol_mode_is_grey(options->mode);
    const int band_lines = cvol_work_stealing_lines(plan, threads);
    if (!cvol_sheet_prepare_image(state, plan, image->depth != NULL, threads) ||
        !cvol_sheet_prepare_bands(state, plan, threads, band_lines))
        return cvol_fail(context, CVOL_ERROR_MEMORY,
                         "not enough memory to render into an intermediate image of %d x %d",
                         plan->width, plan->height);
    cvol_light light;
    state->table->light = NULL;
    if (plan->lit) {
        cvol_light_values values = {.range = array->error_bound.value_max -
                                             array->error_bound.value_min};
        if (options->mode != CVOL_MODE_ISO)
            values.flat = cvol_flat_gradient(cvol_transfer_width(state->transfer), values.range);
        cvol_frame_light_set(&light, state->table, &array->grid, plan, of->view, options, values,
                             of->reach);
        state->table->light = &light;
    }
    const cvol_block_cache_limits limits = {.blocks = source->array->block_count,
                                            .megabytes = options->keep_mb,
                                            .threads = threads,
                                            .spare = of->spare};
    cvol_sheet_frame frame = {
        .array = source->array,
        .level = source->level.samples ? &source->level : NULL,
        .plan = plan,
        .cache = state->counts ? (cvol_block_cache){0}
                               : cvol_block_cache_open(&state->cache, plan, &limits),
        .axes = plan->level ? (cvol_block_axes){0} : cvol_sheet_prepare_axes(state, plan),
        .filters = cvol_lapped_filters_of(plan),
        .table = state->table,
        .visibility = options->mode == CVOL_MODE_ISO ? &of->by_surface
                      : colour                       ? &source->by_transfer
                                                     : &source->everything,
        .mask = cvol_sheet_source_mask(source),
        .background = cvol_sheet_background(array, array->mask),
        .kernel = cvol_sheet_kernel_find(&(cvol_kernel_key){.mode = options->mode,
                                                            .is_image_order = plan->image_order,
                                                            .is_lit = plan->lit,
                                                            .is_int16 = plan->int16.scale > 0,
                                                            .has_extras = of->extras},
                                         cvol_cpu_best()),
        .evaluate = CVOL_SIMD_CHOOSE(cvol_sheet_evaluate),
        .intermediate = &state->intermediate,
        .tiles = &state->tiles,
        .extremes = cvol_extremes_of(options->mode, plan, source->array),
        .start = {[3] = colour ? 1 : 0, [5] = 1},
        .counts = state->counts,
        .progress = {progress[0], progress[1]},
    };
    frame.extremes.held = state->held;
    if (frame.mask && !plan->level)
        cvol_mask_points_find(frame.mask_points, plan, frame.mask->block);
    const int code = cvol_work_stealing_draw(context, &frame, state->bands, cvol_band_draw, threads,
                                             band_lines);
    for (int i = 0; i < state->band_count; i++) {
        state->multiply_adds += state->bands[i].multiply_adds;
        state->bands[i].multiply_adds = 0;
    }
    return code;
}

/* A process without a part of the picture: its intermediate image shows nothing. */
static int draw_nothing(cvol_context *context, const drawing *of, const cvol_sheet_plan *plan)
{
    cvol_sheet_state *state = of->state;
    if (!cvol_sheet_prepare_image(state, plan, 0, cvol_context_threads(context)))
        return cvol_fail(context, CVOL_ERROR_MEMORY,
                         "not enough memory for an intermediate image of %d x %d", plan->width,
                         plan->height);
    const cvol_intermediate *image = &state->intermediate;
    const size_t width = (size_t)image->width * (size_t)image->down,
                 groups = (size_t)(image->height / image->down);
    const float through = cvol_mode_is_grey(of->options->mode) ? 0 : 1;
    for (size_t g = 0; g < groups; g++)
        for (size_t i = 0; i < 4 * width; i++)
            image->lines[g * CVOL_LINES * width + i] = i < 3 * width ? 0 : through;
    return CVOL_OK;
}

/* Puts the intermediate images of all processes together. */
static int combine(cvol_context *context, const drawing *of, const cvol_sheet_plan *plan, int code)
{
    const cvol_sheet_state *state = of->state;
    const cvol_intermediate *image = &state->intermediate;
    const size_t width = (size_t)image->width * (size_t)image->down;
    const cvol_sheet_lines lines = {
        .values = image->lines,
        .groups = code ? 0 : (size_t)(image->height / image->down),
        .stride = CVOL_LINES * width,
        .count = width,
        .unit = {(double)plan->int16.scale, (double)plan->int16.offset}};
    return state->combine->combine(state->combine->data, context, code, &lines, of->options->mode);
}

/* Draws the pixels of a plan, or of a tile of it. */
static int draw_tile(cvol_context *context, const drawing *of, cvol_image *image,
                     const cvol_sheet_plan *plan, const double progress[2])
{
    cvol_sheet_state *state = of->state;
    const cvol_array *array = state->array;
    const cvol_render_options *options = of->options;
    const int threads = cvol_context_threads(context);
    cvol_sheet_plan own = *plan;
    cvol_sheet_plan_narrow(&own, of->view, options->mode);
    int code = state->combine && state->combine->is_idle
                   ? draw_nothing(context, of, plan)
                   : draw_intermediate(context, of, image, &own, progress);
    if (state->combine)
        code = combine(context, of, plan, code);
    else
        plan = &own;
    if (code || (state->combine && !state->combine->is_first))
        return code;
    if (image->depth)
        cvol_sheet_depth_draw(image, &state->intermediate, plan, of->view, array->grid.spacing,
                              threads);
    if (!cvol_mode_is_grey(options->mode))
        cvol_warp_composite(image, &state->intermediate, plan, options->background, threads);
    else
        cvol_warp_grey(image, &state->intermediate, plan,
                       to_stored_units(plan, array->error_bound.value_min - array->offset),
                       to_stored_units(plan, array->error_bound.value_max - array->offset),
                       options->background, threads);
    return CVOL_OK;
}

/* The floats per pixel of the intermediate image. */
static int count_floats(const cvol_sheet_plan *plan, int has_depth)
{
    const int pending = plan->masked == CVOL_SHEET_SOME_VOID ? CVOL_PENDING_LINES
                                                             : CVOL_PENDING_LINES_PLAIN;
    return CVOL_LINES + (plan->lit ? pending : 0) + (has_depth != 0) +
           (plan->parts > 1 ? 2 * (CVOL_PARTS - 1) : 0);
}

/* Makes an image-order plan if the policy requests it and the view allows it, and then the frame's
 * table. A lit one has one sample in the middle between two slices, if any are requested. */
static int choose_rays(cvol_context *context, drawing *of, cvol_sheet_plan *plan, int has_depth,
                       double coarsest)
{
    cvol_sheet_state *state = of->state;
    cvol_policy_case in = case_of(state, of->source, of->view, of->options, has_depth);
    cvol_policy policy = cvol_policy_choose(&in);
    const int parts = plan->parts;
    state->table->midpoints = 0;
    if (policy.order == CVOL_RAY_ORDER_IMAGE && !plan->image_order) {
        cvol_sheet_plan oblique = *plan;
        if (!cvol_sheet_plan_image_order(plan->lit ? &oblique : plan, of->view, coarsest)) {
            in.is_oblique = 1;
            policy = cvol_policy_choose(&in);
        } else if (plan->lit) {
            *plan = oblique;
            plan->parts = 1;
            state->table->midpoints = parts > 1;
        }
    }
    of->extras = !(plan->image_order && plan->lit) &&
                 (has_depth || plan->parts > 1 || plan->wide || state->counts);
    state->table->interpolates_gradients = plan->lit &&
                                           (plan->parts > 1 || policy.gradient_interpolation);
    return cvol_frame_values_set(context, state->table, plan, &of->by_surface, of->source->array,
                                 state->transfer, state->traits.noise, of->options, &policy);
}

/* The plan in image order of the whole picture, of which this plan may have some rows. */
static cvol_sheet_plan plan_of_whole(const cvol_sheet_plan *plan, const cvol_view *view)
{
    cvol_sheet_plan whole = *plan;
    if (view->height == view->all_rows || !plan->image_order)
        return whole;
    const int is_along = fabs(plan->warp[0][2]) > 0, a = is_along ? 0 : 1, /* the picture's rows */
        times = is_along ? CVOL_GROUP : CVOL_SQUARE,
              first = plan->warp[a][2] < 0 ? view->all_rows - view->first_row - view->height
                                           : view->first_row,
              before = first / CVOL_GROUP * CVOL_GROUP;
    for (int k = 0; k < 2; k++)
        whole.place[k][0] -= before * plan->place[k][1 + a];
    *(is_along ? &whole.width : &whole.height) = (view->all_rows + times - 1) / times * times;
    return whole;
}

/* 1 if the plan of the whole picture fits into the memory of a frame without tiles of fewer lines
 * than are useful. */
static int fits_frame(const cvol_sheet_plan *plan, const cvol_view *view, int line_floats,
                      size_t mask_bytes)
{
    const cvol_sheet_plan whole = plan_of_whole(plan, view);
    return cvol_frame_tiles_choose(&whole, (size_t)view->width * (size_t)view->all_rows,
                                   line_floats, mask_bytes)
               .spare > 0;
}

/* Draws the pixels of a plan. */
static int draw_plan(cvol_context *context, cvol_sheet_state *state,
                     const cvol_sheet_source *source, cvol_image *image, cvol_sheet_plan *plan,
                     const cvol_view *view, const cvol_render_options *options,
                     const double progress[2])
{
    drawing of = {.state = state,
                  .source = source,
                  .view = view,
                  .options = options,
                  .reach = cvol_reach_suits(options) ? &state->reach : NULL};
    plan->masked = cvol_sheet_source_masked(source, state->array->mask);
    const int is_surface = options->mode == CVOL_MODE_ISO;
    plan->lit = is_surface || (options->mode == CVOL_MODE_COMPOSITE && options->shading.on);
    if (is_surface || options->shading.gradient_opacity > 0) /* gradients are more than light */
        plan->fades = 0;
    plan->wide = state->wide.reach ? &state->wide : NULL;
    plan->reach = plan->lit + state->wide.reach;
    plan->parts = is_surface || options->mode == CVOL_MODE_COMPOSITE
                      ? choose_parts(plan, options->step_voxels)
                      : 1;
    const cvol_sheet_plan before = *plan;
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    size_t mask_bytes = source->mask.bytes;
    int code = choose_rays(context, &of, plan, image->depth != NULL, CVOL_IMAGE_ORDER_POINTS);
    if (state->combine &&
        (code = state->combine->agree(state->combine->data, context, code, &mask_bytes)))
        return code;
    if (!code && plan->image_order &&
        !fits_frame(plan, view, count_floats(plan, image->depth != NULL), mask_bytes)) {
        *plan = before;
        code = choose_rays(context, &of, plan, image->depth != NULL,
                           CVOL_IMAGE_ORDER_POINTS_COARSE);
    }
    cvol_frame_tiles tiles = {0, 0};
    if (!code)
        tiles = cvol_frame_tiles_choose(plan, pixels, count_floats(plan, image->depth != NULL),
                                        mask_bytes);
    size_t tile_count = (size_t)tiles.count;
    if (state->combine)
        code = state->combine->agree(state->combine->data, context, code, &tile_count);
    tiles.count = (int)tile_count;
    of.spare = tiles.spare;
    for (int i = 0; i < tiles.count && !code; i++) {
        const double part = progress[1] / tiles.count, begin = progress[0] + i * part;
        cvol_sheet_plan tile = cvol_frame_tile_make(plan, i, tiles.count);
        code = draw_tile(context, &of, image, &tile, (const double[2]){begin, part});
    }
    return code;
}

/* Sets the distances of rays and of points of a picture in parallel projection. */
static void choose_spacing(const cvol_sheet_state *state, const cvol_sheet_source *source,
                           cvol_view *view, const cvol_render_options *options)
{
    const cvol_policy_case in = case_of(state, source, view, options, 0);
    const cvol_policy policy = cvol_policy_choose(&in);
    view->apart = policy.rays_apart;
    view->coarsest = policy.coarsest;
}

int cvol_sheet_draw_parallel(cvol_context *context, cvol_sheet_state *state,
                             const cvol_sheet_source *source, cvol_image *image,
                             const cvol_view *view, const cvol_render_options *options)
{
    cvol_view seen = *view;
    cvol_sheet_plan plan;
    choose_spacing(state, source, &seen, options);
    int code = cvol_sheet_plan_make(context, &plan, state->array,
                                    source->level.samples ? options->level : 0, &seen);
    if (code)
        return code;
    const cvol_policy_case in = case_of(state, source, &seen, options, 0);
    const int both = image->depth && in.mode == CVOL_MODE_COMPOSITE &&
                     (!in.lit || cvol_policy_choose(&in).order == CVOL_RAY_ORDER_IMAGE);
    const double share = both ? 0.5 : 1, whole[2] = {0, share}, rest[2] = {share, 1 - share};
    code = draw_plan(context, state, source, image, &plan, &seen, options, whole);
    if (code || !both)
        return code;
    float *const depth = image->depth;
    image->depth = NULL;
    code = draw_plan(context, state, source, image, &plan, &seen, options, rest);
    image->depth = depth;
    return code;
}

int cvol_sheet_draw_perspective(cvol_context *context, cvol_sheet_state *state,
                                const cvol_sheet_source *source, cvol_image *image,
                                const cvol_view *view, const cvol_render_options *options)
{
    cvol_sheet_plan plans[6];
    int count = 0;
    for (int along = 0; along < 6; along++) {
        int empty;
        const int code = cvol_sheet_plan_make_along(context, &plans[count], &empty, state->array,
                                                    source->level.samples ? options->level : 0,
                                                    view, along);
        if (code)
            return code;
        count += !empty;
    }
    cvol_warp_nothing(image, cvol_mode_is_grey(options->mode), options->background);
    cvol_sheet_depth_clear(image);
    for (int k = 0; k < count; k++) {
        const double progress[2] = {(double)k / count, 1.0 / count};
        const int code = draw_plan(context, state, source, image, &plans[k], view, options,
                                   progress);
        if (code)
            return code;
    }
    return CVOL_OK;
}
