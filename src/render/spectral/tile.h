/* Tiles onto a band of the lattice: what the loop (band.c) and its kernels share.
 *
 * Along an axis, frequency u of a tile is spread by the footprint to a function of the place,
 *
 *     G[p][u] = sum_x w[p - x] D_u[x],
 *
 * the same for all tiles of a slice but the last one, which ends with the slice. So a tile's terms
 * become its part of the spread slice at once: A to G_y A G_x^T, at the places that the lattice
 * has; what reaches beyond the tile is added to what its neighbours make of it there.
 */
#ifndef CVOL_RENDER_SPECTRAL_TILE_H
#define CVOL_RENDER_SPECTRAL_TILE_H

#include "base/cpu.h"
#include "render/spectral/compose.h"

/* Floats of a vector at most: rows of matrices and lines are padded to whole ones. */
#define CVOL_TILE_LANES 16
/* Places that a spread tile covers along an axis, at most: 32 samples and 31 more, padded. */
#define CVOL_TILE_PLACES 80
#define CVOL_TILE_SPARE 16

/* One tile's terms onto the sheet. */
typedef struct cvol_tile_task {
    const uint32_t *terms, *end;
    float step;
    int block_log2, columns, rows; /* 1 + the highest frequency along x, and along y */
    const float *across, *down; /* [frequency][width]: G of both axes; down: CVOL_TILE_SPARE floats
                                 * more can be read */
    int width, from, to; /* width: whole vectors; the places from .. to - 1 along y are wanted */
    float *out;          /* the first place along x and y */
    size_t stride;
} cvol_tile_task;
CVOL_SIMD_DECLARE(void, cvol_tile_add, (const cvol_tile_task *task));
/* Tiles with more than 1 / CVOL_TILE_DENSE of their low box are multiplied as matrices. */
#define CVOL_TILE_DENSE 3

/* Composites places of a row; those of the sheet are emptied. */
typedef struct cvol_tile_row {
    float *colours[CVOL_PLANES - 1], *through;     /* the picture: intensities, 1 - A */
    float *sheet[CVOL_PLANES - 1], *sheet_opacity; /* sums of a slice */
    int channels, count, front;
    int cut; /* intensities are within 0 .. CVOL_BRIGHTEST D, as the truth's are */
} cvol_tile_row;
CVOL_SIMD_DECLARE(void, cvol_tile_composite, (const cvol_tile_row *row));

#endif
