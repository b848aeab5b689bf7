/* One band of the intermediate image: for each layer, evaluates the visible blocks, then draws. */
#include "render/sheet/band/band.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "render/sheet/band/band_samples.h"
#include "render/sheet/band/lapped.h"
#include "render/sheet/band/work_stealing.h"

/* ---- memory ------------------------------------------------------------------------------- */

/* The memory layout of a layer's samples. */
typedef struct sample_shape {
    size_t rows, row_stride, sheets;
} sample_shape;

static sample_shape find_shape(const cvol_sheet_plan *plan, int lines)
{
    size_t most = 0;
    for (int begin = 0; begin < plan->height; begin += lines)
        for (size_t layer = 0; layer < plan->layers; layer++) {
            size_t first, last;
            int end = begin + lines < plan->height ? begin + lines : plan->height;
            if (cvol_layer_rows(&first, &last, plan, layer, begin, end) && last - first + 1 > most)
                most = last - first + 1;
        }
    /* With image-order rays, some of a band's lines reach no further than all of them, except for
     * rounding. */
    most += plan->image_order && most < plan->blocks_row;
    const size_t lanes = plan->blocks_lane * (size_t)plan->points_lane;
    const size_t line = CVOL_ALIGNMENT / cvol_sample_size(plan); /* rows begin at cache lines */
    const size_t row_stride = (lanes + 2 * CVOL_SHEET_PAD + line - 1) / line * line;
    return (sample_shape){most * (size_t)plan->points_row + 2 + 2 * (size_t)plan->reach, row_stride,
                          (size_t)plan->points_sheet + (plan->lapped ? 2 : 0)};
}

size_t cvol_band_sample_bytes(const cvol_sheet_plan *plan, int lines)
{
    const sample_shape shape = find_shape(plan, lines);
    const int covered = plan->masked == CVOL_SHEET_SOME_VOID;
    return (shape.rows * shape.row_stride * shape.sheets << covered) * cvol_sample_size(plan);
}

int cvol_band_memory_prepare(cvol_band_memory *memory, const cvol_sheet_plan *plan, int lines)
{
    const sample_shape shape = find_shape(plan, lines);
    const size_t row_stride = shape.row_stride;
    memory->row_stride = (ptrdiff_t)row_stride;
    memory->sheet_stride = (ptrdiff_t)(shape.rows * row_stride);
    const size_t samples = shape.rows * row_stride * shape.sheets;
    const int covered = plan->masked == CVOL_SHEET_SOME_VOID;
    memory->cover_at = covered ? (ptrdiff_t)samples : 0;
    /* Additional rows at either end; lit groups of pixels also reach before the first row. */
    const size_t before = (size_t)plan->reach * row_stride +
                          (plan->lit && plan->image_order ? 2 * CVOL_SHEET_PAD : 0);
    /* 32 pixels at once reach beyond the last row's end. */
    const size_t after = plan->int16.scale > 0 ? 2 * CVOL_SHEET_PAD : 0;
    if (memory->are_int16 !=
        (plan->int16.scale > 0)) /* its int16 samples may not be valid floats */
        memory->sample_capacity = 0;
    memory->are_int16 = plan->int16.scale > 0;
    if (!cvol_ensure(&memory->allocated, &memory->sample_capacity,
                     before + (samples << covered) + after, cvol_sample_size(plan)) ||
        !cvol_layer_skip_prepare(&memory->skip[0], plan) ||
        !cvol_layer_skip_prepare(&memory->skip[1], plan) ||
        !cvol_ensure(&memory->seen, &memory->seen_capacity, plan->blocks_row, 1) ||
        !cvol_ensure(&memory->pending, &memory->pending_capacity,
                     (size_t)(lines + CVOL_TILE - 1) / CVOL_TILE, 1) ||
        !cvol_ensure(&memory->work, &memory->work_capacity, 1, sizeof *memory->work))
        return 0;
    memory->samples = cvol_sample_at(plan, memory->allocated, (ptrdiff_t)before);
    return !plan->lapped || cvol_lapped_prepare(&memory->lapped, plan);
}

void cvol_band_memory_free(cvol_band_memory *memory)
{
    free(memory->allocated);
    cvol_layer_skip_free(&memory->skip[0]);
    cvol_layer_skip_free(&memory->skip[1]);
    free(memory->seen);
    free(memory->pending);
    free(memory->work);
    cvol_lapped_free(&memory->lapped);
}

