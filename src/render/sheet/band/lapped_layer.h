/* What a band keeps of the layers of a lapped array (lapped.h). */
#ifndef CVOL_RENDER_SHEET_BAND_LAPPED_LAYER_H
#define CVOL_RENDER_SHEET_BAND_LAPPED_LAYER_H

#include "render/sheet/band/layer.h"

/* What the filter is on the points of lanes and of rows, and on sheets: h of cvol_sheet_lap_... */
typedef struct cvol_lapped_filters {
    float lane[4], row[4], sheet[4];
} cvol_lapped_filters;

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

#endif
