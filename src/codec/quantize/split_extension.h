/* Cells that reach beyond the volume: what their samples are there.
 *
 * Nobody sees these samples, so they may be whatever makes the cell cheap. They begin as repeats of
 * the last ones inside. Then coefficients are brought nearer to 0 by a threshold, and what they
 * decode to is taken beyond the volume, where it continues what is large (Guleryuz 2006, "Nonlinear
 * approximation based image recovery using adaptive sparse reconstructions and iterated
 * denoising"); the threshold falls from turn to turn.
 */
#ifndef CVOL_CODEC_QUANTIZE_SPLIT_EXTENSION_H
#define CVOL_CODEC_QUANTIZE_SPLIT_EXTENSION_H

#include <stddef.h>

#include "transform/cell.h"

typedef struct cvol_cell_edge {
    float samples[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
    float decoded[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
} cvol_cell_edge;

/* Samples of the cell at `place` (in cells) that are the volume's, along each axis. */
void cvol_cell_find_inside(int inside[3], const size_t dims[3], const size_t place[3]);

/* Whether the volume ends before a part of this side does that begins at begin[] of a cell of which
 * inside[] samples are the volume's along each axis: 1 with some of its samples inside, 2 with
 * none. */
int cvol_cell_reaches_beyond(const int inside[3], const int begin[3], int side);

/* As cvol_cell_forward (split: whole, octants or fours) of a cell that reaches beyond the volume.
 * step: what tells values apart. */
void cvol_cell_forward_edge(float *coefficients, cvol_cell_edge *scratch, const float *samples,
                            const int inside[3], uint16_t split, float step);

#endif
