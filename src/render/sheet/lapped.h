/* Layers of lapped arrays (transform/lap.h): what is evaluated onto a layer is filtered across
 * cells' faces before it is drawn. */
#ifndef CVOL_RENDER_SHEET_LAPPED_H
#define CVOL_RENDER_SHEET_LAPPED_H

#include "render/sheet/frame.h"
#include "render/sheet/skip.h"
#include "render/sheet/work_stealing.h"
#include "transform/cell.h"

/* A layer as one band sees it. */
typedef struct cvol_band_layer {
    size_t layer, z_begin, z_end; /* sheets */
    size_t first_row, last_row;   /* of blocks */
    int tile_begin, tile_end;     /* rows of tiles */
} cvol_band_layer;

/* What the filter is on the points of lanes and of rows, and on sheets: h of cvol_sheet_lap_... */
typedef struct cvol_lapped_filters {
    float lane[4], row[4], sheet[4];
} cvol_lapped_filters;

cvol_lapped_filters cvol_lapped_filters_of(const cvol_sheet_plan *plan);

/* One layer of a band. */
typedef struct cvol_lapped_layer {
    cvol_band_layer at;
    int reached;          /* by the band's lines; else only this is set */
    int count, held;      /* sheets; how many of them, the last ones met, wait for the next layer */
    cvol_layer_skip skip; /* its `touched` are the cells whose samples are drawn */
    uint8_t *have;        /* [blocks_row][blocks_lane]: what of a cell has been evaluated */
    uint8_t *seen;        /* for each row of cells: whether that is anything at all */
    void *samples;        /* of its lowest sheet, in the band's; the next is */
    long sheet_stride;    /* before or behind it */
    cvol_layer drawn;     /* the view of the sheets held */
    size_t have_capacity, seen_capacity;
} cvol_lapped_layer;

/* The layer before, this one, the next: in turn; and the views of them that are drawn, which are
 * large for a thread's stack. */
typedef struct cvol_lapped_memory {
    cvol_lapped_layer layers[3];
    cvol_layer now, first_sheet, all, all_and_first;
} cvol_lapped_memory;

/* Makes room; 0 without memory. */
int cvol_lapped_prepare(cvol_lapped_memory *memory, const cvol_sheet_plan *plan);
void cvol_lapped_free(cvol_lapped_memory *memory);

/* Draws what the band's next layer completes of its lines. */
void cvol_lapped_draw(cvol_sheet_share *share, int thread, cvol_band *band);
/* Evaluates the layer before the band's next one, for what of it waits for that one. */
void cvol_lapped_go_on(cvol_band_memory *memory, const cvol_sheet_frame *frame,
                       const cvol_band *band);

/* ---- lapped_filter.c --------------------------------------------------------------------
 */

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
