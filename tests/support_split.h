/* Arrays with split cells, for tests. */
#ifndef CVOL_TESTS_SUPPORT_SPLIT_H
#define CVOL_TESTS_SUPPORT_SPLIT_H

#include "array/core/array.h"

/* The same samples, to half a step, in cells of 16^3 that are split at random. */
void support_split_cells(cvol_context *context, cvol_array *array, uint64_t seed);

#endif
