/* The sheet engine: pictures straight from the compressed array, slice by slice, front to back.
 *
 * It combines Westover's sheet buffers ("Footprint Evaluation for Volume Rendering", 1990) with
 * Lacroute and Levoy's shear-warp geometry. Rays meet the layers of blocks of the principal axis
 * front to back. The visible blocks of each layer are inversely transformed (pruned to their own
 * low boxes) into one buffer of samples. Every line of the intermediate image then passes the
 * layer's slices one after the other: reconstruct, classify, composite. One 2-D warp makes the
 * picture. Memory: one layer of samples, for any depth of the volume.
 *
 * Blocks and lines are independent of each other, so the picture does not depend on the number of
 * threads. */
#include "render/counters.h"
#include "render/sheet/frame/frame.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/evaluate/decoded_terms.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/thread.h"
#include "render/sheet/band/band.h"
#include "render/sheet/band/lapped.h"
#include "render/sheet/band/work_stealing.h"
#include "render/sheet/coarse_level.h"
#include "render/sheet/combine.h"
#include "render/sheet/frame/kernel_table.h"
#include "render/sheet/frame/plan.h"
#include "render/sheet/frame/policy.h"
#include "render/sheet/frame/table.h"
#include "render/sheet/frame_light.h"
#include "render/sheet/frame_tile.h"
#include "render/sheet/source.h"
#include "render/view/options.h"
#include "render/view/shading.h"
#include "transform/cell_points.h"

typedef struct sheet_state {
    const cvol_array *array;
    const cvol_array *whole;                       /* for the light; see cvol_source */
    cvol_sheet_source sources[CVOL_SHEET_SOURCES]; /* the volume, and its levels */
    cvol_transfer *transfer;
    cvol_sheet_table *table;
    cvol_intermediate intermediate;
    float *depth, *between; /* of the intermediate image, if requested */
    cvol_tiles tiles;
    float *held; /* see cvol_extremes */
    size_t line_capacity, scratch_capacity, span_capacity, opaque_capacity, intersected_capacity,
        tile_capacity, pending_capacity, edge_capacity, depth_capacity, between_capacity,
        held_capacity;
    float *bases;            /* bases of lane, row and slice of the frame; of sub-blocks */
    cvol_band_memory *bands; /* one for each thread */
    int band_count;
    cvol_transfer_traits traits;     /* of the array with the transfer function */
    cvol_reconstruction_filter wide; /* the reconstruction filter of the picture */
    cvol_block_cache_memory cache;
    cvol_reach reach;
    const cvol_sheet_combine *combine; /* NULL: this process draws all parts */
    int counts;                        /* multiply-adds, of all plans of a picture */
    uint64_t multiply_adds;
} sheet_state;

static void sheet_free(void *opaque_state)
{
    sheet_state *state = opaque_state;
    if (!state)
        return;
    cvol_transfer_free(state->transfer);
    free(state->table);
    free(state->intermediate.lines);
    free(state->intermediate.scratch);
    free(state->intermediate.spans);
    free(state->intermediate.opaque);
    free(state->intermediate.intersected);
    free(state->intermediate.pending);
    free(state->intermediate.edges);
    free(state->depth);
    free(state->between);
    free(state->tiles.open);
    free(state->held);
    for (int i = 0; i < state->band_count; i++)
        cvol_band_memory_free(&state->bands[i]);
    free(state->bands);
    free(state->bases);
    cvol_block_cache_free(&state->cache);
    cvol_reach_free(&state->reach);
    for (int i = 0; i < CVOL_SHEET_SOURCES; i++)
        cvol_sheet_source_free(&state->sources[i]);
    free(state);
}

/* Refuses a range whose terms do not fit into single precision: the picture would be empty. */
static int check_range(cvol_context *context, const cvol_array *array)
{
    const double lo = array->error_bound.value_min, hi = array->error_bound.value_max;
    if (!isfinite(hi - lo) || !(hi > lo) ||
        (hi - lo >= CVOL_RANGE_LEAST && hi - lo <= CVOL_RANGE_MOST))
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                     "samples from %g to %g: engine sheet draws ranges from %g to %g: use engine "
                     "ray, or scale the samples",
                     lo, hi, CVOL_RANGE_LEAST, CVOL_RANGE_MOST);
}

