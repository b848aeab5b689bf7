/* The sheet engine: pictures straight from the compressed array, sheet by sheet, front to back.
 *
 * Westover's sheet buffers ("Footprint Evaluation for Volume Rendering", 1990) on Lacroute and
 * Levoy's shear-warp geometry: the principal axis' layers of blocks are met front to back; of each
 * layer the blocks that can be seen are inversely transformed (pruned to their own low boxes) into
 * one buffer of samples; every line of the intermediate image then takes the layer's sheets in
 * turn: reconstruct, classify, composite. One 2-D warp makes the picture. Memory: one layer of
 * samples, whatever the volume's depth.
 *
 * Blocks and lines are independent of each other, so the picture does not depend on the number of
 * threads.
 */
#include "render/sheet.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/sheet_skip.h"

typedef struct sheet_state {
    const cvol_array *array;
    cvol_transfer *transfer;
    cvol_visibility by_transfer, everything;
    cvol_sheet_table *table;
    cvol_intermediate intermediate;
    cvol_tiles tiles;
    cvol_layer_skip skip;
    float *samples;
    size_t sample_capacity, line_capacity, scratch_capacity, span_capacity, opaque_capacity,
        tile_capacity, skip_capacity;
    float *bases;   /* lane, row and sheet basis of the frame */
    uint32_t *seen; /* blocks of a layer to evaluate: row * blocks_lane + lane */
    size_t seen_capacity;
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
    free(state->tiles.open);
    free(state->skip.within);
    free(state->samples);
    free(state->bases);
    free(state->seen);
    free(state);
}

int cvol_sheet_create(cvol_context *context, void **out, const cvol_array *array)
{
    *out = NULL;
    sheet_state *state = cvol_allocate_zero(1, sizeof *state);
    if (!state)
        return cvol_fail_memory(context, sizeof *state, "a renderer");
    state->array = array;
    state->table = cvol_allocate_zero(1, sizeof *state->table);
    state->bases = cvol_allocate_zero(3 * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX, sizeof(float));
    if (!state->table || !state->bases) {
        sheet_free(state);
        return cvol_fail_memory(context, sizeof *state->table, "a renderer");
    }
    cvol_visibility_make(&state->everything, array, NULL);
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
    cvol_visibility_make(&state->by_transfer, state->array, copy);
    return CVOL_OK;
}

/* ---- what a frame needs before its first layer --------------------------------------------- */

/* Grows *memory to `count` elements; what it held is lost. New memory is zero, so that samples
 * which are loaded but weigh nothing are at least numbers. */
static int ensure(void *memory_pointer, size_t *capacity, size_t count, size_t size)
{
    void **memory = memory_pointer;
    if (count <= *capacity)
        return 1;
    free(*memory);
    *capacity = 0;
    *memory = cvol_allocate_zero(count, size);
    if (!*memory)
        return 0;
    *capacity = count;
    return 1;
}

static long sample_row_stride(const cvol_sheet_plan *plan)
{
    size_t lanes = plan->blocks_lane * (size_t)plan->points_lane;
    return (long)((lanes + 2 * CVOL_SHEET_PAD + 15) / 16 * 16);
}

static long sample_sheet_stride(const cvol_sheet_plan *plan)
{
    return (long)(plan->blocks_row * (size_t)plan->points_row + 2) * sample_row_stride(plan);
}

static int prepare_memory(cvol_context *context, sheet_state *state, const cvol_sheet_plan *plan)
{
    const size_t threads = (size_t)cvol_context_threads(context);
    cvol_intermediate *image = &state->intermediate;
    image->width = plan->width;
    image->height = plan->height;
    state->tiles.across = plan->width / CVOL_TILE;
    state->tiles.down = (plan->height + CVOL_TILE - 1) / CVOL_TILE;
    state->skip.windows = cvol_layer_windows(plan);
    const size_t groups = (size_t)(plan->width / CVOL_GROUP);
    const size_t blocks = plan->blocks_lane * plan->blocks_row;
    const size_t windows = plan->blocks_row * (size_t)state->skip.windows;
    if (!ensure(&image->lines, &state->line_capacity,
                4 * (size_t)plan->width * (size_t)plan->height, sizeof(float)) ||
        !ensure(&image->scratch, &state->scratch_capacity, 4 * (size_t)plan->width * threads,
                sizeof(float)) ||
        !ensure(&image->spans, &state->span_capacity, 2 * (size_t)plan->height, sizeof(int)) ||
        !ensure(&image->opaque, &state->opaque_capacity, groups * (size_t)plan->height, 1) ||
        !ensure(&state->tiles.open, &state->tile_capacity,
                (size_t)state->tiles.across * (size_t)state->tiles.down, 1) ||
        !ensure(&state->skip.within, &state->skip_capacity, 2 * windows + blocks, 1) ||
        !ensure(&state->seen, &state->seen_capacity, blocks, sizeof *state->seen) ||
        !ensure(&state->samples, &state->sample_capacity,
                (size_t)sample_sheet_stride(plan) * (size_t)state->array->block, sizeof(float)))
        return cvol_fail(context, CVOL_ERROR_MEMORY,
                         "not enough memory to render into an intermediate image of %d x %d",
                         plan->width, plan->height);
    state->skip.across = state->skip.within + windows;
    state->skip.touched = state->skip.across + windows;
    return CVOL_OK;
}