/* ---- evaluating a layer ---------------------------------------------------------------------- */

/* Repeats the outermost samples, twice along lanes and once along rows, since rays are followed a
 * little beyond the faces. Light and wide footprints read further rows and lanes. Padding samples
 * are don't-care. */
static void extend_faces(void *at, const cvol_band_memory *memory, const cvol_sheet_plan *plan,
                         size_t lane, size_t row)
{
    const int points_lane = plan->points_lane, points_row = plan->points_row;
    const int left = lane == 0, right = lane + 1 == plan->blocks_lane,
              last_row = row + 1 == plan->blocks_row;
    const cvol_points_inside inside = cvol_points_inside_of(plan);
    const int rows = last_row ? inside.rows : points_row;
    const ptrdiff_t row_stride = memory->row_stride;
    const cvol_lane_copies copies = cvol_lane_copies_of(plan);
    const size_t size = cvol_sample_size(plan),
                 bytes = size * (size_t)(points_lane + copies.left * left + copies.right * right);
    for (int z = 0; z < plan->points_sheet; z++) {
        void *sheet = cvol_sample_at(plan, at, z * memory->sheet_stride);
        for (int r = 0; r < rows; r++) {
            void *line = cvol_sample_at(plan, sheet, r * row_stride);
            if (left)
                cvol_sample_repeat(plan, line, -1, copies.left);
            if (right)
                cvol_sample_repeat(plan, cvol_sample_at(plan, line, inside.lanes - 1), 1,
                                   points_lane - inside.lanes + copies.right);
        }
        void *above = cvol_sample_at(plan, sheet, -copies.left * left),
             *below = cvol_sample_at(plan, above, (rows - 1) * row_stride);
        for (int r = 1; r <= 1 + plan->reach && row == 0; r++)
            memcpy(cvol_sample_at(plan, above, -r * row_stride), above, bytes);
        for (int r = 1; r <= points_row - rows + 1 + plan->reach && last_row; r++)
            memcpy(cvol_sample_at(plan, below, r * row_stride), below, bytes);
    }
}

static void copy_level(void *samples, const cvol_band_memory *memory, const cvol_sheet_frame *frame,
                       size_t index)
{
    const cvol_sheet_level *level = frame->level;
    if (frame->plan->int16.scale > 0) {
        cvol_sheet_level_copy_int16(samples, memory->row_stride, memory->sheet_stride,
                                    level->samples, index, frame->plan);
        return;
    }
    float *out = samples;
    cvol_sheet_level_copy(out, memory->row_stride, memory->sheet_stride, level->samples, index,
                          frame->plan);
    if (memory->cover_at)
        cvol_sheet_level_copy(out + memory->cover_at, memory->row_stride, memory->sheet_stride,
                              level->cover, index, frame->plan);
}

static cvol_sheet_piece whole_piece(void *at, const cvol_band_memory *memory,
                                    const cvol_sheet_plan *plan)
{
    return (cvol_sheet_piece){at, memory->row_stride, memory->sheet_stride, 0, plan->points_row,
                              0,  plan->points_sheet};
}

/* Makes a block's samples. */
static void make_samples(cvol_band_memory *memory, const cvol_sheet_frame *frame, void *out,
                         const cvol_cached_block *block)
{
    const ptrdiff_t row_stride = memory->row_stride, sheet_stride = memory->sheet_stride;
    const size_t index = block->index;
    if (cvol_block_cache_take(&frame->cache, block, out, row_stride, sheet_stride))
        return;
    if (frame->level)
        copy_level(out, memory, frame, index);
    else if (!cvol_band_is_background(frame, index))
        cvol_band_evaluate(memory, frame, out, sheet_stride, index, &frame->axes);
    if (frame->mask && !frame->level && !memory->cover_at) {
        const cvol_sheet_piece piece = whole_piece(out, memory, frame->plan);
        cvol_sheet_mask_fill(&piece, frame->plan, frame->mask_points, frame->mask, index,
                             frame->background);
    }
    cvol_block_cache_put(&frame->cache, block, out, row_stride, sheet_stride);
}

