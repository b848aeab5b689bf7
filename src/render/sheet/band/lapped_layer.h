/* A band's data about the layers of a lapped array (lapped.c). */
#ifndef CVOL_RENDER_SHEET_BAND_LAPPED_LAYER_H
#define CVOL_RENDER_SHEET_BAND_LAPPED_LAYER_H

#include "render/sheet/band/layer.h"

/* The filter on the points of lanes and of rows, and on slices: h of cvol_sheet_lap_... */
typedef struct cvol_lapped_filters {
    float lane[4], row[4], sheet[4];
} cvol_lapped_filters;

/* One layer of a band. */
typedef struct cvol_lapped_layer {
    cvol_band_layer at;
    int reached;          /* the band's lines reach it; else only this is set */
    int count, held;      /* slices; number of them, the last ones, that wait for the next layer */
    cvol_layer_skip skip; /* its `touched` are the blocks whose samples are drawn */
    uint8_t *have;        /* [blocks_row][blocks_lane]: the evaluated parts of a block */
    uint8_t *seen;        /* for each row of blocks: 1 if any part is evaluated */
    void *samples;        /* of its lowest slice, in the band's memory; the next is */
    ptrdiff_t sheet_stride; /* before or behind it */
    cvol_layer drawn;       /* the view of the waiting slices */
    size_t have_capacity, seen_capacity;
} cvol_lapped_layer;

/* The layer before, this one and the next, cyclically; and their views for drawing, which are too
 * large for a thread's stack. */
typedef struct cvol_lapped_memory {
    cvol_lapped_layer layers[3];
    cvol_layer now, first_sheet, all, all_and_first;
} cvol_lapped_memory;

#endif
