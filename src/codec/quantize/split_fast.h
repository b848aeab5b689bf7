/* The fast choice of a cell's split and values: it splits by the weights of coefficients, and
 * quantizes with fixed dead zones, instead of comparing costs. */
#ifndef CVOL_CODEC_QUANTIZE_SPLIT_FAST_H
#define CVOL_CODEC_QUANTIZE_SPLIT_FAST_H

#include "codec/quantize/split_choice.h"

/* One thread's memory. */
typedef struct cvol_split_fast cvol_split_fast;
cvol_split_fast *cvol_split_fast_create(void);
void cvol_split_fast_free(cvol_split_fast *fast);

/* Chooses for a cell's samples (16^3 floats, aligned), of which the first inside[] along each axis
 * belong to the volume. The result holds until the next use. plain: the nearest values. */
void cvol_split_fast_choose(cvol_split_fast *fast, cvol_cell_choice *out, const float *samples,
                            const int inside[3], double step, int plain);
/* Returns only the squared error, in steps squared; infinity if a value exceeds the limit. */
double cvol_split_fast_error(cvol_split_fast *fast, const float *samples, const int inside[3],
                             double step, int plain);
/* Writes the last choice as a block's terms (array.h), in at most 2 16^3 words. Returns their
 * number; adds to *terms. */
uint32_t cvol_split_fast_terms(const cvol_split_fast *fast, uint32_t *words, size_t *terms);

#endif
