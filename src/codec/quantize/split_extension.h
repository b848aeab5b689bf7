/* Extends the samples of cells that reach beyond the volume.
 *
 * These samples are don't-care, so the encoder makes them cheap. They begin as repeats of the last
 * samples inside. Then the encoder moves coefficients towards 0 by a threshold, and takes the
 * padding from the decoded result, which continues the large coefficients (Guleryuz 2006,
 * "Nonlinear approximation based image recovery using adaptive sparse reconstructions and iterated
 * denoising"). The threshold falls in each iteration. */
#ifndef CVOL_CODEC_QUANTIZE_SPLIT_EXTENSION_H
#define CVOL_CODEC_QUANTIZE_SPLIT_EXTENSION_H

#include <stddef.h>

#include "transform/cell.h"

typedef struct cvol_cell_edge {
    float samples[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    float decoded[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
} cvol_cell_edge;

/* The number of samples within the volume, along each axis, of the cell at `place` (in cells). */
void cvol_cell_find_inside(int inside[3], const size_t dims[3], const size_t place[3]);

/* Tests if a sub-block of this side at begin[] reaches beyond the volume, in a cell with inside[]
 * samples within it: 1 if some of its samples are inside, 2 if none are, else 0. */
int cvol_cell_reaches_beyond(const int inside[3], const int begin[3], int side);

/* Works as cvol_cell_forward (split: whole, octants or fours) for a cell that reaches beyond the
 * volume. step: the distance between values. */
void cvol_cell_forward_edge(float *coefficients, cvol_cell_edge *scratch, const float *samples,
                            const int inside[3], uint16_t split, float step);

#endif