/* D[u] at `points` points of a block of side B, rows `width` long. */
static void fill_basis(float *basis, int B, int points, int width)
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
                            .lane_width = plan->points_lane > 16 ? 32 : 16,
                            .row_points = plan->points_row,
                            .sheet_points = B,
                            .lane_basis = lane,
                            .row_basis = row,
                            .sheet_basis = sheet};
    fill_basis(lane, B, axes.lane_points, axes.lane_width);
    fill_basis(row, B, axes.row_points, axes.row_points);
    fill_basis(sheet, B, B, B);
    return axes;
}

/* Tabulates the transfer function over what of it the data reach, with opacities for the distance
 * between sheets. */
static void fill_table(cvol_sheet_table *table, const cvol_array *array,
                       const cvol_transfer *transfer, double distance)
{
    double lo = transfer->points[0].value, hi = transfer->points[transfer->count - 1].value;
    lo = fmin(fmax(lo, array->range_min), array->range_max);
    hi = fmin(fmax(hi, array->range_min), array->range_max);
    double unit = (hi - lo) / (CVOL_TABLE_SIZE - 1);
    if (!(unit > 0))
        unit = 1;
    table->from = (float)(lo - array->offset - 0.5 * unit);
    table->scale = (float)(1 / unit);
    int first = CVOL_TABLE_SIZE, last = -1;
    for (int t = 0; t < CVOL_TABLE_SIZE; t++) {
        cvol_transfer_point p = cvol_transfer_at(transfer, lo + t * unit);
        table->opacity[t] = (float)cvol_opacity_over(p.opacity, distance);
        table->colour[t] = (uint32_t)lround(p.r * 1023) | (uint32_t)lround(p.g * 1023) << 10 |
                           (uint32_t)lround(p.b * 1023) << 20;
        if (p.opacity > 0) {
            first = t < first ? t : first;
            last = t;
        }
    }
    table->visible_from = first == 0 ? -INFINITY : (float)(lo + (first - 1) * unit - array->offset);
    table->visible_to = last == CVOL_TABLE_SIZE - 1
                            ? INFINITY
                            : (float)(lo + (last + 1) * unit - array->offset);
}

static void clear_intermediate(cvol_intermediate *image, cvol_mode mode, int threads)
{
    const size_t width = (size_t)image->width;
    memset(image->opaque, 0, width / CVOL_GROUP * (size_t)image->height);
#pragma omp parallel for num_threads(threads) schedule(static)
    for (int j = 0; j < image->height; j++) {
        float *lines = image->lines + (size_t)j * 4 * width;
        memset(lines, 0, 4 * width * sizeof *lines);
        if (mode == CVOL_MODE_COMPOSITE)
            for (size_t i = 0; i < width; i++)
                lines[3 * width + i] = 1;
    }
}

/* ---- a layer ------------------------------------------------------------------------------ */

static void layer_sheets(size_t *begin, size_t *end, const cvol_sheet_plan *plan, int block,
                         size_t layer)
{
    *begin = layer * (size_t)block;
    *end = *begin + (size_t)block < plan->sheets ? *begin + (size_t)block : plan->sheets;
}

/* The blocks that can be seen through the transfer function and past what is opaque. */
static size_t find_seen(sheet_state *state, const cvol_sheet_plan *plan, size_t layer)
{
    size_t count = 0, begin, end;
    layer_sheets(&begin, &end, plan, state->array->block, layer);
    for (size_t row = 0; row < plan->blocks_row; row++)
        for (size_t lane = 0; lane < plan->blocks_lane; lane++)
            if (state->skip.touched[row * plan->blocks_lane + lane] &&
                cvol_block_is_seen(&state->tiles, plan, state->array->block, lane, row, begin, end))
                state->seen[count++] = (uint32_t)(row * plan->blocks_lane + lane);
    return count;
}

