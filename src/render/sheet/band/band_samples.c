/* The samples of a band: see band_samples.h. */
#include "render/sheet/band/band_samples.h"

#include <math.h>
#include <string.h>

#include "render/sheet/band/layer.h"

void cvol_sample_repeat(const cvol_sheet_plan *plan, void *sample, int way, int times)
{
    for (int i = 1; i <= times; i++)
        if (plan->int16.scale > 0)
            ((int16_t *)sample)[i * way] = *(int16_t *)sample;
        else
            ((float *)sample)[i * way] = *(float *)sample;
}

/* The number of the last block's points along an axis whose middle lies within the volume. */
static int count_inside(size_t samples, size_t blocks, int block, int points, double pitch,
                        double first)
{
    const double inside = (double)samples - (double)(blocks - 1) * block;
    const int count = (int)floor((inside - 0.5 - first) / pitch + 1e-6) + 1;
    return count < 1 ? 1 : count > points ? points : count;
}

cvol_points_inside cvol_points_inside_of(const cvol_sheet_plan *plan)
{
    if (plan->level) /* a level's padding samples are repeats already */
        return (cvol_points_inside){plan->points_lane, plan->points_row};
    return (cvol_points_inside){count_inside(plan->lanes, plan->blocks_lane, plan->block_lane,
                                             plan->points_lane, plan->pitch_lane, plan->first_lane),
                                count_inside(plan->rows, plan->blocks_row, plan->block_row,
                                             plan->points_row, plan->pitch_row, plan->first_row)};
}

cvol_extremes_seen cvol_band_extremes(const cvol_sheet_frame *frame, const cvol_band *band)
{
    const int has_separate_mask = frame->mask && !frame->level;
    return (cvol_extremes_seen){.extremes = &frame->extremes,
                                .tiles = frame->tiles,
                                .array = frame->array,
                                .masked = has_separate_mask ? frame->mask->states : NULL,
                                .background = frame->background,
                                .tile_begin = band->begin / CVOL_TILE,
                                .tile_end = cvol_band_tile_end(band)};
}

cvol_skip_source cvol_band_skip_source(const cvol_sheet_frame *frame,
                                       const cvol_extremes_seen *extremes)
{
    const int has_void = frame->plan->masked == CVOL_SHEET_SOME_VOID;
    return (cvol_skip_source){frame->plan, frame->array, frame->visibility,
                              has_void ? frame->mask->states : NULL,
                              frame->extremes.sign ? extremes : NULL};
}

int cvol_band_is_background(const cvol_sheet_frame *frame, size_t index)
{
    return frame->plan->masked == CVOL_SHEET_SOME_BACKGROUND && !frame->plan->lapped &&
           frame->mask && !frame->level && frame->mask->states[index] == CVOL_MASK_ALL;
}

void cvol_band_prefetch(const cvol_sheet_frame *frame, const cvol_layer_skip *skip,
                        const cvol_band_layer *at, size_t lane, size_t row)
{
    enum { LINE = 16, WORDS = 16 * LINE }; /* a cache line, in words of 4 bytes */
    const cvol_sheet_plan *plan = frame->plan;
    if (frame->level || lane >= plan->blocks_lane ||
        skip->touched[row * plan->blocks_lane + lane] != CVOL_TOUCHED_DRAWN)
        return;
    const size_t index = cvol_sheet_block_index(plan, frame->array, lane, row, at->layer);
    if (cvol_block_cache_prefetch(&frame->cache, index) || cvol_band_is_background(frame, index))
        return;
    const cvol_block *block = &frame->array->block_table[index];
    for (size_t word = 0; word < block->words && word < WORDS; word += LINE)
        __builtin_prefetch(block->terms + word);
    if (frame->mask)
        cvol_sheet_mask_prefetch(frame->mask, plan, index);
}

void cvol_band_evaluate(cvol_band_memory *memory, const cvol_sheet_frame *frame, void *out,
                        ptrdiff_t sheet_stride, size_t index, const cvol_block_axes *axes)
{
    const cvol_array *array = frame->array;
    const cvol_block *block = &array->block_table[index];
    cvol_band_count_block(memory, frame, index);
    if (frame->plan->int16.scale > 0)
        CVOL_SIMD_CHOOSE(cvol_sheet_evaluate_int16)
    (out, memory->row_stride, sheet_stride, block, axes, array->block_log2, (float)array->step,
     &frame->plan->int16, memory->work);
    else frame->evaluate(out, memory->row_stride, sheet_stride, block, axes, array->block_log2,
                         (float)array->step, memory->work);
}

cvol_line cvol_band_line_of(cvol_band_memory *memory, const cvol_sheet_frame *frame, int j)
{
    cvol_line line = cvol_band_line(frame->intermediate, j);
    line.multiply_adds = frame->counts ? &memory->multiply_adds : NULL;
    return line;
}

/* Counts the terms onto lanes, then rows, then slices. The symmetry of a basis halves the work. For
 * sub-blocks, each reaches half of an axis or less, which halves it again. */
void cvol_band_count_block(cvol_band_memory *memory, const cvol_sheet_frame *frame, size_t index)
{
    if (!frame->counts)
        return;
    const cvol_block *block = &frame->array->block_table[index];
    const cvol_block_axes *axes = &frame->axes;
    const uint64_t lanes = (uint64_t)axes->lane_points, rows = (uint64_t)axes->row_points,
                   sheets = (uint64_t)axes->sheet_points, share = block->split ? 4 : 2,
                   low_row = (uint64_t)cvol_block_frequencies(axes, axes->row_points,
                                                              block->low[axes->row]),
                   low_sheet = (uint64_t)cvol_block_frequencies(axes, axes->sheet_points,
                                                                block->low[axes->sheet]);
    memory->multiply_adds += block->words * lanes + low_sheet * low_row * rows * lanes / share +
                             low_sheet * sheets * rows * lanes / share;
}
