/* The bases of a split cell's parts (transform/cell.h) at places that need not be samples. */
#ifndef CVOL_TRANSFORM_CELL_POINTS_H
#define CVOL_TRANSFORM_CELL_POINTS_H

/* Along one axis of a cell of 16 samples, at `points` places that lie symmetrically about its
 * centre and span it: basis[v * width + i] is what index v, a frequency of a part of side 8 or 4,
 * is at place i; 0 beyond that part. Of places on the face between two parts the upper part has it.
 * width >= points. */
void cvol_cell_points_basis(float *basis, int side, int points, int width);

/* The same at the 16 samples, rows of 16, 64-byte aligned. Static. */
const float *cvol_cell_samples_basis(int side);

#endif
