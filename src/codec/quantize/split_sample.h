/* Cells from all over a volume, kept as they are transformed: by these the error of a step is known
 * roughly before anything is coded, as if all cells were coded the quick way (split_fast.h).
 *
 * Cells are those at the points frac(k (g^-1, g^-2, g^-3)), g^4 = g + 1 (Roberts 2018). As many of
 * them as in a few bricks, but apart, tell of more: neighbours are alike. */
#ifndef CVOL_CODEC_QUANTIZE_SPLIT_SAMPLE_H
#define CVOL_CODEC_QUANTIZE_SPLIT_SAMPLE_H

#include "array/block/brick.h"
#include "codec/quantize/split_choice.h"

typedef struct cvol_cell_sample cvol_cell_sample;

/* Reads at most `most` cells of a volume in memory, in blocks of 16; shape's dims, lapped and
 * offset count. 16 KiB a cell. Errors: MEMORY. */
int cvol_cell_sample_make(cvol_context *context, cvol_cell_sample **out, const cvol_array *shape,
                          const cvol_slab *slab, size_t most);
void cvol_cell_sample_free(cvol_cell_sample *sample); /* NULL is allowed */

/* The squared error of a cell's coefficients on the average, in the samples' units, as one of
 * `every` cells says. Infinity if values are beyond the limit. Errors: MEMORY. */
int cvol_cell_sample_error(cvol_context *context, double *error, const cvol_cell_sample *sample,
                           double step, int plain, size_t every);

#endif
