/* What a frame need not look at: blocks that the transfer function makes transparent, and blocks
 * that lie behind opaque parts of the image. */
#ifndef CVOL_RENDER_SHEET_SKIP_H
#define CVOL_RENDER_SHEET_SKIP_H

#include "render/sheet/frame.h"

/* next[lo] is the first interval (code, code + 1) of range codes at or after lo in which some value
 * is not transparent, 255 if there is none. */
typedef struct cvol_visibility {
    uint8_t next[256];
} cvol_visibility;

/* `transfer` NULL: everything is visible. */
void cvol_visibility_make(cvol_visibility *visibility, const cvol_array *array,
                          const cvol_transfer *transfer);

/* Whether the samples of the block, by themselves, can be seen. */
int cvol_visibility_of(const cvol_visibility *visibility, const cvol_block *block);

/* A block that windows with something to be seen touch; one that would be, but lies outside of what
 * is drawn. */
#define CVOL_TOUCHED_DRAWN 1
#define CVOL_TOUCHED_CLIPPED 2

/* One layer's windows (see cvol_windows) and which of its blocks they touch. */
typedef struct cvol_layer_skip {
    uint8_t *within, *across; /* [blocks_row][windows] */
    uint8_t *touched;         /* [blocks_row][blocks_lane]: 0, CVOL_TOUCHED_... */
    uint8_t *changing; /* the same, of maxima and minima: whether some pixel may be changed */
    float *levels;     /* of within, then of across; then the spreads of both */
    int windows;
    size_t first_row, last_row; /* of blocks: those that were made last */
    size_t flag_capacity, level_capacity;
} cvol_layer_skip;

/* Makes room for the layers of a plan; 0 without memory. All zero is empty. */
int cvol_layer_skip_prepare(cvol_layer_skip *skip, const cvol_sheet_plan *plan);
void cvol_layer_skip_free(cvol_layer_skip *skip);

struct cvol_extremes_seen; /* extreme.h */

/* What a layer's windows are made from. */
typedef struct cvol_skip_source {
    const cvol_sheet_plan *plan;
    const cvol_array *array;
    const cvol_visibility *visibility;
    const uint8_t *masked; /* cvol_mask_state of every block; NULL: all samples have a value */
    const struct cvol_extremes_seen *extremes; /* what pixels hold already; NULL: any may change */
} cvol_skip_source;

/* Fills the windows and touched blocks of a layer, for rows of blocks first_row .. last_row. */
void cvol_layer_skip_make(cvol_layer_skip *skip, const cvol_skip_source *source, size_t layer,
                          size_t first_row, size_t last_row);

/* Index of block (lane, row) of a layer in the array's block table. */
size_t cvol_sheet_block_index(const cvol_sheet_plan *plan, const cvol_array *array, size_t lane,
                              size_t row, size_t layer);

/* Opaque tiles: 16 x 16 pixels of the intermediate image. */
#define CVOL_TILE 16
typedef struct cvol_tiles {
    int across, down;
    uint8_t *open; /* [down][across]: some group of the tile can still change */
} cvol_tiles;

/* Of lines begin .. end - 1, begin a multiple of CVOL_TILE. */
void cvol_tiles_update(const cvol_tiles *tiles, const cvol_intermediate *intermediate, int begin,
                       int end);

/* The tiles left .. right of rows top .. bottom, none if left > right or top > bottom. */
typedef struct cvol_tile_span {
    int left, right, top, bottom;
} cvol_tile_span;

/* Those that the block (lane, row) of a layer whose sheets are z_begin .. z_end - 1 reaches; 0 if
 * it lies behind the eye. */
int cvol_block_tiles(cvol_tile_span *out, const cvol_tiles *tiles, const cvol_sheet_plan *plan,
                     size_t lane, size_t row, size_t z_begin, size_t z_end);

/* Whether the block (lane, row) of a layer whose sheets are z_begin .. z_end - 1 reaches an open
 * tile in tile rows tile_begin .. tile_end - 1, and if so, whether any tile beyond these. */
typedef enum cvol_seen { CVOL_UNSEEN, CVOL_SEEN, CVOL_SEEN_BY_MORE } cvol_seen;
cvol_seen cvol_block_seen(const cvol_tiles *tiles, const cvol_sheet_plan *plan, size_t lane,
                          size_t row, size_t z_begin, size_t z_end, int tile_begin, int tile_end);

#endif
