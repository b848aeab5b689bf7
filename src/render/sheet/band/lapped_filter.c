/* The post-filter of transform/lap.h across the faces of blocks, on an evaluated layer.
 *
 * If blocks are evaluated on fewer points than samples, points lie `pitch` samples apart, at t_k =
 * (k + 1/2) pitch from a face. The filter's odd part is then a product of three maps. L
 * interpolates the differences of mirrored samples, at t = 1/2 and 3/2, linearly from differences
 * of points. H is the filter's matrix. R interpolates the filter's changes of samples (at 1/2 and
 * 3/2; 0 at 5/2) linearly to points. h = R H L; with pitch 1, h = H.
 *
 * A drawn block may have a neighbour that is not evaluated, because nothing in it or between the
 * two is visible. Its samples at that face then lack the filter and may have any value, also a
 * visible one. They are clamped to the block's range, which is transparent. All neighbours of a
 * block that is itself visible are evaluated. */
#include "render/sheet/band/lapped.h"

#include <math.h>
#include <string.h>

#include "render/sheet/band/band_samples.h"
#include "transform/lap.h"

static void find_filter(float h[4], double pitch)
{
    static const float H[4] = CVOL_LAP_POST_H;
    double L[2][2], R[2][2];
    for (int k = 0; k < 2; k++) {
        const double at = (k + 0.5) / pitch - 0.5, to = (k + 0.5) * pitch - 0.5;
        L[k][0] = 1 - at;
        L[k][1] = at;
        R[k][0] = fmax(1 - to, 0);
        R[k][1] = fmax(1 - fabs(to - 1), 0);
    }
    for (int k = 0; k < 2; k++)
        for (int j = 0; j < 2; j++) {
            double sum = 0;
            for (int p = 0; p < 2; p++)
                for (int q = 0; q < 2; q++)
                    sum += R[k][p] * (double)H[2 * p + q] * L[q][j];
            h[2 * k + j] = (float)sum;
        }
}

cvol_lapped_filters cvol_lapped_filters_of(const cvol_sheet_plan *plan)
{
    cvol_lapped_filters filters;
    find_filter(filters.lane, plan->pitch_lane);
    find_filter(filters.row, plan->pitch_row);
    find_filter(filters.sheet, plan->pitch_sheet);
    return filters;
}

/* The working data for filtering one row of blocks. */
typedef struct work {
    const cvol_band_memory *memory;
    const cvol_sheet_frame *frame;
    const cvol_sheet_plan *plan;
    const cvol_lapped_layer *layer, *before;
} work;

/* Some rows of samples of a row of blocks: the first, counted within these blocks, and their
 * number. */
typedef struct piece {
    size_t row;
    int begin, count;
} piece;

/* The first sample of a block's row `within`, in a slice of the layer. */
static void *find_samples(const work *w, const cvol_lapped_layer *layer, size_t lane, size_t row,
                          int within, int sheet)
{
    const ptrdiff_t line = 1 + (ptrdiff_t)(row - layer->at.first_row) * w->plan->points_row +
                           within;
    return cvol_sample_at(w->plan, layer->samples,
                          CVOL_SHEET_PAD + (ptrdiff_t)lane * w->plan->points_lane +
                              line * w->memory->row_stride + sheet * layer->sheet_stride);
}

static int is_int16(const work *w)
{
    return w->plan->int16.scale > 0;
}

/* Finds the first run of blocks from *begin on in which a[i] & b[i] & mask is constant and not 0;
 * returns that value, 0 if there is none. */
static int next_run(size_t *begin, size_t *end, const uint8_t *a, const uint8_t *b, int mask,
                    size_t count)
{
    while (*begin < count && !(a[*begin] & b[*begin] & mask))
        ++*begin;
    if (*begin == count)
        return 0;
    const int value = a[*begin] & b[*begin] & mask;
    for (*end = *begin + 1; *end < count && (a[*end] & b[*end] & mask) == value;)
        ++*end;
    return value;
}

static const uint8_t *row_of(const uint8_t *cells, const cvol_sheet_plan *plan, size_t row)
{
    return cells + row * plan->blocks_lane;
}