static void evaluate_block(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                           const cvol_band_layer *at, size_t lane, size_t row,
                           cvol_block_visibility seen)
{
    const cvol_sheet_plan *plan = frame->plan;
    const cvol_array *array = frame->array;
    const size_t index = cvol_sheet_block_index(plan, array, lane, row, at->layer);
    void *out = cvol_sample_at(plan, memory->samples,
                               CVOL_SHEET_PAD + (ptrdiff_t)lane * plan->points_lane +
                                   (1 + (ptrdiff_t)(row - at->first_row) * plan->points_row) *
                                       memory->row_stride);
    void *cover = cvol_sample_at(plan, out, memory->cover_at);
    const cvol_cached_block block = cvol_cached_block_of(&frame->cache, index, lane, row, at->layer,
                                                         seen == CVOL_BLOCK_SHARED);
    make_samples(memory, frame, out, &block);
    if (memory->cover_at && frame->mask && !frame->level) {
        const cvol_sheet_piece piece = whole_piece(cover, memory, plan);
        cvol_sheet_mask_cover(&piece, plan, frame->mask_points, frame->mask, index);
    }
    if (lane > 0 && row > 0 && lane + 1 < plan->blocks_lane && row + 1 < plan->blocks_row)
        return;
    extend_faces(out, memory, plan, lane, row);
    if (memory->cover_at)
        extend_faces(cover, memory, plan, lane, row);
}

/* Evaluates the blocks of a row that are visible: not transparent, and not hidden by opaque
 * samples. memory->seen is 1 if there are any. */
static void evaluate_row(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                         const cvol_layer_skip *skip, const cvol_band_layer *at, size_t row)
{
    const cvol_sheet_plan *plan = frame->plan;
    memory->seen[row] = 0;
    for (size_t lane = 0; lane < plan->blocks_lane; lane++) {
        cvol_band_prefetch(frame, skip, at, lane + 2, row);
        if (skip->touched[row * plan->blocks_lane + lane] != CVOL_TOUCHED_DRAWN)
            continue;
        const cvol_block_visibility seen = cvol_block_test_visibility(
            frame->tiles, plan, lane, row, at->z_begin, at->z_end, at->tile_begin, at->tile_end);
        if (seen == CVOL_BLOCK_HIDDEN)
            continue;
        evaluate_block(memory, frame, at, lane, row, seen);
        memory->seen[row] = 1;
    }
}

/* ---- drawing it ------------------------------------------------------------------------------ */

static void clear_lines(const cvol_sheet_frame *frame, int begin, int end)
{
    const int down = frame->intermediate->down, width = frame->intermediate->width * down;
    for (int j = begin; j < end; j += down) {
        cvol_line line = cvol_band_line(frame->intermediate, j);
        for (int i = 0; i < width && line.depth; i++)
            line.depth[i] = INFINITY;
        for (int k = 0; k < CVOL_LINES - (frame->plan->masked != CVOL_SHEET_SOME_VOID); k++)
            for (int i = 0; i < width; i++)
                line.values[k * width + i] = frame->start[k];
        memset(line.opaque, 0, (size_t)(width / CVOL_GROUP));
        for (int g = 0; g < width / CVOL_GROUP; g++)
            line.intersected[g] = INT32_MIN;
    }
}

/* Evaluates and draws a layer, some lines at a time. A row of blocks is evaluated just before the
 * first lines that meet it, so that its samples are still in the cache. If nothing is visible, the
 * first slice ends the intervals of the layer before. */
static void draw_layer(cvol_work_stealing *share, int thread, cvol_band *band,
                       const cvol_layer_skip *skip, const cvol_layer_skip *before,
                       cvol_band_layer *at)
{
    const cvol_sheet_frame *frame = share->frame;
    cvol_band_memory *memory = &share->bands[thread];
    const cvol_sheet_plan *plan = frame->plan;
    size_t next_row = at->first_row;
    cvol_layer *layer = &memory->layer, *first_sheet = &memory->first_sheet;
    cvol_layer_describe(layer, memory->samples, memory->row_stride, memory->sheet_stride, skip,
                        before, plan, at);
    layer->cover_at = memory->cover_at;
    layer->bounded = frame->extremes.sign != 0;
    *first_sheet = *layer;
    first_sheet->sheet_count = 1;
    for (int from = band->begin; from < band->end; from += CVOL_TILE) {
        size_t first, last;
        cvol_work_stealing_tile(share, thread, band, from);
        if (from >= band->end)
            break;
        at->tile_end = cvol_band_tile_end(band);
        const int to = from + CVOL_TILE < band->end ? from + CVOL_TILE : band->end;
        uint8_t *pending = &memory->pending[(from - band->begin) / CVOL_TILE];
        const int ends = *pending;
        *pending = 0;
        if (!cvol_layer_rows(&first, &last, plan, at->layer, from, to))
            continue;
        for (; next_row <= last; next_row++)
            evaluate_row(memory, frame, skip, at, next_row);
        *pending = memchr(memory->seen + first, 1, last - first + 1) != NULL;
        for (int j = from; j < to && (*pending || ends); j += cvol_lines_interleaved(plan)) {
            const cvol_line line = cvol_band_line_of(memory, frame, j);
            frame->kernel(*pending ? layer : first_sheet, frame->table, &line);
        }
        if (*pending || ends)
            cvol_extremes_update(&frame->extremes, frame->tiles, frame->intermediate, from, to);
    }
}

