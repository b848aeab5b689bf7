/* Kernels between samples of eight types and the floats that blocks are made of. */
#ifndef CVOL_ARRAY_CORE_SAMPLES_H
#define CVOL_ARRAY_CORE_SAMPLES_H

#include "array/core/array.h"

/* How floats become samples: plus offset; integers to nearest, halves up; then within lo .. hi,
 * which NaN is the least of. */
typedef struct cvol_stored_as {
    cvol_type type;
    double offset, lo, hi; /* integers: whole numbers of the type */
} cvol_stored_as;
cvol_stored_as cvol_stored_as_of(const cvol_array *array);

/* `count` floats as samples, the first of which is out[0]. */
void cvol_samples_convert(void *out, const float *in, size_t count, const cvol_stored_as *as);

#endif
