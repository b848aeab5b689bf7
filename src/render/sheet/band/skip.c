/* Skipping: by the values of blocks, and by the parts that the image already hides. */
#include "render/sheet/band/skip.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "render/sheet/band/extreme.h"
#include "render/transfer/transfer.h"

void cvol_visibility_make(cvol_visibility *visibility, const cvol_array *array,
                          const cvol_transfer *transfer)
{
    double unit = (array->range_max - array->range_min) / 255;
    visibility->next[255] = 255;
    for (int code = 254; code >= 0; code--) {
        double lo = array->range_min + unit * code, hi = lo + unit;
        int visible = !transfer || cvol_transfer_max_opacity(transfer, lo, hi) > 0;
        visibility->next[code] = visible ? (uint8_t)code : visibility->next[code + 1];
    }
}

/* Returns 1 if any value between range codes lo and hi is visible. */
static int is_visible(const cvol_visibility *visibility, int lo, int hi)
{
    if (lo == hi) { /* one exact value: it belongs to the intervals on both of its sides */
        lo = lo > 0 ? lo - 1 : 0;
        hi = hi < 255 ? hi + 1 : 255;
    }
    return visibility->next[lo] < hi;
}

int cvol_visibility_of(const cvol_visibility *visibility, const cvol_block *block)
{
    return is_visible(visibility, block->range[0], block->range[1]);
}

/* Returns 1 if a value between all values of one block and all of another is visible: interpolation
 * from one to the other passes it. */
static int is_gap_visible(const cvol_visibility *visibility, const cvol_block *a,
                          const cvol_block *b)
{
    const cvol_block *below = a->range[1] < b->range[1] ? a : b, *above = below == a ? b : a;
    return below->range[1] < above->range[0] && visibility->next[below->range[1]] < above->range[0];
}

/* The number of windows of a row of blocks: of 32 samples, one every 16, the first at -16. */
static int count_windows(const cvol_sheet_plan *plan)
{
    return (int)(plan->blocks_lane * (size_t)plan->points_lane / CVOL_GROUP) + 3;
}

/* Kernels read flags eight bytes at a time, and so beyond the last one. */
#define GATHERED 8

int cvol_layer_skip_prepare(cvol_layer_skip *skip, const cvol_sheet_plan *plan)
{
    const size_t blocks = plan->blocks_lane * plan->blocks_row;
    skip->windows = count_windows(plan);
    const size_t windows = plan->blocks_row * (size_t)skip->windows;
    if (!cvol_ensure(&skip->within, &skip->flag_capacity, 2 * windows + 2 * blocks + GATHERED, 1) ||
        !cvol_ensure(&skip->levels, &skip->level_capacity, 4 * windows, sizeof *skip->levels))
        return 0;
    skip->across = skip->within + windows;
    skip->touched = skip->across + windows;
    skip->changing = skip->touched + blocks;
    return 1;
}

void cvol_layer_skip_free(cvol_layer_skip *skip)
{
    free(skip->within);
    free(skip->levels);
}

/* Blocks of a row that window c, with its neighbour samples, overlaps: *first .. *last. */
static void window_blocks(size_t *first, size_t *last, const cvol_sheet_plan *plan, int c)
{
    ptrdiff_t points = plan->points_lane, begin = 16L * (c - 1) - cvol_sheet_reach(plan),
              end = begin + 31 + 2 * cvol_sheet_reach(plan);
    ptrdiff_t final = (ptrdiff_t)plan->blocks_lane - 1;
    *first = begin <= 0 ? 0 : (size_t)(begin / points > final ? final : begin / points);
    *last = (size_t)(end / points > final ? final : end / points);
}

/* The joint content of a window's blocks. */
typedef struct window_content {
    int lo, hi;   /* range codes; lo > hi: no sample has a value */
    int masked;   /* some samples have no value */
    int constant; /* for maxima and minima: of blocks that are constant (cvol_extremes_is_constant),
                   */
    double least, most; /* the values */
} window_content;

/* A block of a layer; NULL if none of its samples has a value. */
static const cvol_block *find_block(const cvol_skip_source *source, size_t lane, size_t row,
                                    size_t layer)
{
    const size_t index = cvol_sheet_block_index(source->plan, source->array, lane, row, layer);
    const int empty = source->masked && source->masked[index] == CVOL_MASK_ALL;
    return empty ? NULL : &source->array->block_table[index];
}

static void widen_constants(window_content *content, const cvol_skip_source *source, size_t index)
{
    double value;
    if (!content->constant)
        return;
    content->constant = source->extremes &&
                        cvol_extremes_is_constant(&value, source->extremes, source->plan, index);
    if (content->constant) {
        content->least = fmin(content->least, value);
        content->most = fmax(content->most, value);
    }
}