int cvol_sheet_create(cvol_context *context, void **out, const cvol_array *array,
                      const cvol_array *whole)
{
    *out = NULL;
    int code = cvol_array_need_volume(context, array, "the sheet engine");
    if (!code)
        code = check_range(context, array);
    if (code)
        return code;
    sheet_state *state = cvol_allocate_zero(1, sizeof *state);
    if (!state)
        return cvol_fail_memory(context, sizeof *state, "a renderer");
    state->array = array;
    state->whole = whole ? whole : array;
    state->table = cvol_allocate_zero(1, sizeof *state->table);
    state->bases = cvol_allocate_zero(9 * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX, sizeof(float));
    if (!state->table || !state->bases) {
        sheet_free(state);
        return cvol_fail_memory(context, sizeof *state->table, "a renderer");
    }
    *out = state;
    return CVOL_OK;
}

static int sheet_set_transfer(cvol_context *context, void *opaque_state,
                              const cvol_transfer *transfer)
{
    sheet_state *state = opaque_state;
    size_t bytes = sizeof *transfer + transfer->count * sizeof *transfer->points;
    cvol_transfer *copy = malloc(bytes);
    if (!copy)
        return cvol_fail_memory(context, bytes, "a transfer function");
    memcpy(copy, transfer, bytes);
    cvol_transfer_free(state->transfer);
    state->transfer = copy;
    state->traits = cvol_transfer_traits_of(state->array, copy);
    for (int i = 0; i < CVOL_SHEET_SOURCES; i++)
        cvol_sheet_source_find_visible(&state->sources[i], copy);
    cvol_reach_forget(&state->reach);
    return CVOL_OK;
}

/* Finds the source of a level; a level that is too large to be stored is drawn from the blocks. */
static int find_source(cvol_context *context, cvol_sheet_source **out, sheet_state *state,
                       int level)
{
    if (level && !cvol_sheet_level_fits(state->array, level))
        level = 0;
    *out = &state->sources[level];
    if ((*out)->array)
        return CVOL_OK;
    const int code = cvol_sheet_source_make(context, *out, state->array, level);
    if (!code && state->transfer)
        cvol_sheet_source_find_visible(*out, state->transfer);
    return code;
}

/* ---- preparation of a frame ---------------------------------------------------------------- */

static int prepare_image(sheet_state *state, const cvol_sheet_plan *plan, int has_depth,
                         int threads)
{
    cvol_intermediate *image = &state->intermediate;
    const size_t width = (size_t)plan->width, height = (size_t)plan->height;
    image->width = plan->width;
    image->height = plan->height;
    image->down = cvol_lines_interleaved(plan);
    state->tiles.across = plan->width / CVOL_TILE;
    state->tiles.down = (plan->height + CVOL_TILE - 1) / CVOL_TILE;
    const size_t tiles = (size_t)state->tiles.across * (size_t)state->tiles.down;
    const size_t lit = (size_t)plan->lit;
    image->pending_lines = plan->masked == CVOL_SHEET_SOME_VOID ? CVOL_PENDING_LINES
                                                                : CVOL_PENDING_LINES_PLAIN;
    if (!cvol_ensure(&state->depth, &state->depth_capacity, (size_t)has_depth * width * height,
                     sizeof(float)))
        return 0;
    image->depth = has_depth ? state->depth : NULL;
    const size_t between = plan->parts > 1 ? 2 * (CVOL_PARTS - 1) : 0;
    if (!cvol_ensure(&state->between, &state->between_capacity, between * width * height,
                     sizeof(float)))
        return 0;
    image->between = between ? state->between : NULL;
    return cvol_ensure(&image->pending, &state->pending_capacity,
                       lit * (size_t)image->pending_lines * width * height, sizeof(float)) &&
           cvol_ensure(&image->edges, &state->edge_capacity, lit * width / CVOL_GROUP * height,
                       1) &&
           cvol_ensure(&image->lines, &state->line_capacity, CVOL_LINES * width * height,
                       sizeof(float)) &&
           cvol_ensure(&image->scratch, &state->scratch_capacity,
                       4 * width * (size_t)image->down * (size_t)threads, sizeof(float)) &&
           cvol_ensure(&image->spans, &state->span_capacity, 4 * height, sizeof(int)) &&
           cvol_ensure(&image->opaque, &state->opaque_capacity, width / CVOL_GROUP * height, 1) &&
           cvol_ensure(&image->intersected, &state->intersected_capacity,
                       width / CVOL_GROUP * height, sizeof *image->intersected) &&
           cvol_ensure(&state->held, &state->held_capacity, tiles, sizeof(float)) &&
           cvol_ensure(&state->tiles.open, &state->tile_capacity, tiles, 1);
}

