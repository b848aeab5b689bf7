/* Draws lapped arrays layer after layer, like other arrays. But the last two slices of a layer wait
 * until the next layer's first two are evaluated, since the filter mixes these four.
 *
 * Blocks that are drawn (cvol_layer_skip's `touched`) are evaluated whole. In the layers before and
 * behind, their neighbours need only the two slices at the face. Within a layer, the blocks around
 * any visible one are among the drawn ones. */
#include "render/sheet/band/lapped.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "render/sheet/band/band_samples.h"
#include "render/sheet/band/work_stealing.h"

int cvol_lapped_prepare(cvol_lapped_memory *memory, const cvol_sheet_plan *plan)
{
    const size_t blocks = plan->blocks_lane * plan->blocks_row;
    for (int i = 0; i < 3; i++) {
        cvol_lapped_layer *layer = &memory->layers[i];
        if (!cvol_layer_skip_prepare(&layer->skip, plan) ||
            !cvol_ensure(&layer->have, &layer->have_capacity, blocks, 1) ||
            !cvol_ensure(&layer->seen, &layer->seen_capacity, plan->blocks_row, 1))
            return 0;
    }
    return 1;
}

void cvol_lapped_free(cvol_lapped_memory *memory)
{
    for (int i = 0; i < 3; i++) {
        cvol_layer_skip_free(&memory->layers[i].skip);
        free(memory->layers[i].have);
        free(memory->layers[i].seen);
    }
}

/* Places a layer's slices in the order in which rays meet them: in every other layer from the
 * band's third slice on to its last, in the layers between backwards from its last but two. So the
 * two waiting slices of a layer do not overlap the next one. */
static void place_sheets(cvol_lapped_layer *layer, const cvol_band_memory *memory, size_t step,
                         const cvol_sheet_plan *plan)
{
    const int points = plan->points_sheet, ascending = plan->ascending;
    const ptrdiff_t stride = memory->sheet_stride, way = step % 2 ? -1 : 1;
    const ptrdiff_t first_intersected = step % 2 ? points - 1 : 2;
    layer->sheet_stride = ascending ? way * stride : -way * stride;
    layer->samples = cvol_sample_at(
        plan, memory->samples,
        (ascending ? first_intersected : first_intersected + way * (points - 1)) * stride);
}

/* Prepares a layer before its first block is evaluated. It examines blocks two rows beyond the
 * lines: the adjacent layers reach one row further, and the row after that decides if a block is
 * drawn. */
static void open_layer(cvol_band_memory *memory, const cvol_sheet_frame *frame, size_t step,
                       const cvol_band *band)
{
    cvol_lapped_layer *layer = &memory->lapped.layers[step % 3];
    const cvol_sheet_plan *plan = frame->plan;
    layer->reached = 0;
    if (step >= plan->layers)
        return;
    cvol_band_layer *at = &layer->at;
    at->layer = plan->ascending ? step : plan->layers - 1 - step;
    at->tile_begin = band->begin / CVOL_TILE;
    at->tile_end = cvol_band_tile_end(band);
    cvol_layer_sheets(&at->z_begin, &at->z_end, plan, at->layer);
    if (!cvol_layer_rows(&at->first_row, &at->last_row, plan, at->layer, band->begin, band->end))
        return;
    layer->reached = 1;
    place_sheets(layer, memory, step, plan);
    layer->count = (int)(at->z_end - at->z_begin);
    layer->held = cvol_lapped_face(at->layer + (size_t)plan->ascending, plan->sheets) ? 2 : 0;
    const cvol_extremes_seen extremes = cvol_band_extremes(frame, band);
    const cvol_skip_source source = cvol_band_skip_source(frame, &extremes);
    cvol_layer_skip_make(
        &layer->skip, &source, at->layer, at->first_row > 2 ? at->first_row - 2 : 0,
        at->last_row + 2 < plan->blocks_row ? at->last_row + 2 : plan->blocks_row - 1);
    memset(layer->have, 0, plan->blocks_lane * plan->blocks_row);
    memset(layer->seen, 0, plan->blocks_row);
}

/* The needed parts of a block: `low` and `high` are the layers before and behind. */
static int needed_parts_of(const cvol_lapped_layer *layer, const cvol_lapped_layer *low,
                           const cvol_lapped_layer *high, const cvol_sheet_plan *plan, size_t cell)
{
    if (layer->skip.touched[cell] == CVOL_TOUCHED_DRAWN)
        return CVOL_HAVE_ALL;
    int what = 0;
    if (low->reached && low->skip.touched[cell] == CVOL_TOUCHED_DRAWN &&
        cvol_lapped_face(layer->at.layer, plan->sheets))
        what |= CVOL_HAVE_LOW;
    if (high->reached && high->skip.touched[cell] == CVOL_TOUCHED_DRAWN &&
        cvol_lapped_face(layer->at.layer + 1, plan->sheets))
        what |= CVOL_HAVE_HIGH;
    return what;
}

