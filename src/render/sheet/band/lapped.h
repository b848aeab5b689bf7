/* Layers of lapped arrays (transform/lap.h): what is evaluated onto a layer is filtered across
 * cells' faces before it is drawn. */
#ifndef CVOL_RENDER_SHEET_BAND_LAPPED_H
#define CVOL_RENDER_SHEET_BAND_LAPPED_H

#include "render/sheet/band/band_memory.h"
#include "transform/cell.h"

cvol_lapped_filters cvol_lapped_filters_of(const cvol_sheet_plan *plan);

/* Makes room; 0 without memory. */
int cvol_lapped_prepare(cvol_lapped_memory *memory, const cvol_sheet_plan *plan);
void cvol_lapped_free(cvol_lapped_memory *memory);

/* Draws what the band's next layer completes of its lines. */
void cvol_lapped_draw(cvol_work_stealing *share, int thread, cvol_band *band);
/* Evaluates the layer before the band's next one, for what of it waits for that one. */
void cvol_lapped_go_on(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                       const cvol_band *band);

/* ---- lapped_filter.c ------------------------------------------------------------------------- */

/* What of a cell is evaluated: its two lowest sheets, its two highest, the others. */
#define CVOL_HAVE_LOW 1
#define CVOL_HAVE_HIGH 2
#define CVOL_HAVE_ALL 7

/* Whether the face between cells k - 1 and k of an axis is filtered. */
static inline int cvol_lapped_face(size_t k, size_t samples)
{
    return k > 0 && CVOL_CELL * k + 2 <= samples;
}

/* The face between a cell that was evaluated just now and the one before it. */
void cvol_lapped_filter_lane(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                             const cvol_lapped_layer *layer, size_t lane, size_t row);

/* Completes samples once row `row` of the layer's cells has been evaluated, and filtered between
 * lanes, those before it having been: up to two rows before its end, and to its end if it is the
 * last. What it completes: the sheets that `before`, the layer before, holds, and this layer's but
 * those that it holds. */
void cvol_lapped_filter_row(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                            const cvol_lapped_layer *layer, const cvol_lapped_layer *before,
                            size_t row);

#endif