/* Repeats the outermost samples of a coarser grid once, since the volume's faces lie beyond them.
 */
static void extend_faces(float *at, long row_stride, long sheet_stride, const cvol_sheet_plan *plan,
                         int block, size_t lane, size_t row)
{
    const int points_lane = plan->points_lane, points_row = plan->points_row;
    for (int z = 0; z < block; z++) {
        float *sheet = at + z * sheet_stride;
        for (int r = 0; r < points_row && lane == 0; r++)
            sheet[r * row_stride - 1] = sheet[r * row_stride];
        for (int r = 0; r < points_row && lane + 1 == plan->blocks_lane; r++)
            sheet[r * row_stride + points_lane] = sheet[r * row_stride + points_lane - 1];
        size_t bytes = sizeof(float) * (size_t)(points_lane + 2);
        if (row == 0)
            memcpy(sheet - row_stride - 1, sheet - 1, bytes);
        if (row + 1 == plan->blocks_row)
            memcpy(sheet + points_row * row_stride - 1, sheet + (points_row - 1) * row_stride - 1,
                   bytes);
    }
}

static void evaluate_layer(sheet_state *state, const cvol_sheet_plan *plan,
                           const cvol_block_axes *axes, size_t layer, size_t count, int threads)
{
    cvol_sheet_evaluator *evaluate = CVOL_SIMD_CHOOSE(cvol_sheet_evaluate);
    const cvol_array *array = state->array;
    const long row_stride = sample_row_stride(plan), sheet_stride = sample_sheet_stride(plan);
#pragma omp parallel num_threads(threads)
    {
        cvol_block_work work;
#pragma omp for schedule(dynamic, 4)
        for (size_t i = 0; i < count; i++) {
            size_t lane = state->seen[i] % plan->blocks_lane;
            size_t row = state->seen[i] / plan->blocks_lane;
            const cvol_block *block =
                &array->block_table[cvol_sheet_block_index(plan, array, lane, row, layer)];
            float *at = state->samples + CVOL_SHEET_PAD + (long)lane * plan->points_lane +
                        (1 + (long)row * plan->points_row) * row_stride;
            evaluate(at, row_stride, sheet_stride, block, axes, array->block_log2,
                     (float)array->step, &work);
            if (lane == 0 || row == 0 || lane + 1 == plan->blocks_lane ||
                row + 1 == plan->blocks_row)
                extend_faces(at, row_stride, sheet_stride, plan, array->block, lane, row);
        }
    }
}

static int clamp_group(double group, int groups)
{
    return group < 0 ? 0 : group > groups ? groups : (int)group;
}

/* Which groups of a line meet a sheet, and which lie within it whole. */
static void find_groups(cvol_sheet_view *sheet, const cvol_layer *layer, int width)
{
    const double tolerance = 1e-4;
    const int groups = width / CVOL_GROUP;
    double first = (layer->lane_lo - sheet->lane_at) / layer->lane_step;
    double last = (layer->lane_hi - sheet->lane_at) / layer->lane_step;
    sheet->begin = clamp_group(floor(ceil(first - tolerance) / CVOL_GROUP), groups);
    sheet->end = clamp_group(floor(floor(last + tolerance) / CVOL_GROUP) + 1, groups);
    sheet->inside_begin = clamp_group(ceil(first / CVOL_GROUP), groups);
    sheet->inside_end = clamp_group(floor((last + 1) / CVOL_GROUP), groups);
}

