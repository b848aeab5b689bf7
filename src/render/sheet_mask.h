/* Samples that are no part of the transform (array/mask.h) as the sheet engine sees them: a
 * background is put where its samples are, once they are evaluated; of samples without a value
 * there is a cover beside the layer's samples, how much of each is of samples that have one. */
#ifndef CVOL_RENDER_SHEET_MASK_H
#define CVOL_RENDER_SHEET_MASK_H

#include "array/mask.h"
#include "render/sheet.h"

/* The mask, once and for all views: the cvol_mask_state of every block, and of those that have both
 * kinds of samples a bit for each sample, 1: masked. All zero is empty. */
typedef struct cvol_sheet_mask {
    uint8_t *states;
    uint32_t *mixed; /* of blocks with both: the number of their bits */
    /* [mixed][2][B][B] rows of B bits: along x by y and z, and along y by x and z (z slowest).
     * Samples beyond the volume's faces are what those at them are. */
    uint16_t *bits;
    int block;
} cvol_sheet_mask;

/* Errors: MEMORY. */
int cvol_sheet_mask_make(cvol_context *context, cvol_sheet_mask *mask, const cvol_array *array);
void cvol_sheet_mask_free(cvol_sheet_mask *mask);

/* Which samples of a cell of the mask are masked: rows y + 16 z; the cell has to have both kinds.
 */
void cvol_sheet_mask_rows(uint16_t rows[CVOL_MASK_ROWS], const cvol_mask *mask,
                          const size_t cell[3]);
/* What masked samples are as they are evaluated, without the offset; 0 without a background. */
float cvol_sheet_background(const cvol_array *array, const cvol_mask *mask);

/* Some samples of a block as a layer has them: `rows` rows from `row` on of `sheets` sheets from
 * `sheet` on, the first of them at `at`. */
typedef struct cvol_sheet_piece {
    float *at;
    long row_stride, sheet_stride;
    int row, rows, sheet, sheets;
} cvol_sheet_piece;

/* Puts `background` in place of those samples of block `index` that are masked. */
void cvol_sheet_mask_lay(const cvol_sheet_piece *piece, const cvol_sheet_plan *plan,
                         const cvol_sheet_mask *mask, size_t index, float background);
/* Writes the cover of the samples. */
void cvol_sheet_mask_cover(const cvol_sheet_piece *piece, const cvol_sheet_plan *plan,
                           const cvol_sheet_mask *mask, size_t index);

#endif
