/* What pictures of maxima and minima need not look at: blocks that reach no further than what all
 * the pixels that see them hold already. */
#ifndef CVOL_RENDER_SHEET_BAND_EXTREME_H
#define CVOL_RENDER_SHEET_BAND_EXTREME_H

#include "render/sheet/band/intermediate.h"

/* What the pixels of tiles hold, as samples are kept. */
typedef struct cvol_extremes {
    int sign;     /* 1: maxima; -1: minima; 0: nothing is known, all blocks are looked at */
    double slack; /* how far a sample may lie beyond its block's range: for rounding; or
                     infinitely */
    cvol_int16_scale int16; /* how values, less the array's offset, are kept */
    float *held; /* [down][across] of tiles: the least that any pixel holds, of minima the most with
                    the other sign; minus infinity where some hold nothing */
} cvol_extremes;

/* Whether ranges of blocks bound what is drawn of them: all points are samples. What lies between
 * samples, where points are fewer, may reach further. */
int cvol_extremes_have_bounds(const cvol_sheet_plan *plan);

/* Without `held`. */
cvol_extremes cvol_extremes_of(cvol_mode mode, const cvol_sheet_plan *plan,
                               const cvol_array *array);

/* What no pixel is beyond that sees values lo .. hi; `constant`: only of blocks that are constant.
 */
float cvol_extremes_bound(const cvol_extremes *extremes, double lo, double hi, int constant);

/* Of lines begin .. end - 1, begin a multiple of CVOL_TILE: nothing is held yet. And it is what the
 * lines hold now: of one row of tiles. */
void cvol_extremes_clear(const cvol_extremes *extremes, const cvol_tiles *tiles, int begin,
                         int end);
void cvol_extremes_update(const cvol_extremes *extremes, const cvol_tiles *tiles,
                          const cvol_intermediate *image, int begin, int end);

/* The least that `lines` lines of a row of tiles hold: held[width / CVOL_TILE], of what it was
 * before, which never falls. */
CVOL_SIMD_DECLARE(void, cvol_extremes_hold,
                  (float *held, const float *lines, int width, int count, int sign));

/* What the pixels of a band hold. */
typedef struct cvol_extremes_seen {
    const cvol_extremes *extremes;
    const cvol_tiles *tiles;
    const cvol_array *array;
    const uint8_t *masked;    /* cvol_mask_state of every block; NULL: nothing is kept apart */
    float background;         /* what of them is masked is, less the array's offset */
    int tile_begin, tile_end; /* its rows of tiles */
} cvol_extremes_seen;

/* Whether all samples of a block, and all that lies between them, are one value, less the array's
 * offset: exactly, which no range says. */
int cvol_extremes_is_constant(double *value, const cvol_extremes_seen *seen,
                              const cvol_sheet_plan *plan, size_t index);

/* Whether samples of the block (lane, row) of a layer can change any of them. */
int cvol_extremes_change(const cvol_extremes_seen *seen, const cvol_sheet_plan *plan, size_t lane,
                         size_t row, size_t layer);

#endif
