/* One band of the intermediate image: layer after layer, evaluate what can be seen, then draw. */
#include "render/sheet_band.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"

/* ---- memory ------------------------------------------------------------------------------- */

/* New memory is zero, so that samples which are loaded but weigh nothing are at least numbers. */
int cvol_ensure(void *memory_pointer, size_t *capacity, size_t count, size_t size)
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

void cvol_layer_sheets(size_t *begin, size_t *end, const cvol_sheet_plan *plan, size_t layer)
{
    const size_t points = (size_t)plan->points_sheet;
    *begin = layer * points;
    *end = *begin + points < plan->sheet_count ? *begin + points : plan->sheet_count;
}

/* The row that line V crosses; beside the eye and behind it, the eye's own. */
static double find_row(const cvol_sheet_plan *plan, const cvol_sheet_crossing *at, double V)
{
    return at->scale > 0 ? at->row + at->scale * V : plan->eye_row;
}

int cvol_layer_rows(size_t *first, size_t *last, const cvol_sheet_plan *plan, size_t layer,
                    int line_begin, int line_end)
{
    size_t z_begin, z_end;
    cvol_layer_sheets(&z_begin, &z_end, plan, layer);
    const double around = plan->lapped ? 2 : 0; /* rows and sheets that faces mix */
    const double behind = around + plan->beyond * plan->pitch_sheet;
    const cvol_sheet_crossing from = cvol_sheet_cross(plan,
                                                      cvol_sheet_place(plan, z_begin) - behind),
                              to = cvol_sheet_cross(plan,
                                                    cvol_sheet_place(plan, z_end - 1) + behind);
    if (from.scale <= 0 && to.scale <= 0) /* behind the eye */
        return 0;
    const double top = plan->v0 + line_begin * plan->dv,
                 reach = (1 + around + plan->lit) * plan->pitch_row,
                 bottom = plan->v0 + (line_end - 1) * plan->dv;
    double lo = fmin(find_row(plan, &from, top), find_row(plan, &to, top)) - reach;
    double hi = fmax(find_row(plan, &from, bottom), find_row(plan, &to, bottom)) + reach;
    const double rows = (double)(plan->rows - 1);
    const double beyond = fmax(2, 2 * plan->pitch_sheet) + plan->lit * fmax(1, plan->pitch_row);
    if (hi < -beyond || lo > rows + beyond) /* rays may enter or leave half way to the next sheet */
        return 0;
    *first = (size_t)fmin(fmax(lo, 0), rows) / (size_t)plan->block_row;
    *last = (size_t)fmin(fmax(hi, 0), rows) / (size_t)plan->block_row;
    return 1;
}

