/* Transformed cells from all over a volume, to estimate the error of a step before encoding, with
 * the fast choice (split_fast.h) for all cells.
 *
 * It takes the cells at the points frac(k (g^-1, g^-2, g^-3)), g^4 = g + 1 (Roberts 2018).
 * Scattered cells give a better estimate than the same number of cells in a few bricks, because
 * neighbours are alike. */
#ifndef CVOL_CODEC_QUANTIZE_SPLIT_SAMPLE_H
#define CVOL_CODEC_QUANTIZE_SPLIT_SAMPLE_H

#include "array/block/brick.h"
#include "codec/quantize/split_choice.h"

typedef struct cvol_cell_sample cvol_cell_sample;

/* Reads at most `most` cells of a volume in memory, in blocks of 16; uses shape's dims, lapped and
 * offset. Memory: 16 KiB per cell. Errors: MEMORY. */
int cvol_cell_sample_make(cvol_context *context, cvol_cell_sample **out, const cvol_array *shape,
                          const cvol_slab *slab, size_t most);
void cvol_cell_sample_free(cvol_cell_sample *sample); /* NULL is allowed */

/* The mean squared error of a cell's coefficients, in the samples' units, estimated on one in
 * `every` cells. Infinity if values exceed the limit. Errors: MEMORY. */
int cvol_cell_sample_error(cvol_context *context, double *error, const cvol_cell_sample *sample,
                           double step, int plain, size_t every);

#endif
