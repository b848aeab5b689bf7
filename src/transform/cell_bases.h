/* The matrices that the kernels of split cells read, and the three ways to transform an axis. */
#ifndef CVOL_TRANSFORM_CELL_BASES_H
#define CVOL_TRANSFORM_CELL_BASES_H

#include <stdint.h>

enum { CVOL_CELL_BY_16, CVOL_CELL_BY_8, CVOL_CELL_BY_4 };

/* Along x the lanes are eight places of equal parity (c), or eight samples. An octant's axis has
 * one 8x8 matrix for either. A whole cell's axis has one for its even and one for its odd
 * frequencies, on samples folded about the centre, since D[u][15 - x] = (-1)^u D[u][x]. */
typedef struct cvol_cell_bases {
    float lanes[3][2][8][8];   /* for BY_..: [c][g][x], place u = 2 g + c, sample x of the half */
    float columns[3][2][8][8]; /* the same, [c][x][g] */
    float of_4[4 * 4];         /* D[f][x] at f M + x */
    float of_8[8 * 8];
    float of_16[16 * 16];
} cvol_cell_bases;

/* The transform of the octant of parities (cx, cy, cz). */
static inline int cvol_cell_octant_transform(uint16_t split, int cx, int cy, int cz)
{
    if (!(split & 1))
        return CVOL_CELL_BY_16;
    return split >> (1 + cx + 2 * cy + 4 * cz) & 1 ? CVOL_CELL_BY_4 : CVOL_CELL_BY_8;
}

#endif
