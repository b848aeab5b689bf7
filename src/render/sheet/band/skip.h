/* Parts that a frame need not draw: blocks that the transfer function makes transparent, and blocks
 * behind opaque parts of the image. */
#ifndef CVOL_RENDER_SHEET_BAND_SKIP_H
#define CVOL_RENDER_SHEET_BAND_SKIP_H

#include "cvol/transfer.h"
#include "render/sheet/frame/frame.h"

/* next[lo] is the first interval (code, code + 1) of range codes at or after lo in which some value
 * is not transparent, 255 if there is none. */
typedef struct cvol_visibility {
    uint8_t next[256];
} cvol_visibility;

/* `transfer` NULL: everything is visible. */
void cvol_visibility_make(cvol_visibility *visibility, const cvol_array *array,
                          const cvol_transfer *transfer);

/* Returns 1 if the samples of the block, by themselves, are visible. */
int cvol_visibility_of(const cvol_visibility *visibility, const cvol_block *block);

/* A block that visible windows touch; one that they would touch, but that lies outside of the drawn
 * part. */
#define CVOL_TOUCHED_DRAWN 1
#define CVOL_TOUCHED_CLIPPED 2

/* One layer's windows (see cvol_windows) and the blocks that they touch. */
typedef struct cvol_layer_skip {
    uint8_t *within, *across; /* [blocks_row][windows] */
    uint8_t *touched;         /* [blocks_row][blocks_lane]: 0, CVOL_TOUCHED_... */
    uint8_t *changing;        /* the same, for maxima and minima: 1 if some pixel may change */
    float *levels;            /* of within, then of across; then the spreads of both */
    int windows;
    size_t first_row, last_row; /* of blocks: the ones made last */
    size_t flag_capacity, level_capacity;
} cvol_layer_skip;

/* Allocates memory for the layers of a plan; 0 without memory. All zero is empty. */
int cvol_layer_skip_prepare(cvol_layer_skip *skip, const cvol_sheet_plan *plan);
void cvol_layer_skip_free(cvol_layer_skip *skip);

struct cvol_extremes_seen; /* extreme.h */

/* The inputs of a layer's windows. */
typedef struct cvol_skip_source {
    const cvol_sheet_plan *plan;
    const cvol_array *array;
    const cvol_visibility *visibility;
    const uint8_t *masked; /* cvol_mask_state of every block; NULL: all samples have a value */
    const struct cvol_extremes_seen *extremes; /* current values of pixels; NULL: any may change */
} cvol_skip_source;

/* Fills the windows and touched blocks of a layer, for rows of blocks first_row .. last_row. */
void cvol_layer_skip_make(cvol_layer_skip *skip, const cvol_skip_source *source, size_t layer,
                          size_t first_row, size_t last_row);

#endif
