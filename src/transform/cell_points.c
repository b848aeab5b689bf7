/* Cosines of the sub-blocks of an axis, frequency first (transform/cell.h). */
#define _DEFAULT_SOURCE /* M_PI */
#include "transform/cell_points.h"

#include <math.h>
#include <pthread.h>
#include <stddef.h>
#include <string.h>

#include "base/elementary.h"

enum { CELL = 16 };

/* The sub-block of this side, along an axis, to which index v belongs: 2 f + c; 4 f + 2 c' + c. */
static int part_of(int v, int side)
{
    const int half = v & 1;
    return side == 8 ? half : 2 * half + (v >> 1 & 1);
}

void cvol_cell_points_basis(float *basis, int side, int points, int width)
{
    const int parts = CELL / side;
    memset(basis, 0, sizeof *basis * (size_t)(CELL * width));
    for (int v = 0; v < CELL; v++) {
        const int part = part_of(v, side), f = v / parts;
        const double scale = sqrt((f ? 2.0 : 1.0) / side);
        for (int i = 0; i < points; i++)
            if ((2 * i + 1) * parts / (2 * points) == part) {
                const double at = (i + 0.5) * CELL / points - part * side;
                basis[v * width + i] = (float)(scale * cvol_cos(M_PI * f * at / side));
            }
    }
}

static float samples[2][CELL * CELL] __attribute__((aligned(64)));
static pthread_once_t filled = PTHREAD_ONCE_INIT;

static void fill(void)
{
    cvol_cell_points_basis(samples[0], 8, CELL, CELL);
    cvol_cell_points_basis(samples[1], 4, CELL, CELL);
}

const float *cvol_cell_samples_basis(int side)
{
    pthread_once(&filled, fill);
    return samples[side == 4];
}