int cvol_band_memory_prepare(cvol_band_memory *memory, const cvol_sheet_plan *plan, int lines)
{
    size_t most = 0;
    for (int begin = 0; begin < plan->height; begin += lines)
        for (size_t layer = 0; layer < plan->layers; layer++) {
            size_t first, last;
            int end = begin + lines < plan->height ? begin + lines : plan->height;
            if (cvol_layer_rows(&first, &last, plan, layer, begin, end) && last - first + 1 > most)
                most = last - first + 1;
        }
    const size_t lanes = plan->blocks_lane * (size_t)plan->points_lane;
    const size_t row_stride = (lanes + 2 * CVOL_SHEET_PAD + 15) / 16 * 16;
    const size_t rows = most * (size_t)plan->points_row + 2 + 2 * (size_t)plan->lit;
    const size_t sheets = (size_t)plan->points_sheet + (plan->lapped ? 2 : 0);
    memory->row_stride = (long)row_stride;
    memory->sheet_stride = (long)(rows * row_stride);
    const size_t samples = rows * row_stride * sheets;
    const int covered = plan->masked == CVOL_SHEET_SOME_VOID;
    memory->cover_at = covered ? (long)samples : 0;
    const size_t before = plan->lit ? row_stride : 0; /* a row more at either end */
    if (!cvol_ensure(&memory->allocated, &memory->sample_capacity, before + (samples << covered),
                     sizeof(float)) ||
        !cvol_layer_skip_prepare(&memory->skip[0], plan) ||
        !cvol_layer_skip_prepare(&memory->skip[1], plan) ||
        !cvol_ensure(&memory->seen, &memory->seen_capacity, plan->blocks_row, 1) ||
        !cvol_ensure(&memory->pending, &memory->pending_capacity,
                     (size_t)(lines + CVOL_TILE - 1) / CVOL_TILE, 1) ||
        !cvol_ensure(&memory->work, &memory->work_capacity, 1, sizeof *memory->work))
        return 0;
    memory->samples = memory->allocated + before;
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

/* Repeats the outermost samples, twice to the left and once elsewhere, since rays are followed a
 * little beyond the faces; light looks at rows further. */
static void extend_faces(float *at, const cvol_band_memory *memory, const cvol_sheet_plan *plan,
                         size_t lane, size_t row)
{
    const int points_lane = plan->points_lane, points_row = plan->points_row;
    const int left = lane == 0, right = lane + 1 == plan->blocks_lane;
    const long row_stride = memory->row_stride;
    const size_t bytes = sizeof(float) * (size_t)(points_lane + 2 * left + right);
    for (int z = 0; z < plan->points_sheet; z++) {
        float *sheet = at + z * memory->sheet_stride;
        for (int r = 0; r < points_row && left; r++)
            sheet[r * row_stride - 2] = sheet[r * row_stride - 1] = sheet[r * row_stride];
        for (int r = 0; r < points_row && right; r++)
            sheet[r * row_stride + points_lane] = sheet[r * row_stride + points_lane - 1];
        float *above = sheet - 2 * left, *below = above + (points_row - 1) * row_stride;
        for (int r = 1; r <= 1 + plan->lit && row == 0; r++)
            memcpy(above - r * row_stride, above, bytes);
        for (int r = 1; r <= 1 + plan->lit && row + 1 == plan->blocks_row; r++)
            memcpy(below + r * row_stride, below, bytes);
    }
}

cvol_skip_source cvol_band_skip_source(const cvol_sheet_frame *frame)
{
    const int has_void = frame->plan->masked == CVOL_SHEET_SOME_VOID;
    return (cvol_skip_source){frame->plan, frame->array, frame->visibility,
                              has_void ? frame->mask->states : NULL};
}

static void copy_level(float *out, const cvol_band_memory *memory, const cvol_sheet_frame *frame,
                       size_t index)
{
    const cvol_sheet_level *level = frame->level;
    cvol_sheet_level_copy(out, memory->row_stride, memory->sheet_stride, level->samples, index,
                          frame->plan);
    if (memory->cover_at)
        cvol_sheet_level_copy(out + memory->cover_at, memory->row_stride, memory->sheet_stride,
                              level->cover, index, frame->plan);
}

static void evaluate_block(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                           const cvol_band_layer *at, size_t lane, size_t row)
{
    const cvol_sheet_plan *plan = frame->plan;
    const cvol_array *array = frame->array;
    const size_t index = cvol_sheet_block_index(plan, array, lane, row, at->layer);
    float *out = memory->samples + CVOL_SHEET_PAD + (long)lane * plan->points_lane +
                 (1 + (long)(row - at->first_row) * plan->points_row) * memory->row_stride;
    if (frame->level) {
        copy_level(out, memory, frame, index);
    } else {
        frame->evaluate(out, memory->row_stride, memory->sheet_stride, &array->block_table[index],
                        &frame->axes, array->block_log2, (float)array->step, memory->work);
    }
    if (frame->mask && !frame->level) {
        cvol_sheet_piece piece = {out + memory->cover_at, memory->row_stride,
                                  memory->sheet_stride,   0,
                                  plan->points_row,       0,
                                  plan->points_sheet};
        if (memory->cover_at)
            cvol_sheet_mask_cover(&piece, plan, frame->mask, index);
        else
            cvol_sheet_mask_lay(&piece, plan, frame->mask, index, frame->background);
    }
    if (lane > 0 && row > 0 && lane + 1 < plan->blocks_lane && row + 1 < plan->blocks_row)
        return;
    extend_faces(out, memory, plan, lane, row);
    if (memory->cover_at)
        extend_faces(out + memory->cover_at, memory, plan, lane, row);
}

/* Evaluates those blocks of a row that can be seen through the transfer function and past what is
 * opaque; memory->seen says whether there are any. */
static void evaluate_row(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                         const cvol_layer_skip *skip, const cvol_band_layer *at, size_t row)
{
    const cvol_sheet_plan *plan = frame->plan;
    memory->seen[row] = 0;
    for (size_t lane = 0; lane < plan->blocks_lane; lane++)
        if (skip->touched[row * plan->blocks_lane + lane] == CVOL_TOUCHED_DRAWN &&
            cvol_block_is_seen(frame->tiles, plan, lane, row, at->z_begin, at->z_end,
                               at->tile_begin, at->tile_end)) {
            evaluate_block(memory, frame, at, lane, row);
            memory->seen[row] = 1;
        }
}

/* ---- drawing it --------------------------------------------------------------------------------
 */

static int clamp_group(double group, int groups)
{
    return group < 0 ? 0 : group > groups ? groups : (int)group;
}

/* The pixels [0] .. [1] whose rays are within lanes lo .. hi on a plane of samples; those of a
 * plane behind the eye are none. */
static void find_pixels(double pixels[2], const cvol_layer *layer, const cvol_sheet_plan *plan,
                        double z)
{
    const cvol_sheet_crossing at = cvol_sheet_cross(plan, z);
    pixels[0] = INFINITY;
    pixels[1] = -INFINITY;
    if (!(at.scale > 0))
        return;
    const double start = (at.lane + at.scale * plan->u0 - plan->first_lane) / plan->pitch_lane,
                 step = at.scale * plan->du / plan->pitch_lane;
    pixels[0] = (layer->lane_lo - start) / step;
    pixels[1] = (layer->lane_hi - start) / step;
}

/* The groups that the sheet at z concerns, see cvol_sheet_view; `next` leads to the next one. */
static void find_groups(cvol_sheet_view *sheet, const cvol_layer *layer,
                        const cvol_sheet_plan *plan, double z, double next)
{
    const int groups = plan->width / CVOL_GROUP;
    sheet->begin = sheet->end = sheet->inside_begin = sheet->inside_end = 0;
    if (!(cvol_sheet_cross(plan, z).scale > 0))
        return;
    double most[2] = {INFINITY, -INFINITY}, least[2] = {-INFINITY, INFINITY};
    for (int k = -2; k <= 1; k++) {
        double pixels[2];
        find_pixels(pixels, layer, plan, z + k * next);
        if (k > -2 && pixels[0] <= pixels[1]) {
            most[0] = fmin(most[0], pixels[0]);
            most[1] = fmax(most[1], pixels[1]);
        }
        least[0] = fmax(least[0], pixels[0]);
        least[1] = fmin(least[1], pixels[1]);
    }
    sheet->begin = clamp_group(floor(ceil(most[0]) / CVOL_GROUP), groups);
    sheet->end = clamp_group(floor(floor(most[1]) / CVOL_GROUP) + 1, groups);
    sheet->inside_begin = clamp_group(ceil(least[0] / CVOL_GROUP), groups);
    sheet->inside_end = clamp_group(floor((floor(least[1]) + 1) / CVOL_GROUP), groups);
}

/* The faces of one axis, see cvol_layer; rays move by `shear` from sheet to sheet. */
static void find_faces(double *enter, double *leave, float *turn, double lo, double hi,
                       double pitch, double shear)
{
    const double least_shear = 1e-5;
    *enter = shear < 0 ? hi : lo;
    *leave = shear < 0 ? lo : hi;
    *turn = (float)((shear < 0 ? -1 : 1) / fmax(fabs(shear) / pitch, least_shear));
}

/* Where the sheet's samples are met, and the planes that cut it. */
static void describe_sheet(cvol_sheet_view *sheet, const cvol_sheet_plan *plan, double z,
                           double next)
{
    const cvol_sheet_crossing at = cvol_sheet_cross(plan, z),
                              then = cvol_sheet_cross(plan, z + next);
    sheet->lane_at = (at.lane + at.scale * plan->u0 - plan->first_lane) / plan->pitch_lane;
    sheet->row_at = (at.row + at.scale * plan->v0 - plan->first_row) / plan->pitch_row;
    sheet->lane_step = at.scale * plan->du / plan->pitch_lane;
    sheet->row_step = at.scale * plan->dv / plan->pitch_row;
    const double turn = plan->perspective ? 1 : 0, way = plan->ascending ? 1 : -1;
    const double lane = turn > 0 ? plan->u0 - plan->eye_lane : way * plan->shear_lane,
                 row = turn > 0 ? plan->v0 - plan->eye_row : way * plan->shear_row;
    sheet->lane_rate[0] = lane * plan->pitch_sheet / plan->pitch_lane;
    sheet->row_rate[0] = row * plan->pitch_sheet / plan->pitch_row;
    sheet->lane_rate[1] = turn * plan->du * plan->pitch_sheet / plan->pitch_lane;
    sheet->row_rate[1] = turn * plan->dv * plan->pitch_sheet / plan->pitch_row;
    for (int i = 0; i < plan->planes; i++) {
        const double *n = plan->plane[i];
        double value[2][3];
        for (int k = 0; k < 2; k++) {
            const cvol_sheet_crossing *c = k ? &then : &at;
            value[k][0] = n[0] * (c->lane + c->scale * plan->u0) +
                          n[1] * (c->row + c->scale * plan->v0) + n[2] * (k ? z + next : z) + n[3];
            value[k][1] = n[0] * c->scale * plan->du;
            value[k][2] = n[1] * c->scale * plan->dv;
        }
        for (int k = 0; k < 3; k++) {
            sheet->cuts[i].value[k] = value[0][k];
            sheet->cuts[i].rate[k] = value[1][k] - value[0][k];
        }
    }
}

/* Faces, and the lengths of intervals. */
static void describe_rays(cvol_layer *out, const cvol_sheet_plan *plan)
{
    const double tolerance = 1e-4, way = plan->ascending ? 1 : -1;
    out->perspective = plan->perspective;
    out->unit = !plan->perspective && plan->du / plan->pitch_lane == 1;
    out->only = plan->sheets == 1;
    out->cuts = plan->planes;
    out->lane_lo = (plan->lo[0] - plan->first_lane) / plan->pitch_lane - tolerance;
    out->lane_hi = (plan->hi[0] - plan->first_lane) / plan->pitch_lane + tolerance;
    out->row_lo = (plan->lo[1] - plan->first_row) / plan->pitch_row - tolerance;
    out->row_hi = (plan->hi[1] - plan->first_row) / plan->pitch_row + tolerance;
    find_faces(&out->lane_enter, &out->lane_leave, &out->lane_turn, out->lane_lo, out->lane_hi,
               plan->pitch_lane, way * plan->shear_lane * plan->pitch_sheet);
    find_faces(&out->row_enter, &out->row_leave, &out->row_turn, out->row_lo, out->row_hi,
               plan->pitch_row, way * plan->shear_row * plan->pitch_sheet);
    const double whole = plan->distance / plan->pitch_sheet;
    out->length = plan->spacing[2] * plan->spacing[2] / (whole * whole);
    out->length_lane[0] = (plan->u0 - plan->eye_lane) * plan->spacing[0] / whole;
    out->length_lane[1] = plan->du * plan->spacing[0] / whole;
    out->length_row[0] = (plan->v0 - plan->eye_row) * plan->spacing[1] / whole;
    out->length_row[1] = plan->dv * plan->spacing[1] / whole;
}

static cvol_windows windows_of(const cvol_layer_skip *skip, const cvol_sheet_plan *plan)
{
    return (cvol_windows){.within = skip->within,
                          .across = skip->across,
                          .within_level = skip->levels,
                          .across_level = skip->levels + plan->blocks_row * (size_t)skip->windows,
                          .count = skip->windows,
                          .spread_at = (int)(2 * plan->blocks_row * (size_t)skip->windows)};
}

void cvol_layer_describe(cvol_layer *out, const float *samples, long row_stride, long sheet_stride,
                         const cvol_layer_skip *skip, const cvol_layer_skip *before,
                         const cvol_sheet_plan *plan, const cvol_band_layer *at)
{
    const int count = (int)(at->z_end - at->z_begin);
    const int is_last = plan->ascending ? at->layer + 1 == plan->layers : at->layer == 0;
    out->sheet_count = count + (is_last && plan->beyond);
    out->row_stride = row_stride;
    out->cover_at = 0;
    describe_rays(out, plan);
    out->row_points = plan->points_row;
    out->row_points_inverse = ((UINT64_C(1) << 32) - 1) / (uint64_t)plan->points_row + 1;
    out->block_rows = (int)plan->blocks_row;
    out->windows = windows_of(skip, plan);
    out->windows_before = before ? windows_of(before, plan) : (cvol_windows){0};
    /* Row 0 of the samples that the kernels speak of lies before the buffer when the band does not
     * reach it; they touch only rows that the band's lines meet. */
    const long row_0 = 1 - (long)at->first_row * plan->points_row;
    const double next = plan->ascending ? plan->pitch_sheet : -plan->pitch_sheet;
    for (int s = 0; s < out->sheet_count; s++) {
        const int of = s < count ? s : count - 1;
        const long slice = plan->ascending ? of : count - 1 - of;
        const size_t number = at->z_begin + (size_t)slice;
        const double z = cvol_sheet_place(plan, number) + (s - of) * next;
        cvol_sheet_view *sheet = &out->sheets[s];
        sheet->ordinal = (int)(plan->ascending ? number : plan->sheet_count - 1 - number) + s - of;
        const double below = (z - plan->lo[2]) / plan->pitch_sheet,
                     above = (plan->hi[2] - z) / plan->pitch_sheet;
        sheet->front = (float)-(plan->ascending ? below : above);
        sheet->back = (float)(plan->ascending ? above : below);
        sheet->is_first = s == 0;
        sheet->samples = samples;
        sheet->first = CVOL_SHEET_PAD + row_0 * row_stride + slice * sheet_stride;
        describe_sheet(sheet, plan, z, next);
        find_groups(sheet, out, plan, z, next);
    }
}

cvol_line cvol_band_line(const cvol_intermediate *image, int j)
{
    const size_t width = (size_t)image->width, groups = width / CVOL_GROUP, at = (size_t)j;
    return (cvol_line){.values = image->lines + at * CVOL_LINES * width,
                       .opaque = image->opaque + at * groups,
                       .met = image->met + at * groups,
                       .pending = image->pending
                                      ? image->pending + at * (size_t)image->pending_lines * width
                                      : NULL,
                       .edges = image->edges ? image->edges + at * groups : NULL,
                       .number = j,
                       .width = image->width};
}

static void clear_lines(const cvol_sheet_frame *frame, int begin, int end)
{
    const int width = frame->intermediate->width;
    for (int j = begin; j < end; j++) {
        cvol_line line = cvol_band_line(frame->intermediate, j);
        for (int k = 0; k < CVOL_LINES - (frame->plan->masked != CVOL_SHEET_SOME_VOID); k++)
            for (int i = 0; i < width; i++)
                line.values[k * width + i] = frame->start[k];
        memset(line.opaque, 0, (size_t)(width / CVOL_GROUP));
        for (int g = 0; g < width / CVOL_GROUP; g++)
            line.met[g] = INT32_MIN;
        for (int i = 0; i < width && frame->plan->lit; i++)
            line.pending[i] = INFINITY;
    }
}

/* Evaluates and draws a layer, some lines at a time: a row of blocks is evaluated just before the
 * first lines that meet it, so that they find its samples in the cache. Where nothing can be seen,
 * the first sheet ends what the layer before began. */
static void draw_layer(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                       const cvol_layer_skip *skip, const cvol_layer_skip *before,
                       const cvol_band_layer *at, int begin, int end)
{
    const cvol_sheet_plan *plan = frame->plan;
    size_t next_row = at->first_row;
    cvol_layer layer, first_sheet;
    cvol_layer_describe(&layer, memory->samples, memory->row_stride, memory->sheet_stride, skip,
                        before, plan, at);
    layer.cover_at = memory->cover_at;
    first_sheet = layer;
    first_sheet.sheet_count = 1;
    for (int from = begin; from < end; from += CVOL_TILE) {
        const int to = from + CVOL_TILE < end ? from + CVOL_TILE : end;
        size_t first, last;
        uint8_t *pending = &memory->pending[(from - begin) / CVOL_TILE];
        const int ends = *pending;
        *pending = 0;
        if (!cvol_layer_rows(&first, &last, plan, at->layer, from, to))
            continue;
        for (; next_row <= last; next_row++)
            evaluate_row(memory, frame, skip, at, next_row);
        *pending = memchr(memory->seen + first, 1, last - first + 1) != NULL;
        for (int j = from; j < to && (*pending || ends); j++) {
            cvol_line line = cvol_band_line(frame->intermediate, j);
            frame->kernel(*pending ? &layer : &first_sheet, frame->table, &line);
        }
    }
}

/* Behind the last sheet. */
static void end_lines(const cvol_sheet_frame *frame, int begin, int end)
{
    cvol_layer layer;
    memset(&layer, 0, sizeof layer);
    layer.sheets[0].ordinal = (int)frame->plan->sheet_count + frame->plan->beyond;
    layer.cover_at = frame->plan->masked == CVOL_SHEET_SOME_VOID;
    for (int j = begin; j < end; j++) {
        const cvol_line line = cvol_band_line(frame->intermediate, j);
        frame->kernel(&layer, frame->table, &line);
    }
}

int cvol_band_draw(cvol_context *context, cvol_band_memory *memory, const cvol_sheet_frame *frame,
                   int begin, int end, double progress, double share)
{
    const cvol_sheet_plan *plan = frame->plan;
    cvol_band_layer at = {.tile_begin = begin / CVOL_TILE,
                          .tile_end = (end + CVOL_TILE - 1) / CVOL_TILE};
    const cvol_layer_skip *before = NULL;
    const cvol_skip_source source = cvol_band_skip_source(frame);
    clear_lines(frame, begin, end);
    memset(memory->pending, 0, (size_t)(end - begin + CVOL_TILE - 1) / CVOL_TILE);
    cvol_tiles_update(frame->tiles, frame->intermediate, begin, end);
    for (size_t step = 0; step < plan->layers; step++) {
        double fraction = progress + share * (double)step / (double)plan->layers;
        if (context && cvol_report_progress(context, "rendering", fraction))
            return CVOL_ERROR_CANCELLED;
        if (plan->lapped) {
            cvol_lapped_draw(memory, frame, step, begin, end);
            cvol_tiles_update(frame->tiles, frame->intermediate, begin, end);
            continue;
        }
        at.layer = plan->ascending ? step : plan->layers - 1 - step;
        cvol_layer_sheets(&at.z_begin, &at.z_end, plan, at.layer);
        const cvol_layer_skip *skip = &memory->skip[step % 2], *met = before;
        before = NULL;
        if (!cvol_layer_rows(&at.first_row, &at.last_row, plan, at.layer, begin, end))
            continue;
        cvol_layer_skip_make(skip, &source, at.layer, at.first_row, at.last_row);
        draw_layer(memory, frame, skip, met, &at, begin, end);
        before = skip;
        cvol_tiles_update(frame->tiles, frame->intermediate, begin, end);
    }
    if (plan->lit)
        end_lines(frame, begin, end);
    return CVOL_OK;
}