/* ---- faces between lanes and rows ------------------------------------------------------------ */

typedef struct sheet_span {
    int begin, count;
} sheet_span;

/* The slices of blocks that `have` marks as evaluated. */
static int find_spans(sheet_span spans[2], int have, int sheets, int sheets_of_cell)
{
    int count = 0;
    if (have == CVOL_HAVE_ALL)
        spans[count++] = (sheet_span){0, sheets};
    else {
        if (have & CVOL_HAVE_LOW)
            spans[count++] = (sheet_span){0, 2};
        if (have & CVOL_HAVE_HIGH)
            spans[count++] = (sheet_span){sheets_of_cell - 2, 2};
    }
    return count;
}

void cvol_lapped_filter_lane(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                             const cvol_lapped_layer *layer, size_t lane, size_t row)
{
    const work w = {memory, frame, frame->plan, layer, NULL};
    const uint8_t *have = row_of(layer->have, w.plan, row);
    const int both = lane > 0 ? have[lane - 1] & have[lane] : 0;
    if (!both || !cvol_lapped_face(lane, w.plan->lanes))
        return;
    sheet_span spans[2];
    const int count = find_spans(spans, both, layer->count, w.plan->points_sheet);
    for (int i = 0; i < count; i++) {
        void *a2 = find_samples(&w, layer, lane, row, 0, spans[i].begin);
        if (is_int16(&w))
            CVOL_SIMD_CHOOSE(cvol_sheet_lap_lanes_int16)
        (a2, memory->row_stride, layer->sheet_stride, w.plan->points_row, spans[i].count,
         frame->filters.lane);
        else CVOL_SIMD_CHOOSE(cvol_sheet_lap_lanes)(a2, memory->row_stride, layer->sheet_stride,
                                                    w.plan->points_row, spans[i].count,
                                                    frame->filters.lane);
    }
}

static void filter_across(const work *w, void *const a[4], ptrdiff_t stride, size_t cells,
                          int lines, const float h[4])
{
    const int columns = (int)cells * w->plan->points_lane;
    if (is_int16(w)) {
        int16_t *const words[4] = {a[0], a[1], a[2], a[3]};
        CVOL_SIMD_CHOOSE(cvol_sheet_lap_across_int16)(words, stride, columns, lines, h);
    } else {
        float *const floats[4] = {a[0], a[1], a[2], a[3]};
        CVOL_SIMD_CHOOSE(cvol_sheet_lap_across)(floats, stride, columns, lines, h);
    }
}

/* Filters the face between this row of blocks and the one before. */
static void filter_rows(const work *w, size_t row)
{
    const cvol_sheet_plan *plan = w->plan;
    size_t begin = 0, end;
    int both;
    if (!cvol_lapped_face(row, plan->rows))
        return;
    for (; (both = next_run(&begin, &end, row_of(w->layer->have, plan, row - 1),
                            row_of(w->layer->have, plan, row), CVOL_HAVE_ALL, plan->blocks_lane));
         begin = end) {
        sheet_span spans[2];
        const int count = find_spans(spans, both, w->layer->count, plan->points_sheet);
        for (int i = 0; i < count; i++) {
            void *a[4];
            for (int k = 0; k < 4; k++)
                a[k] = find_samples(w, w->layer, begin, row, k - 2, spans[i].begin);
            filter_across(w, a, w->layer->sheet_stride, end - begin, spans[i].count,
                          w->frame->filters.row);
        }
    }
}

/* ---- completing rows of samples -------------------------------------------------------------- */

static int lacks_neighbour(const work *w, const cvol_lapped_layer *layer, size_t lane, size_t row)
{
    const cvol_sheet_plan *plan = w->plan;
    for (size_t r = row ? row - 1 : 0; r <= row + 1 && r < plan->blocks_row; r++)
        for (size_t l = lane ? lane - 1 : 0; l <= lane + 1 && l < plan->blocks_lane; l++)
            if (!row_of(layer->skip.touched, plan, r)[l])
                return 1;
    return 0;
}