/* Behind the last slice. */
static void end_lines(cvol_layer *layer, const cvol_sheet_frame *frame, int begin, int end)
{
    cvol_layer_describe_end(layer, frame->plan);
    layer->cover_at = frame->plan->masked == CVOL_SHEET_SOME_VOID;
    layer->parts = frame->plan->parts;
    for (int j = begin; j < end; j += cvol_lines_interleaved(frame->plan)) {
        const cvol_line line = cvol_band_line(frame->intermediate, j);
        frame->kernel(layer, frame->table, &line);
    }
}

/* Finds a layer's slices and its rows of blocks within the band; 0 if there are none. */
static int find_layer(cvol_band_layer *at, const cvol_sheet_plan *plan, const cvol_band *band,
                      size_t step)
{
    at->tile_begin = band->begin / CVOL_TILE;
    at->tile_end = cvol_band_tile_end(band);
    at->layer = plan->ascending ? step : plan->layers - 1 - step;
    cvol_layer_sheets(&at->z_begin, &at->z_end, plan, at->layer);
    return cvol_layer_rows(&at->first_row, &at->last_row, plan, at->layer, band->begin, band->end);
}

/* Makes the windows of a layer; NULL if the band does not reach it. */
static const cvol_layer_skip *find_windows(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                                           cvol_band_layer *at, const cvol_band *band, size_t step)
{
    const cvol_extremes_seen extremes = cvol_band_extremes(frame, band);
    const cvol_skip_source source = cvol_band_skip_source(frame, &extremes);
    cvol_layer_skip *skip = &memory->skip[step % 2];
    if (!find_layer(at, frame->plan, band, step))
        return NULL;
    cvol_layer_skip_make(skip, &source, at->layer, at->first_row, at->last_row);
    return skip;
}

void cvol_band_draw(cvol_work_stealing *share, int thread, cvol_band *band)
{
    const cvol_sheet_frame *frame = share->frame;
    const cvol_sheet_plan *plan = frame->plan;
    cvol_band_memory *memory = &share->bands[thread];
    cvol_band_layer at;
    const cvol_layer_skip *before = NULL;
    if (band->step == 0) {
        clear_lines(frame, band->begin, band->end);
        memset(memory->pending, 0, (size_t)(cvol_band_tile_end(band) - band->begin / CVOL_TILE));
        cvol_tiles_update(frame->tiles, frame->intermediate, band->begin, band->end);
        cvol_extremes_clear(&frame->extremes, frame->tiles, band->begin, band->end);
    } else if (plan->lapped)
        cvol_lapped_evaluate_rest(memory, frame, band);
    else
        before = find_windows(memory, frame, &at, band, band->step - 1);
    for (; band->step < plan->layers; band->step++) {
        if (!cvol_work_stealing_layer(share, thread, band))
            return;
        if (plan->lapped)
            cvol_lapped_draw(share, thread, band);
        else {
            const cvol_layer_skip *skip = find_windows(memory, frame, &at, band, band->step);
            if (skip)
                draw_layer(share, thread, band, skip, before, &at);
            before = skip;
        }
        cvol_tiles_update(frame->tiles, frame->intermediate, band->begin, band->end);
        atomic_fetch_add_explicit(&share->drawn, band->end - band->begin, memory_order_relaxed);
    }
    if (plan->lit)
        end_lines(&share->bands[thread].layer, frame, band->begin, band->end);
}