/* Adds blocks first .. last of one row. */
static void widen(window_content *content, const cvol_skip_source *source, size_t first,
                  size_t last, size_t row, size_t layer)
{
    for (size_t lane = first; lane <= last; lane++) {
        const size_t index = cvol_sheet_block_index(source->plan, source->array, lane, row, layer);
        const int state = source->masked ? source->masked[index] : CVOL_MASK_NONE;
        content->masked |= state != CVOL_MASK_NONE;
        if (state == CVOL_MASK_ALL)
            continue;
        widen_constants(content, source, index);
        const cvol_block *block = &source->array->block_table[index];
        content->lo = block->range[0] < content->lo ? block->range[0] : content->lo;
        content->hi = block->range[1] > content->hi ? block->range[1] : content->hi;
    }
}

/* Returns 1 if rays meet a visible value between one of these blocks and its neighbour in the layer
 * before or behind. Between neighbours in a layer, joint ranges decide. */
static int has_visible_gap(const cvol_skip_source *source, size_t first, size_t last, size_t row,
                           size_t layer)
{
    for (size_t lane = first; lane <= last; lane++) {
        const cvol_block *at = find_block(source, lane, row, layer);
        for (size_t other = layer ? layer - 1 : 1;
             at && other <= layer + 1 && other < source->plan->layers; other += 2) {
            const cvol_block *next_block = find_block(source, lane, row, other);
            if (next_block && is_gap_visible(source->visibility, at, next_block))
                return 1;
        }
    }
    return 0;
}

static int is_content_visible(const cvol_skip_source *source, const window_content *content)
{
    return content->lo <= content->hi && is_visible(source->visibility, content->lo, content->hi);
}

/* The middle of a range, in the units of samples; for maxima and minima its end. */
static float level_of(const cvol_skip_source *source, const window_content *content)
{
    const cvol_array *array = source->array;
    const double unit = (array->range_max - array->range_min) / 255,
                 from = array->range_min - array->offset;
    if (source->extremes)
        return cvol_extremes_bound(source->extremes->extremes,
                                   content->constant ? content->least : from + unit * content->lo,
                                   content->constant ? content->most : from + unit * content->hi,
                                   content->constant);
    return (float)(from + unit * (content->lo + content->hi) / 2);
}

/* Half of the range's width. */
static float spread_of(const cvol_array *array, const window_content *content)
{
    const double unit = (array->range_max - array->range_min) / 255;
    return content->hi > content->lo ? (float)(unit * (content->hi - content->lo) / 2) : 0;
}

static uint8_t bits_of(int seen, const window_content *content)
{
    return (uint8_t)((seen ? CVOL_WINDOW_SEEN : 0) | (content->masked ? CVOL_WINDOW_MASKED : 0));
}

/* ---- clipped parts --------------------------------------------------------------------------- */

/* Returns 1 if no sample of a block is used: neither within the drawn part, nor by interpolation,
 * nor on the slices before and behind. */
static int is_clipped(const cvol_sheet_plan *plan, size_t lane, size_t row, size_t layer)
{
    const double around = plan->lapped ? 2 : 0;
    const size_t place[3] = {lane, row, layer};
    const int block[3] = {plan->block_lane, plan->block_row, plan->block_sheet};
    const double pitch[3] = {plan->pitch_lane, plan->pitch_row, plan->pitch_sheet};
    double centre[3], half[3];
    for (int k = 0; k < 3; k++) {
        const double lo = (double)(place[k] * (size_t)block[k]);
        centre[k] = lo + (block[k] - 1) / 2.0;
        half[k] = (block[k] - 1) / 2.0 + plan->pitch_sheet + (1 + around + plan->reach) * pitch[k] +
                  0.1;
        if (centre[k] + half[k] < plan->used_lo[k] || centre[k] - half[k] > plan->used_hi[k])
            return 1;
    }
    for (int i = 0; i < plan->planes - plan->part_planes; i++) {
        double most = plan->plane[i][3];
        for (int k = 0; k < 3; k++)
            most += plan->plane[i][k] * centre[k] + fabs(plan->plane[i][k]) * half[k];
        if (most < 0)
            return 1;
    }
    return 0;
}

