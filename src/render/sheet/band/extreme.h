/* Blocks that pictures of maxima and minima can skip: those whose range does not exceed the values
 * of all the pixels that see them. */
#ifndef CVOL_RENDER_SHEET_BAND_EXTREME_H
#define CVOL_RENDER_SHEET_BAND_EXTREME_H

#include "cvol/render.h"
#include "render/sheet/band/intermediate.h"

/* The values of the pixels of tiles, in the units of the stored samples. */
typedef struct cvol_extremes {
    int sign;     /* 1: maxima; -1: minima; 0: unknown, no block is skipped */
    double slack; /* the largest distance of a sample beyond its block's range: for rounding; or
                     infinite */
    cvol_int16_scale int16; /* format of stored values, minus the array's offset */
    float *held; /* [down][across] of tiles: the least value of any pixel, for minima the most with
                    the other sign; minus infinity if some pixel is empty */
} cvol_extremes;

/* Returns 1 if ranges of blocks bound the picture: all points are samples. If points are fewer,
 * values between samples may exceed the range. */
int cvol_extremes_have_bounds(const cvol_sheet_plan *plan);

/* Without `held`. */
cvol_extremes cvol_extremes_of(cvol_mode mode, const cvol_sheet_plan *plan,
                               const cvol_array *array);

/* A bound of pixels that see values lo .. hi; `constant`: only for constant blocks. */
float cvol_extremes_bound(const cvol_extremes *extremes, double lo, double hi, int constant);

/* For lines begin .. end - 1, begin a multiple of CVOL_TILE: marks them as empty; and sets the
 * values from the lines, for one row of tiles. */
void cvol_extremes_clear(const cvol_extremes *extremes, const cvol_tiles *tiles, int begin,
                         int end);
void cvol_extremes_update(const cvol_extremes *extremes, const cvol_tiles *tiles,
                          const cvol_intermediate *image, int begin, int end);

/* The least value of `lines` lines of a row of tiles: held[width / CVOL_TILE], starting from its
 * old value, which never falls. */
CVOL_SIMD_DECLARE(void, cvol_extremes_accumulate,
                  (float *held, const float *lines, int width, int count, int sign));

/* The values of the pixels of a band. */
typedef struct cvol_extremes_seen {
    const cvol_extremes *extremes;
    const cvol_tiles *tiles;
    const cvol_array *array;
    const uint8_t *masked;    /* cvol_mask_state of every block; NULL: no mask */
    float background;         /* value of masked samples, minus the array's offset */
    int tile_begin, tile_end; /* its rows of tiles */
} cvol_extremes_seen;

/* Returns 1 if all samples of a block, and all values between them, are exactly one value, minus
 * the array's offset. (A range is not exact.) */
int cvol_extremes_is_constant(double *value, const cvol_extremes_seen *seen,
                              const cvol_sheet_plan *plan, size_t index);

/* Returns 1 if samples of the block (lane, row) of a layer can change any pixel. */
int cvol_extremes_change(const cvol_extremes_seen *seen, const cvol_sheet_plan *plan, size_t lane,
                         size_t row, size_t layer);

#endif