static int prepare_bands(sheet_state *state, const cvol_sheet_plan *plan, int threads, int lines)
{
    if (state->band_count < threads) {
        cvol_band_memory *bands = realloc(state->bands, (size_t)threads * sizeof *bands);
        if (!bands)
            return 0;
        state->bands = bands;
        while (state->band_count < threads)
            memset(&bands[state->band_count++], 0, sizeof *bands);
    }
    for (int i = 0; i < threads; i++)
        if (!cvol_band_memory_prepare(&state->bands[i], plan, lines))
            return 0;
    return 1;
}

void cvol_sheet_basis(float *basis, int B, int points, int width)
{
    const double pi = 3.14159265358979323846;
    memset(basis, 0, sizeof(float) * (size_t)(B * width));
    for (int u = 0; u < B; u++)
        for (int i = 0; i < points; i++)
            basis[u * width + i] = (float)(sqrt((u ? 2.0 : 1.0) / B) *
                                           cos(pi * u * (i + 0.5) / points));
}

static cvol_block_axes make_axes(sheet_state *state, const cvol_sheet_plan *plan)
{
    const int B = state->array->block;
    float *lane = state->bases, *row = lane + CVOL_BLOCK_MAX * CVOL_BLOCK_MAX,
          *sheet = row + CVOL_BLOCK_MAX * CVOL_BLOCK_MAX;
    cvol_block_axes axes = {.lane = plan->axis_lane,
                            .row = plan->axis_row,
                            .sheet = plan->axis_sheet,
                            .lane_points = plan->points_lane,
                            .row_points = plan->points_row,
                            .sheet_points = plan->points_sheet,
                            .lane_basis = lane,
                            .row_basis = row,
                            .sheet_basis = sheet,
                            .fewer = plan->image_order && plan->points_sheet < B};
    cvol_sheet_basis(lane, B, axes.lane_points, (B < 16 ? 16 : B));
    cvol_sheet_basis(row, B, axes.row_points, axes.row_points);
    cvol_sheet_basis(sheet, B, axes.sheet_points, axes.sheet_points);
    for (int i = 0; i < 2 && B == 16; i++) {
        const int side = i ? 4 : 8;
        float *parts = state->bases + (3 + 3 * i) * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX;
        float *rows = parts + CVOL_BLOCK_MAX * CVOL_BLOCK_MAX,
              *sheets = rows + CVOL_BLOCK_MAX * CVOL_BLOCK_MAX;
        cvol_cell_points_basis(parts, side, axes.lane_points, B);
        cvol_cell_points_basis(rows, side, axes.row_points, axes.row_points);
        axes.lane_parts[i] = parts;
        axes.row_parts[i] = rows;
        cvol_cell_points_basis(sheets, side, axes.sheet_points, axes.sheet_points);
        axes.sheet_parts[i] = sheets;
    }
    return axes;
}

/* The mean distance between the array's samples and the original ones; NAN if unknown. */
static double find_error(const cvol_array *array)
{
    return array->error_bound.l2_error / sqrt((double)cvol_grid_samples(&array->grid));
}

/* The mean error, in int16 units, from which maxima and minima are drawn from int16: the rounding
 * of int16 is then a small part of it. */
#define INT16_ERROR_MIN 4

/* The int16 format of maxima and minima: if pixels and samples are equally far apart, and the
 * array's error is larger than an int16 unit. */
static cvol_int16_scale choose_int16_extremes(const cvol_sheet_plan *plan, const cvol_array *array)
{
    const double range = array->range_max - array->range_min;
    /* Between samples, if points are fewer, values overshoot. */
    const double beyond = plan->lapped                      ? CVOL_INT16_MAX / 2.8
                          : cvol_extremes_have_bounds(plan) ? 64
                                                            : CVOL_INT16_MAX / 8.0;
    const double scale = (CVOL_INT16_MAX - 2 * beyond) / range;
    if (plan->du != plan->pitch_lane || !(find_error(array) * scale >= INT16_ERROR_MIN))
        return (cvol_int16_scale){0, 0};
    return (cvol_int16_scale){(float)scale,
                              (float)(beyond - scale * (array->range_min - array->offset))};
}

/* The int16 format of an array's samples. Samples that the filter across faces has not yet mixed
 * may lie outside of the range. */