static void evaluate_cell(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                          const cvol_lapped_layer *layer, size_t lane, size_t row, int what,
                          cvol_block_visibility seen)
{
    const cvol_band_layer *at = &layer->at;
    const cvol_sheet_plan *plan = frame->plan;
    void *out = cvol_sample_at(plan, layer->samples,
                               CVOL_SHEET_PAD + (ptrdiff_t)lane * plan->points_lane +
                                   (1 + (ptrdiff_t)(row - at->first_row) * plan->points_row) *
                                       memory->row_stride);
    cvol_block_axes axes = frame->axes;
    const size_t index = cvol_sheet_block_index(plan, frame->array, lane, row, at->layer);
    if (memory->cover_at &&
        layer->skip.touched[row * plan->blocks_lane + lane] == CVOL_TOUCHED_DRAWN) {
        const cvol_sheet_piece piece = {cvol_sample_at(plan, out, memory->cover_at),
                                        memory->row_stride,
                                        layer->sheet_stride,
                                        0,
                                        plan->points_row,
                                        0,
                                        plan->points_sheet};
        cvol_sheet_mask_cover(&piece, plan, frame->mask_points, frame->mask, index);
    }
    const int is_whole = what == CVOL_HAVE_ALL; /* only whole blocks are cached */
    const cvol_cached_block block = cvol_cached_block_of(&frame->cache, index, lane, row, at->layer,
                                                         seen == CVOL_BLOCK_SHARED);
    if (is_whole &&
        cvol_block_cache_take(&frame->cache, &block, out, memory->row_stride, layer->sheet_stride))
        return;
    axes.sheet_ends = is_whole ? 0 : what;
    cvol_band_evaluate(memory, frame, out, layer->sheet_stride, index, &axes);
    if (is_whole)
        cvol_block_cache_put(&frame->cache, &block, out, memory->row_stride, layer->sheet_stride);
}

static void evaluate_row(cvol_band_memory *memory, const cvol_sheet_frame *frame, size_t step,
                         size_t row)
{
    const cvol_sheet_plan *plan = frame->plan;
    cvol_lapped_layer *layers = memory->lapped.layers, *layer = &layers[step % 3];
    const cvol_lapped_layer *low = &layers[(step + (plan->ascending ? 2 : 1)) % 3];
    const cvol_lapped_layer *high = &layers[(step + (plan->ascending ? 1 : 2)) % 3];
    const cvol_band_layer *at = &layer->at;
    const size_t z_begin = at->z_begin > 2 ? at->z_begin - 2 : 0;
    const size_t z_end = at->z_end + 2 < plan->sheet_count ? at->z_end + 2 : plan->sheet_count;
    for (size_t lane = 0; lane < plan->blocks_lane; lane++) {
        const size_t cell = row * plan->blocks_lane + lane;
        const int what = needed_parts_of(layer, low, high, plan, cell);
        cvol_band_prefetch(frame, &layer->skip, at, lane + 2, row);
        if (!what)
            continue;
        const cvol_block_visibility seen = cvol_block_test_visibility(
            frame->tiles, plan, lane, row, z_begin, z_end, at->tile_begin, at->tile_end);
        if (seen == CVOL_BLOCK_HIDDEN)
            continue;
        evaluate_cell(memory, frame, layer, lane, row, what, seen);
        layer->have[cell] = (uint8_t)what;
        layer->seen[row] = 1;
        cvol_lapped_filter_lane(memory, frame, layer, lane, row);
    }
}

/* Two views of a layer: of the slices that can be drawn now, and, stored with it, of the slices
 * that wait. */
static void describe(cvol_layer *now, const cvol_band_memory *memory, const cvol_sheet_frame *frame,
                     cvol_lapped_layer *layer, const cvol_lapped_layer *before)
{
    cvol_layer_describe(now, layer->samples, memory->row_stride, layer->sheet_stride, &layer->skip,
                        before->reached ? &before->skip : NULL, frame->plan, &layer->at);
    now->cover_at = memory->cover_at;
    now->bounded = frame->extremes.sign != 0;
    now->sheet_count -= layer->held;
    layer->drawn = *now;
    layer->drawn.sheet_count = layer->held;
    for (int i = 0; i < layer->held; i++)
        layer->drawn.sheets[i] = now->sheets[now->sheet_count + i];
}

/* Joins the waiting slices of the layer before and the slices of `now`: a line takes all of them
 * together. */
