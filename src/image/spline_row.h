/* Types of the warp (spline_warp.c) and its kernel. */
#ifndef CVOL_IMAGE_SPLINE_ROW_H
#define CVOL_IMAGE_SPLINE_ROW_H

#include <stddef.h>

#include <stdint.h>

#include "base/cpu.h"

/* One row of the picture: pixel x lies at start + x step, in places. */
typedef struct cvol_spline_row {
    const float *places; /* coefficients of splines, four floats per place */
    int (*spans)[2];     /* of places y - 1 .. y + 2: the range of occupied places */
    ptrdiff_t dims[2];
    double start[2], step[2];
    float ground[3];
    uint8_t *out;  /* RGBA over the background; or NULL, and then */
    float *values; /* colour, premultiplied, and opacity */
    int count;
} cvol_spline_row;
CVOL_SIMD_DECLARE(void, cvol_spline_sample, (const cvol_spline_row *row));

#endif