static cvol_int16_scale int16_scale_of(const cvol_array *array, int lapped)
{
    const double least = lapped ? CVOL_INT16_MAX / 2.8 : 64, most = CVOL_INT16_MAX - least;
    const double scale = (most - least) / (array->range_max - array->range_min);
    return (cvol_int16_scale){(float)scale,
                              (float)(least - scale * (array->range_min - array->offset))};
}

/* Light depends on the direction of a gradient, whatever its length: where samples hardly change,
 * int16 shows terraces. The array's own error covers them if it is this number of int16 units. */
#define LIT_INT16_ERROR_MIN 8

static int fits_lit_int16(const cvol_array *array, int lapped)
{
    return find_error(array) * (double)int16_scale_of(array, lapped).scale >= LIT_INT16_ERROR_MIN;
}

/* The int16 format of a composite, if int16 samples separate the table's entries. */
static cvol_int16_scale choose_int16(cvol_sheet_table *table, const cvol_sheet_plan *plan,
                                     const cvol_array *array)
{
    const cvol_int16_scale int16 = int16_scale_of(array, plan->lapped);
    if (plan->lit)
        return !plan->image_order || cvol_sheet_plan_fits_lit_int16(plan)
                   ? int16
                   : (cvol_int16_scale){0, 0};
    cvol_int16_table_fill(&table->int16, table, int16.scale, int16.offset);
    return table->int16.usable ? int16 : (cvol_int16_scale){0, 0};
}

/* Table coordinates for a surface: as for a function that is opaque from its value on. */
static int set_surface(cvol_context *context, cvol_sheet_table *table, cvol_visibility *visibility,
                       const cvol_array *array, const cvol_render_options *options)
{
    const cvol_surface *surface = &options->surface;
    const cvol_transfer_point points[2] = {{surface->value, 0, 0, 0, 0},
                                           {surface->value, 0, 0, 0, 1}};
    cvol_transfer *step;
    const int code = cvol_transfer_create(context, &step, points, 2);
    if (code)
        return code;
    cvol_visibility_make(visibility, array, step);
    cvol_sheet_table_fill(table, array, step, 1, 0);
    table->at = (float)(surface->value - array->offset - (double)table->from) * table->scale;
    table->visible_from = table->at;
    table->visible_to = INFINITY;
    for (int c = 0; c < 3; c++)
        table->colour[c] = (float)surface->colour[c];
    double window[2];
    cvol_window_of_cuts(window, options, array->error_bound.value_min,
                        array->error_bound.value_max);
    const double origin = array->offset + (double)table->from;
    table->cut_black = (float)(window[0] - origin) * table->scale;
    table->cut_scale = 1 / ((float)(window[1] - window[0]) * table->scale);
    cvol_transfer_free(step);
    return CVOL_OK;
}

/* The number of samples between slices, so that they are at most this far apart. */
static int choose_parts(const cvol_sheet_plan *plan, double step_voxels)
{
    if (!(step_voxels > 0) || plan->sheets == 1)
        return 1;
    const double parts = ceil(plan->distance / step_voxels - 1e-9);
    return parts < 1 ? 1 : parts > CVOL_PARTS ? CVOL_PARTS : (int)parts;
}

/* Sets the table of a frame; for a surface also its visibility. The sample format follows from
 * it. */
static int set_table(cvol_context *context, sheet_state *state, cvol_sheet_plan *plan,
                     const cvol_sheet_source *source, cvol_visibility *by_surface,
                     const cvol_render_options *options, const cvol_policy *policy)
{
    cvol_sheet_table *table = state->table;
    const int wants_int16 = policy->samples == CVOL_SAMPLES_INT16;
    table->is_surface = options->mode == CVOL_MODE_ISO;
    plan->int16 = (cvol_int16_scale){0, 0};
    if (table->is_surface)
        return set_surface(context, table, by_surface, source->array, options);
    if (cvol_mode_is_grey(options->mode)) {
        if (wants_int16)
            plan->int16 = choose_int16_extremes(plan, source->array);
        return CVOL_OK;
    }
    cvol_sheet_table_fill(table, source->array, state->transfer, plan->distance / plan->parts,
                          state->traits.noise);
    if (policy->intervals == CVOL_INTERVALS_COARSE ||
        (policy->intervals == CVOL_INTERVALS_COARSE_IF_TRANSLUCENT && table->is_translucent))
        table->flat = table->flat_coarse;
    const double shear = plan->pitch_sheet * (fabs(plan->shear_lane) / plan->pitch_lane +
                                              fabs(plan->shear_row) / plan->pitch_row);
    if (plan->pitch_sheet > 1) /* what lies between two slices is unknown: no finer parts */
        table->midpoint = table->midpoint_ramp = table->flat;
    else if (plan->image_order)
        cvol_sheet_table_image_order(table, shear, state->traits.noise, plan->lit);
    if (wants_int16 && plan->parts == 1)
        plan->int16 = choose_int16(table, plan, source->array);
    return CVOL_OK;
}