static void describe_layer(cvol_layer *out, const sheet_state *state, const cvol_sheet_plan *plan,
                           size_t layer)
{
    const long row_stride = sample_row_stride(plan), sheet_stride = sample_sheet_stride(plan);
    size_t begin, end;
    layer_sheets(&begin, &end, plan, state->array->block, layer);
    out->sheet_count = (int)(end - begin);
    out->row_stride = row_stride;
    out->lane_step = plan->du / plan->pitch_lane;
    out->row_step = plan->dv / plan->pitch_row;
    out->lane_lo = (0 - plan->first_lane) / plan->pitch_lane;
    out->lane_hi = ((double)(plan->lanes - 1) - plan->first_lane) / plan->pitch_lane;
    out->row_lo = (0 - plan->first_row) / plan->pitch_row;
    out->row_hi = ((double)(plan->rows - 1) - plan->first_row) / plan->pitch_row;
    out->row_points = plan->points_row;
    out->block_rows = (int)plan->blocks_row;
    out->within = state->skip.within;
    out->across = state->skip.across;
    out->windows = state->skip.windows;
    for (int s = 0; s < out->sheet_count; s++) {
        size_t slice = plan->ascending ? (size_t)s : (size_t)(out->sheet_count - 1 - s);
        double z = (double)(begin + slice);
        cvol_sheet_view *sheet = &out->sheets[s];
        sheet->samples = state->samples + CVOL_SHEET_PAD + row_stride + (long)slice * sheet_stride;
        sheet->lane_at = (plan->u0 + plan->shear_lane * z - plan->first_lane) / plan->pitch_lane;
        sheet->row_at = (plan->v0 + plan->shear_row * z - plan->first_row) / plan->pitch_row;
        find_groups(sheet, out, plan->width);
    }
}

static void draw_lines(sheet_state *state, const cvol_layer *layer, cvol_sheet_kernel *kernel,
                       int threads)
{
    const cvol_intermediate *image = &state->intermediate;
    const size_t width = (size_t)image->width;
#pragma omp parallel for num_threads(threads) schedule(dynamic, 8)
    for (int j = 0; j < image->height; j++)
        kernel(layer, state->table, image->lines + (size_t)j * 4 * width,
               image->opaque + (size_t)j * (width / CVOL_GROUP), j, image->width);
}

static cvol_sheet_kernel *choose_kernel(cvol_mode mode)
{
    if (mode == CVOL_MODE_COMPOSITE)
        return CVOL_SIMD_CHOOSE(cvol_sheet_composite);
    return mode == CVOL_MODE_MIP ? CVOL_SIMD_CHOOSE(cvol_sheet_max)
                                 : CVOL_SIMD_CHOOSE(cvol_sheet_sum);
}

static int draw_layers(cvol_context *context, sheet_state *state, const cvol_sheet_plan *plan,
                       cvol_mode mode)
{
    const int threads = cvol_context_threads(context);
    const cvol_block_axes axes = make_axes(state, plan);
    const cvol_visibility *visibility = mode == CVOL_MODE_COMPOSITE ? &state->by_transfer
                                                                    : &state->everything;
    cvol_sheet_kernel *kernel = choose_kernel(mode);
    clear_intermediate(&state->intermediate, mode, threads);
    cvol_tiles_update(&state->tiles, &state->intermediate);
    for (size_t step = 0; step < plan->layers; step++) {
        int code = cvol_report_progress(context, "rendering", (double)step / (double)plan->layers);
        if (code)
            return code;
        size_t layer = plan->ascending ? step : plan->layers - 1 - step;
        cvol_layer_skip_make(&state->skip, plan, state->array, visibility, layer);
        size_t count = find_seen(state, plan, layer);
        if (count == 0)
            continue;
        evaluate_layer(state, plan, &axes, layer, count, threads);
        cvol_layer description;
        describe_layer(&description, state, plan, layer);
        draw_lines(state, &description, kernel, threads);
        cvol_tiles_update(&state->tiles, &state->intermediate);
    }
    return cvol_report_progress(context, "rendering", 1);
}

static int sheet_draw(cvol_context *context, void *opaque_state, cvol_image *image,
                      const cvol_view *view, const cvol_render_options *options)
{
    sheet_state *state = opaque_state;
    const cvol_array *array = state->array;
    cvol_sheet_plan plan;
    int code = cvol_sheet_plan_make(context, &plan, array, view);
    if (code || (code = prepare_memory(context, state, &plan)))
        return code;
    if (options->mode == CVOL_MODE_COMPOSITE)
        fill_table(state->table, array, state->transfer, plan.distance);
    code = draw_layers(context, state, &plan, options->mode);
    if (code)
        return code;
    const int threads = cvol_context_threads(context);
    if (options->mode == CVOL_MODE_COMPOSITE)
        cvol_warp_composite(image, &state->intermediate, &plan, options->background, threads);
    else
        cvol_warp_grey(image, &state->intermediate, &plan, array->value_min - array->offset,
                       array->value_max - array->offset, options->background, threads);
    return CVOL_OK;
}

const cvol_engine_table cvol_sheet_engine = {
    .free = sheet_free, .set_transfer = sheet_set_transfer, .draw = sheet_draw};
