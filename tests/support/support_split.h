/* Arrays with split cells, for tests. */
#ifndef CVOL_TESTS_SUPPORT_SPLIT_H
#define CVOL_TESTS_SUPPORT_SPLIT_H

#include "array/core/array.h"

/* The same samples, to half a step, in cells of 16^3 that are split at random. */
void support_split_cells(cvol_context *context, cvol_array *array, uint64_t seed);

/* Transforms the samples of cell i, which has its split, and quantizes them; the terms are written
 * to `at`, where 2 * CVOL_CELL_SAMPLES words must fit. Returns the end of the terms. */
uint32_t *support_cell_code(cvol_array *array, size_t i, uint32_t *at, const float *samples);

#endif