/* Clamps the samples of transparent blocks that lack a neighbour to their ranges. */
static void bound_cells(const work *w, const cvol_lapped_layer *layer, piece p, sheet_span sheets)
{
    const cvol_array *array = w->frame->array;
    for (size_t lane = 0; lane < w->plan->blocks_lane; lane++) {
        if (row_of(layer->have, w->plan, p.row)[lane] != CVOL_HAVE_ALL ||
            !row_of(layer->skip.touched, w->plan, p.row)[lane])
            continue;
        const size_t index = cvol_sheet_block_index(w->plan, array, lane, p.row, layer->at.layer);
        if (cvol_visibility_of(w->frame->visibility, &array->block_table[index]) ||
            !lacks_neighbour(w, layer, lane, p.row))
            continue;
        double lo, hi;
        cvol_array_range(array, index, &lo, &hi);
        const float least = (float)(lo - array->offset), most = (float)(hi - array->offset);
        const cvol_int16_scale *int16 = &w->plan->int16;
        void *first = find_samples(w, layer, lane, p.row, p.begin, sheets.begin);
        if (is_int16(w))
            CVOL_SIMD_CHOOSE(cvol_sheet_clamp_int16)
        (first, w->memory->row_stride, layer->sheet_stride, w->plan->points_lane, p.count,
         sheets.count, cvol_int16_scale_of(int16, least), cvol_int16_scale_of(int16, most));
        else CVOL_SIMD_CHOOSE(cvol_sheet_clamp)(first, w->memory->row_stride, layer->sheet_stride,
                                                w->plan->points_lane, p.count, sheets.count, least,
                                                most);
    }
}

/* Repeats the volume's outermost samples, as for plain blocks, and their cover, which lies `offset`
 * behind. Samples next to blocks that are not drawn are never read. */
static void extend_faces(const work *w, const cvol_lapped_layer *layer, piece p, sheet_span sheets,
                         ptrdiff_t offset)
{
    const cvol_sheet_plan *plan = w->plan;
    const ptrdiff_t row_stride = w->memory->row_stride,
                    lanes = (ptrdiff_t)plan->blocks_lane * plan->points_lane;
    const cvol_points_inside inside = cvol_points_inside_of(plan);
    const int lanes_beyond = plan->points_lane - inside.lanes;
    const cvol_lane_copies copies = cvol_lane_copies_of(plan);
    const size_t bytes = cvol_sample_size(plan) * (size_t)(copies.left + lanes + copies.right);
    const uint8_t *drawn = row_of(layer->skip.touched, plan, p.row);
    const int left = drawn[0], right = drawn[plan->blocks_lane - 1];
    const int above = p.row == 0 && p.begin == 0;
    const int below = p.row + 1 == plan->blocks_row && p.begin + p.count == plan->points_row;
    if (!left && !right && !above && !below)
        return;
    for (int z = sheets.begin; z < sheets.begin + sheets.count; z++) {
        void *first = cvol_sample_at(plan, find_samples(w, layer, 0, p.row, p.begin, z), offset);
        for (int r = 0; r < p.count; r++) {
            void *line = cvol_sample_at(plan, first, r * row_stride);
            if (left)
                cvol_sample_repeat(plan, line, -1, copies.left);
            if (right)
                cvol_sample_repeat(plan, cvol_sample_at(plan, line, lanes - lanes_beyond - 1), 1,
                                   lanes_beyond + copies.right);
        }
        void *top = cvol_sample_at(plan, first, -copies.left),
             *bottom = cvol_sample_at(plan, top, (inside.rows - 1 - p.begin) * row_stride);
        for (int r = 1; r <= 1 + plan->reach && above; r++)
            memcpy(cvol_sample_at(plan, top, -r * row_stride), top, bytes);
        for (int r = 1; r <= plan->points_row - inside.rows + 1 + plan->reach && below; r++)
            memcpy(cvol_sample_at(plan, bottom, r * row_stride), bottom, bytes);
    }
}