/* The case of a picture, for the policy. */
static cvol_policy_case case_of(const sheet_state *state, const cvol_sheet_source *source,
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
        .fits_lit_int16 = fits_lit_int16(array, state->array->lapped && !level),
        .masked = cvol_sheet_source_masked(source, state->array->mask),
        .is_thin = n[0] == 1 || n[1] == 1 || n[2] == 1,
        .has_range = array->range_max > array->range_min,
        .cpu = cvol_cpu_best(),
    };
}

/* The inputs of a plan's frame, in addition to its plan and its image. */
typedef struct drawing {
    sheet_state *state;
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
    sheet_state *state = of->state;
    const cvol_sheet_source *source = of->source;
    const cvol_render_options *options = of->options;
    const cvol_array *array = state->array;
    const int threads = cvol_context_threads(context);
    const int colour = !cvol_mode_is_grey(options->mode);
    const int band_lines = cvol_work_stealing_lines(plan, threads);
    if (!prepare_image(state, plan, image->depth != NULL, threads) ||
        !prepare_bands(state, plan, threads, band_lines))
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
        .axes = plan->level ? (cvol_block_axes){0} : make_axes(state, plan),
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
    sheet_state *state = of->state;
    if (!prepare_image(state, plan, 0, cvol_context_threads(context)))
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
    const sheet_state *state = of->state;
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
    sheet_state *state = of->state;
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
    sheet_state *state = of->state;
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
    return set_table(context, state, plan, of->source, &of->by_surface, of->options, &policy);
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
static int draw_plan(cvol_context *context, sheet_state *state, const cvol_sheet_source *source,
                     cvol_image *image, cvol_sheet_plan *plan, const cvol_view *view,
                     const cvol_render_options *options, const double progress[2])
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

/* A picture in perspective: draws the view along each of the axes, one after the other. */
static int draw_all_along(cvol_context *context, sheet_state *state,
                          const cvol_sheet_source *source, cvol_image *image, const cvol_view *view,
                          const cvol_render_options *options)
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

/* A picture in parallel projection. If it is drawn from int16 samples, it stays the same when its
 * depth is requested: depth needs floats, and is drawn after it. */
static int draw_parallel(cvol_context *context, sheet_state *state, const cvol_sheet_source *source,
                         cvol_image *image, cvol_sheet_plan *plan, const cvol_view *view,
                         const cvol_render_options *options)
{
    const cvol_policy_case in = case_of(state, source, view, options, 0);
    const int both = image->depth && in.mode == CVOL_MODE_COMPOSITE &&
                     (!in.lit || cvol_policy_choose(&in).order == CVOL_RAY_ORDER_IMAGE);
    const double share = both ? 0.5 : 1, whole[2] = {0, share}, rest[2] = {share, 1 - share};
    int code = draw_plan(context, state, source, image, plan, view, options, whole);
    if (code || !both)
        return code;
    float *const depth = image->depth;
    image->depth = NULL;
    code = draw_plan(context, state, source, image, plan, view, options, rest);
    image->depth = depth;
    return code;
}

static int check_footprint(cvol_context *context, const cvol_sheet_options *options)
{
    const int kind = (int)options->footprint;
    const double sigma = options->sigma;
    if (kind < CVOL_SHEET_LINEAR || kind > CVOL_SHEET_GAUSSIAN)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "footprint %d is unknown to engine sheet",
                         kind);
    if ((int)options->ray_order < CVOL_RAY_ORDER_AUTO || options->ray_order > CVOL_RAY_ORDER_OBJECT)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "ray order is %d, must be 0, 1 or 2",
                         (int)options->ray_order);
    if (sigma != 0 && !(sigma >= CVOL_FILTER_SIGMA_MIN && sigma <= CVOL_FILTER_SIGMA_MAX))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "sigma %g: engine sheet has Gaussians of %g to %g samples", sigma,
                         CVOL_FILTER_SIGMA_MIN, CVOL_FILTER_SIGMA_MAX);
    return CVOL_OK;
}

