/* The samples of a band: blocks evaluated onto its layers. */
#ifndef CVOL_RENDER_SHEET_BAND_BAND_SAMPLES_H
#define CVOL_RENDER_SHEET_BAND_BAND_SAMPLES_H

#include "render/sheet/band/band_memory.h"

/* Copies a sample to `times` samples before (`way` -1) or behind it (1). */
void cvol_sample_repeat(const cvol_sheet_plan *plan, void *sample, int way, int times);

/* The number of the last block's points along lanes and rows that lie within the volume. */
typedef struct cvol_points_inside {
    int lanes, rows;
} cvol_points_inside;

cvol_points_inside cvol_points_inside_of(const cvol_sheet_plan *plan);

/* The number of repeats of a row's first and last sample beyond the volume's faces. */
typedef struct cvol_lane_copies {
    int left, right;
} cvol_lane_copies;

static inline cvol_lane_copies cvol_lane_copies_of(const cvol_sheet_plan *plan)
{
    return (cvol_lane_copies){2 + plan->reach, 2 + plan->reach};
}

/* Returns 1 if a block is all background, so that its terms have no effect. (In lapped arrays they
 * affect neighbouring blocks.) */
int cvol_band_is_background(const cvol_sheet_frame *frame, size_t index);
/* Prefetches the first terms of a block that will soon be evaluated. Except along one axis, they
 * are not adjacent in memory to the terms of the block before. The hardware prefetches the terms
 * that follow. */
void cvol_band_prefetch(const cvol_sheet_frame *frame, const cvol_layer_skip *skip,
                        const cvol_band_layer *at, size_t lane, size_t row);
cvol_skip_source cvol_band_skip_source(const cvol_sheet_frame *frame,
                                       const cvol_extremes_seen *extremes);
/* The values that the pixels of a band have so far. */
cvol_extremes_seen cvol_band_extremes(const cvol_sheet_frame *frame, const cvol_band *band);
/* The same for drawing, with counters if requested. */
cvol_line cvol_band_line_of(cvol_band_memory *memory, const cvol_sheet_frame *frame, int j);
/* Counts the multiply-adds of evaluating a block. */
void cvol_band_count_block(cvol_band_memory *memory, const cvol_sheet_frame *frame, size_t index);

/* Evaluates a block onto samples; slices as in axes->sheet_ends. */
void cvol_band_evaluate(cvol_band_memory *memory, const cvol_sheet_frame *frame, void *out,
                        ptrdiff_t sheet_stride, size_t index, const cvol_block_axes *axes);

#endif
