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

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/evaluate/decoded_terms.h"
#include "base/context.h"
#include "base/memory.h"
#include "render/sheet/coarse_level.h"
#include "render/sheet/state.h"
#include "render/view/options.h"

static void sheet_free(void *opaque_state)
{
    cvol_sheet_state *state = opaque_state;
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
    cvol_sheet_state *state = cvol_allocate_zero(1, sizeof *state);
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
    cvol_sheet_state *state = opaque_state;
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
static int find_source(cvol_context *context, cvol_sheet_source **out, cvol_sheet_state *state,
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

/* Gives the samples of all parts of a picture the same range: number formats and tables depend on
 * it. */
static int share_range(cvol_context *context, const cvol_sheet_state *state,
                       cvol_sheet_source *source, int code)
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
static int find_reach(cvol_context *context, cvol_sheet_state *state, cvol_view *view,
                      const cvol_render_options *options)
{
    const cvol_grid *grid = &state->array->grid;
    int code = CVOL_OK;
    if (!state->reach.coarse.values) {
        code = cvol_coarse_of_array(context, &state->reach.coarse, state->whole);
        if (!code)
            code = cvol_coarse_surround(context, &state->reach.coarse);
    }
    if (!code)
        code = cvol_reach_find_cuts(context, &state->reach, view, grid, state->transfer, options);
    return code ? code
                : cvol_reach_find(context, &state->reach, grid, state->transfer, view, options);
}

static int sheet_draw(cvol_context *context, void *opaque_state, cvol_image *image,
                      const cvol_view *view, const cvol_render_options *options)
{
    cvol_sheet_state *state = opaque_state;
    cvol_sheet_source *source = NULL;
    cvol_view cut = *view;
    int code = check_footprint(context, &options->sheet);
    if (!code)
        code = find_source(context, &source, state, options->level);
    if (!code && cvol_reach_suits(options))
        code = find_reach(context, state, &cut, options);
    if (state->combine)
        code = share_range(context, state, source, code);
    if (code)
        return code;
    cvol_reconstruction_filter_make(&state->wide, &options->sheet);
    return view->perspective
               ? cvol_sheet_draw_perspective(context, state, source, image, &cut, options)
               : cvol_sheet_draw_parallel(context, state, source, image, &cut, options);
}

static uint64_t sheet_cache_bytes(const void *opaque_state)
{
    const cvol_sheet_state *state = opaque_state;
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
    ((cvol_sheet_state *)renderer->state)->combine = combine;
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
    cvol_sheet_state *state = renderer->state;
    state->counts = 1;
    state->multiply_adds = 0;
    code = cvol_renderer_render(context, renderer, image, &full);
    state->counts = 0;
    *out = state->multiply_adds;
    return code;
}