/* Sets the distances of rays and of points of a picture in parallel projection. */
static void choose_spacing(const sheet_state *state, const cvol_sheet_source *source,
                           cvol_view *view, const cvol_render_options *options)
{
    const cvol_policy_case in = case_of(state, source, view, options, 0);
    const cvol_policy policy = cvol_policy_choose(&in);
    view->apart = policy.rays_apart;
    view->coarsest = policy.coarsest;
}

/* Gives the samples of all parts of a picture the same range: number formats and tables depend on
 * it. */
static int share_range(cvol_context *context, const sheet_state *state, cvol_sheet_source *source,
                       int code)
{
    double range[2] = {INFINITY, -INFINITY};
    if (!code) {
        range[0] = source->array->range_min;
        range[1] = source->array->range_max;
    }
    code = state->combine->widen(state->combine->data, context, code, range);
    return code ? code : cvol_sheet_source_widen(context, source, range, state->transfer);
}

/* Finds the light that reaches places in the volume. */
static int find_reach(cvol_context *context, sheet_state *state, const cvol_view *view,
                      const cvol_render_options *options)
{
    const cvol_grid *grid = &state->array->grid;
    int code = CVOL_OK;
    if (!state->reach.coarse.values) {
        code = cvol_coarse_of_array(context, &state->reach.coarse, state->whole);
        if (!code)
            code = cvol_coarse_surround(context, &state->reach.coarse);
    }
    return code ? code
                : cvol_reach_find(context, &state->reach, grid, state->transfer, view, options);
}

static int sheet_draw(cvol_context *context, void *opaque_state, cvol_image *image,
                      const cvol_view *view, const cvol_render_options *options)
{
    sheet_state *state = opaque_state;
    cvol_sheet_source *source = NULL;
    cvol_sheet_plan plan;
    int code = check_footprint(context, &options->sheet);
    if (!code)
        code = find_source(context, &source, state, options->level);
    if (!code && cvol_reach_suits(options))
        code = find_reach(context, state, view, options);
    if (state->combine)
        code = share_range(context, state, source, code);
    if (code)
        return code;
    cvol_reconstruction_filter_make(&state->wide, &options->sheet);
    if (view->perspective)
        return draw_all_along(context, state, source, image, view, options);
    cvol_view seen = *view;
    choose_spacing(state, source, &seen, options);
    code = cvol_sheet_plan_make(context, &plan, state->array,
                                source->level.samples ? options->level : 0, &seen);
    return code ? code : draw_parallel(context, state, source, image, &plan, &seen, options);
}

static uint64_t sheet_cache_bytes(const void *opaque_state)
{
    const sheet_state *state = opaque_state;
    return atomic_load(&state->cache.store.taken);
}

const cvol_engine_table cvol_sheet_engine = {.free = sheet_free,
                                             .set_transfer = sheet_set_transfer,
                                             .draw = sheet_draw,
                                             .kept_bytes = sheet_cache_bytes,
                                             .has_clip = 1,
                                             .has_perspective = 1,
                                             .has_depth = 1,
                                             .has_illumination = 1};

int cvol_renderer_set_combine(cvol_context *context, cvol_renderer *renderer,
                              const cvol_sheet_combine *combine)
{
    if (renderer->engine != &cvol_sheet_engine)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "several processes draw by engine sheet only");
    ((sheet_state *)renderer->state)->combine = combine;
    return CVOL_OK;
}

int cvol_renderer_sheet_multiply_adds(cvol_context *context, cvol_renderer *renderer,
                                      cvol_image *image, const cvol_render_options *options,
                                      uint64_t *out)
{
    if (renderer->engine != &cvol_sheet_engine)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "this renderer is not of engine sheet");
    cvol_render_options full;
    int code = cvol_render_options_complete(context, &full, options);
    if (code)
        return code;
    if (full.mode != CVOL_MODE_COMPOSITE || full.shading.on || full.level ||
        full.sheet.footprint != CVOL_SHEET_LINEAR)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "multiply-adds are counted in mode composite, unlit, at level 0 and of "
                         "linear footprints");
    sheet_state *state = renderer->state;
    state->counts = 1;
    state->multiply_adds = 0;
    code = cvol_renderer_render(context, renderer, image, &full);
    state->counts = 0;
    *out = state->multiply_adds;
    return code;
}
