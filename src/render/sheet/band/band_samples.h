/* The samples of a band: blocks evaluated onto its layers. */
#ifndef CVOL_RENDER_SHEET_BAND_BAND_SAMPLES_H
#define CVOL_RENDER_SHEET_BAND_BAND_SAMPLES_H

#include "render/sheet/band/band_memory.h"

/* Copies a sample to the next `times` samples before (`way` -1) or behind it (1). */
void cvol_sample_repeat(const cvol_sheet_plan *plan, void *sample, int way, int times);

/* How many of the last block's points along lanes and rows lie within the volume. */
typedef struct cvol_points_inside {
    int lanes, rows;
} cvol_points_inside;

cvol_points_inside cvol_points_inside_of(const cvol_sheet_plan *plan);

/* How often a row's first and last sample are repeated beyond the volume's faces. */
typedef struct cvol_lane_copies {
    int left, right;
} cvol_lane_copies;

static inline cvol_lane_copies cvol_lane_copies_of(const cvol_sheet_plan *plan)
{
    return plan->wide ? (cvol_lane_copies){2 + plan->reach, 2 + plan->reach}
                      : (cvol_lane_copies){2, 1};
}

/* Whether all of a block is the background's, so that its terms do not matter: in lapped arrays
 * they do, for blocks beside it. */
int cvol_band_is_background(const cvol_sheet_frame *frame, size_t index);
/* Asks for the first terms of a block that will be evaluated soon, if it is: they lie elsewhere in
 * memory than those of the block before, but along one axis. What follows them comes by itself. */
void cvol_band_prefetch(const cvol_sheet_frame *frame, const cvol_layer_skip *skip,
                        const cvol_band_layer *at, size_t lane, size_t row);
cvol_skip_source cvol_band_skip_source(const cvol_sheet_frame *frame,
                                       const cvol_extremes_seen *extremes);
/* What the pixels of a band hold. */
cvol_extremes_seen cvol_band_extremes(const cvol_sheet_frame *frame, const cvol_band *band);
/* The same for drawing: what is to be counted is. */
cvol_line cvol_band_line_of(cvol_band_memory *memory, const cvol_sheet_frame *frame, int j);
/* Counts what evaluating a block takes. */
void cvol_band_count_block(cvol_band_memory *memory, const cvol_sheet_frame *frame, size_t index);

/* Evaluates a block onto samples; sheets as axes->sheet_ends says. */
void cvol_band_evaluate(cvol_band_memory *memory, const cvol_sheet_frame *frame, void *out,
                        long sheet_stride, size_t index, const cvol_block_axes *axes);

#endif
