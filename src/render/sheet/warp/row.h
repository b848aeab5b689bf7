/* The common types of the warp (warp.c) and its kernels (warp_simd.c). */
#ifndef CVOL_RENDER_SHEET_WARP_ROW_H
#define CVOL_RENDER_SHEET_WARP_ROW_H

#include <stdint.h>

#include "base/cpu.h"
#include "render/sheet/frame/frame.h"

/* Pixels of the picture are made in chunks of this many. */
#define CVOL_WARP_CHUNK 64

/* The intermediate image in the warp's form: pixels of four floats. */
typedef struct cvol_warp_source {
    const float *pixels;
    ptrdiff_t stride; /* floats from line to line */
    int width, height;
    const int *reach; /* [height][2]: the span of lines j - 1 .. j + 2 that is not empty: from, up
                         to; none if from is more than up to */
    float empty[4];   /* the pixel around it */
} cvol_warp_source;

/* Places (u[i], v[i]) in intermediate pixels, for one row of the picture: neighbours are
 * consecutive along a line. */
typedef struct cvol_warp_places {
    double u[CVOL_WARP_CHUNK], v[CVOL_WARP_CHUNK];
    int count;
} cvol_warp_places;

/* The places of pixels first .. first + places->count - 1 of line y of the picture. */
void cvol_warp_locate(cvol_warp_places *places, const cvol_sheet_plan *plan, int y, int first);
/* The pixels of a line of the picture that are the plan's: *begin .. *end - 1. */
void cvol_warp_pixels(int *begin, int *end, const cvol_sheet_plan *plan, int y, int width);

/* Values there, four floats each, by Catmull-Rom interpolation. Returns 0, and writes nothing, if
 * all are empty. */
CVOL_SIMD_DECLARE(int, cvol_warp_sample,
                  (float *values, const cvol_warp_source *source, const cvol_warp_places *places));
/* Bytes of `count` pixels of premultiplied colour and transmittance over a background: RGB and
 * 255. `values` has room for a chunk. */
CVOL_SIMD_DECLARE(void, cvol_warp_bytes,
                  (uint8_t * rgba, const float *values, int count, const float background[3]));

#endif