/* Removes clipped parts from a layer's windows and blocks. */
static void clip_layer(const cvol_layer_skip *skip, const cvol_sheet_plan *plan, size_t layer,
                       size_t first_row, size_t last_row)
{
    for (size_t row = first_row; row <= last_row; row++)
        for (size_t lane = 0; lane < plan->blocks_lane; lane++) {
            uint8_t *touched = &skip->touched[row * plan->blocks_lane + lane];
            if (*touched && is_clipped(plan, lane, row, layer))
                *touched = CVOL_TOUCHED_CLIPPED;
        }
    for (size_t row = first_row; row <= last_row; row++)
        for (int c = 0; c < skip->windows; c++) {
            const size_t at = row * (size_t)skip->windows + (size_t)c;
            const size_t beyond = row < last_row ? row + 1 : row;
            size_t first, last;
            int within = 0, across = 0;
            window_blocks(&first, &last, plan, c);
            for (size_t lane = first; lane <= last; lane++) {
                within |= skip->touched[row * plan->blocks_lane + lane] == CVOL_TOUCHED_DRAWN;
                across |= skip->touched[beyond * plan->blocks_lane + lane] == CVOL_TOUCHED_DRAWN;
            }
            if (!within)
                skip->within[at] &= (uint8_t)~CVOL_WINDOW_SEEN;
            if (!within && !across)
                skip->across[at] &= (uint8_t)~CVOL_WINDOW_SEEN;
        }
}

/* Returns 1 if the rows that a line reads lie in at most two rows of blocks. */
static int spans_two_rows(const cvol_sheet_plan *plan)
{
    return 1 + 2 * cvol_sheet_reach(plan) <= plan->points_row;
}

/* Marks everything as visible. */
static void open_all(const cvol_layer_skip *skip, const cvol_skip_source *source, size_t first_row,
                     size_t last_row)
{
    const size_t windows = (size_t)skip->windows, lanes = source->plan->blocks_lane,
                 rows = last_row - first_row + 1;
    const int bits = CVOL_WINDOW_SEEN | (source->masked ? CVOL_WINDOW_MASKED : 0);
    memset(skip->within + first_row * windows, bits, rows * windows);
    memset(skip->across + first_row * windows, bits, rows * windows);
    memset(skip->touched + first_row * lanes, CVOL_TOUCHED_DRAWN, rows * lanes);
}

/* Returns 1 if the samples of blocks first .. last of one row can change the picture: maxima and
 * minima only; a composite depends on visibility. */
static int is_changing(const cvol_layer_skip *skip, const cvol_skip_source *source, size_t first,
                       size_t last, size_t row)
{
    const uint8_t *of_row = skip->changing + row * source->plan->blocks_lane;
    return !source->extremes || memchr(of_row + first, 1, last - first + 1) != NULL;
}

static void find_changing(const cvol_layer_skip *skip, const cvol_skip_source *source, size_t layer,
                          size_t first_row, size_t last_row)
{
    const size_t lanes = source->plan->blocks_lane;
    for (size_t row = first_row; row <= last_row && source->extremes; row++)
        for (size_t lane = 0; lane < lanes; lane++)
            skip->changing[row * lanes + lane] = (uint8_t)cvol_extremes_change(
                source->extremes, source->plan, lane, row, layer);
}

void cvol_layer_skip_make(cvol_layer_skip *skip, const cvol_skip_source *source, size_t layer,
                          size_t first_row, size_t last_row)
{
    const cvol_sheet_plan *plan = source->plan;
    const size_t lanes = plan->blocks_lane, windows = plan->blocks_row * (size_t)skip->windows;
    skip->first_row = first_row;
    skip->last_row = last_row;
    memset(skip->touched + first_row * lanes, 0, lanes * (last_row - first_row + 1));
    find_changing(skip, source, layer, first_row, last_row);
    for (size_t row = first_row; row <= last_row; row++)
        for (int c = 0; c < skip->windows; c++) {
            const size_t at = row * (size_t)skip->windows + (size_t)c;
            size_t first, last;
            window_blocks(&first, &last, plan, c);
            window_content content = {255, 0, 0, 1, INFINITY, -INFINITY};
            widen(&content, source, first, last, row, layer);
            const int within = is_changing(skip, source, first, last, row) &&
                               (is_content_visible(source, &content) ||
                                has_visible_gap(source, first, last, row, layer));
            skip->within[at] = bits_of(within, &content);
            skip->levels[at] = level_of(source, &content);
            skip->levels[2 * windows + at] = spread_of(source->array, &content);
            int across = within;
            if (row < last_row && (!across || source->masked || source->extremes)) {
                widen(&content, source, first, last, row + 1, layer);
                across = across || (is_changing(skip, source, first, last, row + 1) &&
                                    (is_content_visible(source, &content) ||
                                     has_visible_gap(source, first, last, row + 1, layer)));
            }
            skip->across[at] = bits_of(across, &content);
            skip->levels[windows + at] = level_of(source, &content);
            skip->levels[3 * windows + at] = spread_of(source->array, &content);
            for (size_t lane = first; lane <= last; lane++) {
                skip->touched[row * lanes + lane] |= (uint8_t)across;
                if (row < last_row)
                    skip->touched[(row + 1) * lanes + lane] |= (uint8_t)across;
            }
        }
    if (!spans_two_rows(plan))
        open_all(skip, source, first_row, last_row);
    if (plan->clipped)
        clip_layer(skip, plan, layer, first_row, last_row);
}
