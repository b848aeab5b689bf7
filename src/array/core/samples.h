/* Kernels that convert between samples of eight types and the floats of blocks. */
#ifndef CVOL_ARRAY_CORE_SAMPLES_H
#define CVOL_ARRAY_CORE_SAMPLES_H

#include "array/core/array.h"

/* Conversion of floats to samples: plus offset; integers to nearest, halves up; then clamped to lo
 * .. hi, with NaN as lo. */
typedef struct cvol_sample_format {
    cvol_type type;
    double offset, lo, hi; /* integers: integers of the type */
} cvol_sample_format;
cvol_sample_format cvol_sample_format_of(const cvol_array *array);

/* Converts `count` floats to samples, from out[0] on. */
void cvol_samples_convert(void *out, const float *in, size_t count, const cvol_sample_format *as);

#endif