static void join(cvol_layer *out, const cvol_layer *held, const cvol_layer *now)
{
    *out = *now;
    out->sheet_count = held->sheet_count + now->sheet_count;
    for (int i = 0; i < held->sheet_count; i++) {
        out->sheets[i] = held->sheets[i];
        out->sheets[i].is_of_previous_layer = 1;
    }
    for (int i = 0; i < now->sheet_count; i++)
        out->sheets[held->sheet_count + i] = now->sheets[i];
    for (int k = 0; k < out->fades; k++) /* from the first slice on, which is now a waiting one */
        for (int d = 0; d < 3; d++)
            out->fade[k].value[d] -= held->sheet_count * out->fade[k].rate[d];
}

/* Opens the layer behind this one, and, for the first opened layer, this one, too. */
static void open_layers(cvol_band_memory *memory, const cvol_sheet_frame *frame, size_t step,
                        const cvol_band *band)
{
    if (step == 0) {
        memory->lapped.layers[2].reached = 0;
        open_layer(memory, frame, 0, band);
    }
    open_layer(memory, frame, step + 1, band);
}

/* Evaluates rows of a layer from *next_row to `last`. */
static void evaluate_rows(cvol_band_memory *memory, const cvol_sheet_frame *frame, size_t step,
                          size_t *next_row, size_t last)
{
    const cvol_lapped_layer *layers = memory->lapped.layers;
    for (; *next_row <= last; ++*next_row) {
        evaluate_row(memory, frame, step, *next_row);
        cvol_lapped_filter_row(memory, frame, &layers[step % 3], &layers[(step + 2) % 3],
                               *next_row);
    }
}

void cvol_lapped_evaluate_rest(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                               const cvol_band *band)
{
    const size_t step = band->step - 1;
    cvol_lapped_layer *layers = memory->lapped.layers, *layer = &layers[step % 3],
                      *before = &layers[(step + 2) % 3];
    if (step > 0) {
        open_layer(memory, frame, step - 1, band);
        open_layer(memory, frame, step, band);
    }
    open_layers(memory, frame, step, band);
    if (!layer->reached)
        return;
    describe(&memory->lapped.now, memory, frame, layer, before);
    size_t next_row = layer->at.first_row;
    evaluate_rows(memory, frame, step, &next_row, layer->at.last_row);
}

void cvol_lapped_draw(cvol_work_stealing *share, int thread, cvol_band *band)
{
    const cvol_sheet_frame *frame = share->frame;
    cvol_band_memory *memory = &share->bands[thread];
    const size_t step = band->step;
    const cvol_sheet_plan *plan = frame->plan;
    cvol_lapped_layer *layers = memory->lapped.layers, *layer = &layers[step % 3],
                      *before = &layers[(step + 2) % 3];
    open_layers(memory, frame, step, band);
    if (!layer->reached)
        return;
    cvol_layer *now = &memory->lapped.now, *first_sheet = &memory->lapped.first_sheet;
    cvol_layer *all = &memory->lapped.all, *all_and_first = &memory->lapped.all_and_first;
    describe(now, memory, frame, layer, before);
    *first_sheet = *now;
    first_sheet->sheet_count = 1;
    /* Kernels for int16 samples, and with light in image order, find each slice by its own address;
     * the latter interpolate better within a layer than from one to the next. */
    const int joins = (plan->int16.scale > 0 || (plan->image_order && plan->lit)) &&
                      before->reached;
    if (joins) {
        join(all, &before->drawn, now);
        join(all_and_first, &before->drawn, first_sheet);
    }
    size_t next_row = layer->at.first_row;
    for (int from = band->begin; from < band->end; from += CVOL_TILE) {
        size_t first, last;
        cvol_work_stealing_tile(share, thread, band, from);
        if (from >= band->end)
            break;
        const int to = from + CVOL_TILE < band->end ? from + CVOL_TILE : band->end;
        layer->at.tile_end = cvol_band_tile_end(band);
        if (!cvol_layer_rows(&first, &last, plan, layer->at.layer, from, to))
            continue;
        evaluate_rows(memory, frame, step, &next_row, last);
        const size_t rows = last - first + 1;
        const int drawn = before->reached && memchr(before->seen + first, 1, rows);
        const int here = memchr(layer->seen + first, 1, rows) != NULL;
        for (int j = from; j < to && (drawn || here); j += cvol_lines_interleaved(plan)) {
            const cvol_line line = cvol_band_line_of(memory, frame, j);
            if (drawn && joins) {
                frame->kernel(here ? all : all_and_first, frame->table, &line);
                continue;
            }
            if (drawn)
                frame->kernel(&before->drawn, frame->table, &line);
            frame->kernel(here ? now : first_sheet, frame->table, &line);
        }
        if (drawn || here)
            cvol_extremes_update(&frame->extremes, frame->tiles, frame->intermediate, from, to);
    }
}
