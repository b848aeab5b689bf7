/* The quick way from a cell's samples to its coded values: split as its coefficients' weights say,
 * and quantized with dead zones that are the same for all cells, instead of trying what costs
 * least. */
#ifndef CVOL_CODEC_QUANTIZE_SPLIT_FAST_H
#define CVOL_CODEC_QUANTIZE_SPLIT_FAST_H

#include "codec/quantize/split_choice.h"

/* One thread's memory. */
typedef struct cvol_split_fast cvol_split_fast;
cvol_split_fast *cvol_split_fast_create(void);
void cvol_split_fast_free(cvol_split_fast *quick);

/* Chooses for a cell's samples (16^3 floats, aligned), of which the first inside[] along each axis
 * are the volume's. The result holds until the next use. plain: the nearest values. */
void cvol_split_fast_choose(cvol_split_fast *quick, cvol_cell_choice *out, const float *samples,
                            const int inside[3], double step, int plain);
/* The squared error alone, in steps squared; infinity where a value is beyond the limit. */
double cvol_split_fast_error(cvol_split_fast *quick, const float *samples, const int inside[3],
                             double step, int plain);
/* What was chosen last as a block's terms (array.h), in at most 2 16^3 words. Their number; *terms
 * is counted up. */
uint32_t cvol_split_fast_terms(const cvol_split_fast *quick, uint32_t *words, size_t *terms);

#endif
