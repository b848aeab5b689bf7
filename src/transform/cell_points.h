/* The bases of a split cell's sub-blocks (transform/cell.h) at any places. */
#ifndef CVOL_TRANSFORM_CELL_POINTS_H
#define CVOL_TRANSFORM_CELL_POINTS_H

/* Along one axis of a cell of 16 samples, at `points` places that are symmetric about its centre
 * and span it: basis[v * width + i] is the value of index v, a frequency of a sub-block of side 8
 * or 4, at place i; 0 outside of that sub-block. Places on the face between two sub-blocks belong
 * to the upper one. width >= points. */
void cvol_cell_points_basis(float *basis, int side, int points, int width);

/* The same at the 16 samples, rows of 16, 64-byte aligned. Static. */
const float *cvol_cell_samples_basis(int side);

#endif
