/* Layers of lapped arrays (transform/lap.h): evaluated layers are filtered across the faces of
 * blocks before they are drawn. */
#ifndef CVOL_RENDER_SHEET_BAND_LAPPED_H
#define CVOL_RENDER_SHEET_BAND_LAPPED_H

#include "render/sheet/band/band_memory.h"
#include "transform/cell.h"

cvol_lapped_filters cvol_lapped_filters_of(const cvol_sheet_plan *plan);

/* Allocates memory; 0 without memory. */
int cvol_lapped_prepare(cvol_lapped_memory *memory, const cvol_sheet_plan *plan);
void cvol_lapped_free(cvol_lapped_memory *memory);

/* Draws the part of its lines that the band's next layer completes. */
void cvol_lapped_draw(cvol_work_stealing *share, int thread, cvol_band *band);
/* Evaluates the waiting part of the layer before the band's next one. */
void cvol_lapped_evaluate_rest(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                               const cvol_band *band);

/* ---- lapped_filter.c ------------------------------------------------------------------------- */

/* The evaluated parts of a block: its two lowest slices, its two highest, the others. */
#define CVOL_HAVE_LOW 1
#define CVOL_HAVE_HIGH 2
#define CVOL_HAVE_ALL 7

/* Returns 1 if the face between blocks k - 1 and k of an axis is filtered. */
static inline int cvol_lapped_face(size_t k, size_t samples)
{
    return k > 0 && CVOL_CELL * k + 2 <= samples;
}

/* Filters the face between a block that was just evaluated and the one before it. */
void cvol_lapped_filter_lane(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                             const cvol_lapped_layer *layer, size_t lane, size_t row);

/* Completes samples once row `row` of the layer's blocks, and those before it, have been evaluated
 * and filtered between lanes: up to two rows before its end, and to its end if it is the last. It
 * completes the waiting slices of `before`, the layer before, and this layer's slices except those
 * that wait. */
void cvol_lapped_filter_row(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                            const cvol_lapped_layer *layer, const cvol_lapped_layer *before,
                            size_t row);

#endif
