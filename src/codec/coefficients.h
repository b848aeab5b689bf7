/* The forward transform of a whole volume, each block in the coder's scan order. */
#ifndef CVOL_CODEC_COEFFICIENTS_H
#define CVOL_CODEC_COEFFICIENTS_H

#include "array/array.h"

typedef struct cvol_coefficients {
    float *data;   /* B^3 per block */
    float largest; /* magnitude */
} cvol_coefficients;

/* Transforms the samples minus shape->offset. Errors: MEMORY, CANCELLED. */
int cvol_coefficients_make(cvol_context *context, cvol_coefficients *out, const cvol_array *shape,
                           const void *samples);
void cvol_coefficients_free(cvol_coefficients *coefficients);

#endif
