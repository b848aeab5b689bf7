/* Extends samples from a few large coefficients. */
#include "codec/quantize/split_extension.h"

#include <string.h>

/* In steps. One iteration gains three quarters of the gain of two; more than two gain nothing. */
static const float thresholds[] = {3, 1};
enum { ITERATIONS = sizeof thresholds / sizeof *thresholds };

void cvol_cell_find_inside(int inside[3], const size_t dims[3], const size_t place[3])
{
    for (int a = 0; a < 3; a++) {
        const size_t left = dims[a] - CVOL_CELL * place[a];
        inside[a] = left < CVOL_CELL ? (int)left : CVOL_CELL;
    }
}

int cvol_cell_reaches_beyond(const int inside[3], const int begin[3], int side)
{
    int beyond = 0;
    for (int a = 0; a < 3; a++) {
        if (inside[a] <= begin[a])
            return 2;
        beyond |= inside[a] < begin[a] + side;
    }
    return beyond;
}

/* Moves coefficients towards 0, except the DCs, at places below `dcs` on every axis. */
static void shrink(float *coefficients, float threshold, int dcs)
{
    for (int w = 0; w < CVOL_CELL; w++)
        for (int v = 0; v < CVOL_CELL; v++) {
            float *row = coefficients + CVOL_CELL * (v + CVOL_CELL * w);
            for (int u = w < dcs && v < dcs ? dcs : 0; u < CVOL_CELL; u++)
                row[u] = row[u] > threshold    ? row[u] - threshold
                         : row[u] < -threshold ? row[u] + threshold
                                               : 0;
        }
}

static void take_beyond(float *samples, const float *decoded, const int inside[3])
{
    for (int z = 0; z < CVOL_CELL; z++)
        for (int y = 0; y < CVOL_CELL; y++) {
            const int row = CVOL_CELL * (y + CVOL_CELL * z);
            const int first = z < inside[2] && y < inside[1] ? inside[0] : 0;
            memcpy(samples + row + first, decoded + row + first,
                   sizeof *samples * (size_t)(CVOL_CELL - first));
        }
}

void cvol_cell_forward_edge(float *coefficients, cvol_cell_edge *scratch, const float *samples,
                            const int inside[3], uint16_t split, float step)
{
    static const int box[3] = {CVOL_CELL, CVOL_CELL, CVOL_CELL};
    const int dcs = split == CVOL_CELL_WHOLE ? 1 : split == CVOL_CELL_OCTANTS ? 2 : 4;
    memcpy(scratch->samples, samples, sizeof scratch->samples);
    cvol_cell_forward(coefficients, scratch->samples, split);
    for (int i = 0; i < ITERATIONS; i++) {
        shrink(coefficients, thresholds[i] * step, dcs);
        cvol_cell_inverse(scratch->decoded, coefficients, split, box);
        take_beyond(scratch->samples, scratch->decoded, inside);
        cvol_cell_forward(coefficients, scratch->samples, split);
    }
}
