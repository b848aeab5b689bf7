/* Tiles onto a band of the lattice: the common part of the loop (band.c) and its kernels.
 *
 * Along an axis, the footprint spreads frequency u of a tile to a function of the place,
 *
 *     G[p][u] = sum_x w[p - x] D_u[x],
 *
 * the same for all tiles of a slice except the last one, which ends with the slice. So a tile's
 * terms A directly become its part of the spread slice, G_y A G_x^T, at the places of the lattice;
 * the part beyond the tile is added to that of its neighbours. */
#ifndef CVOL_RENDER_SPECTRAL_TILE_H
#define CVOL_RENDER_SPECTRAL_TILE_H

#include "base/cpu.h"
#include "render/spectral/compose.h"

/* Most floats of a vector: rows of matrices and lines are padded to whole vectors. */
#define CVOL_TILE_LANES 16
/* Most places of a spread tile along an axis: 32 samples and 31 more, padded. */
#define CVOL_TILE_PLACES 80
#define CVOL_TILE_SPARE 16

/* One tile's terms onto the sheet. */
typedef struct cvol_tile_task {
    const uint32_t *terms, *end;
    float step;
    int block_log2, columns, rows; /* 1 + the highest frequency along x, and along y */
    const float *across, *down;    /* [frequency][width]: G of both axes; down: CVOL_TILE_SPARE more
                                      floats can be read */
    int width, from, to; /* width: whole vectors; the needed places from .. to - 1 along y */
    float *out;          /* the first place along x and y */
    size_t stride;
} cvol_tile_task;
CVOL_SIMD_DECLARE(void, cvol_tile_add, (const cvol_tile_task *task));
/* Tiles with more than 1 / CVOL_TILE_DENSE of their low box are multiplied as matrices. */
#define CVOL_TILE_DENSE 3

/* Composites places of a row, and clears the sheet there. */
typedef struct cvol_tile_row {
    float *colours[CVOL_PLANES - 1], *transmittance; /* the picture: intensities, 1 - A */
    float *sheet[CVOL_PLANES - 1], *sheet_opacity;   /* sums of a slice */
    int channels, count, front;
    int cut; /* intensities are clamped to 0 .. CVOL_BRIGHTEST D, the range of exact ones */
} cvol_tile_row;
CVOL_SIMD_DECLARE(void, cvol_tile_composite, (const cvol_tile_row *row));

#endif