/* Writes the background to its samples, in blocks that are drawn. */
static void fill_background(const work *w, const cvol_lapped_layer *layer, piece p,
                            sheet_span sheets)
{
    const cvol_sheet_frame *frame = w->frame;
    for (size_t lane = 0; lane < w->plan->blocks_lane; lane++) {
        if (!row_of(layer->skip.touched, w->plan, p.row)[lane] ||
            row_of(layer->have, w->plan, p.row)[lane] != CVOL_HAVE_ALL)
            continue;
        const size_t index = cvol_sheet_block_index(w->plan, frame->array, lane, p.row,
                                                    layer->at.layer);
        const cvol_sheet_piece at = {find_samples(w, layer, lane, p.row, p.begin, sheets.begin),
                                     w->memory->row_stride,
                                     layer->sheet_stride,
                                     p.begin,
                                     p.count,
                                     sheets.begin,
                                     sheets.count};
        cvol_sheet_mask_fill(&at, w->plan, frame->mask_points, frame->mask, index,
                             frame->background);
    }
}

static void finish(const work *w, const cvol_lapped_layer *layer, piece p, sheet_span sheets)
{
    bound_cells(w, layer, p, sheets);
    if (w->plan->masked == CVOL_SHEET_SOME_BACKGROUND)
        fill_background(w, layer, p, sheets);
    extend_faces(w, layer, p, sheets, 0);
    if (w->memory->cover_at)
        extend_faces(w, layer, p, sheets, w->memory->cover_at);
}

/* The slice of a layer, counted along its axis, that rays meet as the i-th. */
static int slice_intersected(const cvol_sheet_plan *plan, const cvol_lapped_layer *layer, int i)
{
    return plan->ascending ? i : layer->count - 1 - i;
}

/* Filters the face between the layer before and this one. */
static void filter_sheets(const work *w, piece p)
{
    const cvol_sheet_plan *plan = w->plan;
    const uint8_t *have[2] = {row_of(w->before->have, plan, p.row),
                              row_of(w->layer->have, plan, p.row)};
    size_t begin = 0, end;
    /* A face needs both sides: the layer has the low bit if its neighbour has the high bit. */
    uint8_t sides[2][2] = {{CVOL_HAVE_HIGH, CVOL_HAVE_LOW}, {CVOL_HAVE_LOW, CVOL_HAVE_HIGH}};
    const uint8_t *side = sides[!plan->ascending];
    for (; begin < plan->blocks_lane; begin = end) {
        end = begin + 1;
        if (!(have[0][begin] & side[0]) || !(have[1][begin] & side[1]))
            continue;
        while (end < plan->blocks_lane && have[0][end] & side[0] && have[1][end] & side[1])
            end++;
        void *a[4];
        for (int i = 0; i < 4; i++) {
            const cvol_lapped_layer *of = i < 2 ? w->before : w->layer;
            const int slice = slice_intersected(plan, of, i < 2 ? of->count - 2 + i : i - 2);
            a[i] = find_samples(w, of, begin, p.row, p.begin, slice);
        }
        filter_across(w, a, w->memory->row_stride, end - begin, p.count, w->frame->filters.sheet);
    }
}

/* All slices of a layer except those that wait, or only those. */
static sheet_span find_waiting(const cvol_sheet_plan *plan, const cvol_lapped_layer *layer,
                               int waiting)
{
    const int now = layer->count - layer->held;
    if (waiting)
        return (sheet_span){plan->ascending ? now : 0, layer->held};
    return (sheet_span){plan->ascending ? 0 : layer->held, now};
}

static void complete(const work *w, piece p)
{
    const cvol_lapped_layer *before = w->before;
    if (before->reached && before->held && p.row >= before->at.first_row &&
        p.row <= before->at.last_row) {
        filter_sheets(w, p);
        finish(w, before, p, find_waiting(w->plan, before, 1));
    }
    finish(w, w->layer, p, find_waiting(w->plan, w->layer, 0));
}

void cvol_lapped_filter_row(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                            const cvol_lapped_layer *layer, const cvol_lapped_layer *before,
                            size_t row)
{
    const work w = {memory, frame, frame->plan, layer, before};
    const int points = frame->plan->points_row;
    if (row > layer->at.first_row) {
        filter_rows(&w, row);
        complete(&w, (piece){row - 1, points - 2, 2});
    }
    complete(&w, (piece){row, 0, row == layer->at.last_row ? points : points - 2});
}
