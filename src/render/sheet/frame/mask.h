/* Samples that are not part of the transform (array/core/mask.h), for the sheet engine. A
 * background is written to its samples after their evaluation. If samples have no value, a layer
 * also has their cover: the share of each that has a value. */
#ifndef CVOL_RENDER_SHEET_FRAME_MASK_H
#define CVOL_RENDER_SHEET_FRAME_MASK_H

#include "array/core/mask.h"
#include "render/sheet/frame/frame.h"

/* The mask, for all views: the cvol_mask_state of every block, and for blocks with both kinds of
 * samples a bit for each sample, 1: masked. All zero is empty. */
typedef struct cvol_sheet_mask {
    uint8_t *states;
    uint32_t *mixed; /* for blocks with both: the number of their bits */
    /* [mixed][2][B][B] rows of B bits: along x by y and z, and along y by x and z (z slowest).
     * Samples beyond the volume's faces repeat those at them. */
    uint16_t *bits;
    size_t bytes; /* of these */
    int block;
} cvol_sheet_mask;

/* Errors: MEMORY. */
int cvol_sheet_mask_make(cvol_context *context, cvol_sheet_mask *mask, const cvol_array *array);
void cvol_sheet_mask_free(cvol_sheet_mask *mask);

/* The masked samples of a block of the mask: rows y + 16 z; the block must have both kinds. */
void cvol_sheet_mask_rows(uint16_t rows[CVOL_MASK_ROWS], const cvol_mask *mask,
                          const size_t cell[3]);
/* The evaluated value of masked samples, without the offset; 0 without a background. */
float cvol_sheet_background(const cvol_array *array, const cvol_mask *mask);

/* Some samples of a layer's block: `rows` rows from `row` on of `sheets` slices from `sheet` on,
 * the first of them at `at`. */
typedef struct cvol_sheet_piece {
    void *at; /* floats, or the plan's int16 format */
    ptrdiff_t row_stride, sheet_stride;
    int row, rows, sheet, sheets;
} cvol_sheet_piece;

/* The position of each point of an axis: the samples on both sides and the weight of the second. */
typedef struct cvol_mask_points {
    int near[CVOL_BLOCK_MAX], far[CVOL_BLOCK_MAX];
    float weight[CVOL_BLOCK_MAX];
    int count, are_samples;
} cvol_mask_points;

/* A block's points among its bits: row r of slice z begins at bits[r row_step + z sheet_step]. */
typedef struct cvol_mask_grid {
    const uint16_t *bits;
    int row_step, sheet_step, block;
    const cvol_mask_points *lane, *row, *sheet;
} cvol_mask_grid;

/* If points are not samples: the cover of a box, from samples of cover 1 and, masked, 0, by the
 * points' weights; and its values, moved towards the background by the share that is masked. */
CVOL_SIMD_DECLARE(void, cvol_sheet_cover,
                  (const cvol_sheet_piece *piece, const cvol_mask_grid *grid));
CVOL_SIMD_DECLARE(void, cvol_sheet_fill_masked_points,
                  (const cvol_sheet_piece *piece, const cvol_mask_grid *grid, float background));
CVOL_SIMD_DECLARE(void, cvol_sheet_fill_masked_points_int16,
                  (const cvol_sheet_piece *piece, const cvol_mask_grid *grid, int16_t background));

/* The points of a plan along lane, row and sheet. */
void cvol_mask_points_find(cvol_mask_points points[3], const cvol_sheet_plan *plan, int block);

/* Prefetches the bits of a block that is needed soon. */
void cvol_sheet_mask_prefetch(const cvol_sheet_mask *mask, const cvol_sheet_plan *plan,
                              size_t index);

/* Writes `background` to the samples of block `index` that are masked. */
void cvol_sheet_mask_fill(const cvol_sheet_piece *piece, const cvol_sheet_plan *plan,
                          const cvol_mask_points points[3], const cvol_sheet_mask *mask,
                          size_t index, float background);
/* Writes the cover of the samples. */
void cvol_sheet_mask_cover(const cvol_sheet_piece *piece, const cvol_sheet_plan *plan,
                           const cvol_mask_points points[3], const cvol_sheet_mask *mask,
                           size_t index);

#endif
