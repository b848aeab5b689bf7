/* Planes: arrays of rank 2 as quantized coefficients, tile by tile (tile_code.h).
 *
 * A plane's coefficients are whole numbers times its step. Arrays in blocks always have such
 * coefficients; cvol_plane_quantise must first round the coefficients of a whole array. */
#ifndef CVOL_CODEC_CONTAINER_PLANE_CODE_H
#define CVOL_CODEC_CONTAINER_PLANE_CODE_H

#include "array/core/array.h"
#include "codec/entropy/tile_code.h"

typedef struct cvol_plane_shape {
    size_t dims[2];
    cvol_transform transform;
    int block; /* side of the tiles; 0: one tile, the plane */
} cvol_plane_shape;

/* The number of tiles and of coefficients, padding included. */
uint64_t cvol_plane_tiles(const cvol_plane_shape *shape);
uint64_t cvol_plane_places(const cvol_plane_shape *shape);

/* Returns the coefficients of a plane, tile after tile, u fastest in a tile, in units of the step.
 * The caller frees *out. Errors: DATA (beyond the coder's range), MEMORY. */
int cvol_plane_values(cvol_context *context, int32_t **out, const cvol_array *array, double step);
/* The inverse: makes an array without bounds. Errors: CORRUPT (terms too large for float32; `name`
 * begins the message), MEMORY. */
int cvol_plane_array(cvol_context *context, cvol_array **out, const int32_t *values,
                     const cvol_plane_shape *shape, double step, const char *name);

/* Encodes all tiles, or decodes them into `values`; returns 0 if a tile is damaged. before: the
 * values of a similar plane of this shape, or NULL. */
int cvol_plane_code(const cvol_tile_coder *coder, int32_t *values, const int32_t *before,
                    const cvol_plane_shape *shape);

/* Makes an array from the coefficients of another of rank 2: rounds them to multiples of `step`,
 * and drops those below 3/5 of it. Errors: DATA, MEMORY. */
int cvol_plane_quantise(cvol_context *context, cvol_array **out, const cvol_array *array,
                        double step);

#endif
