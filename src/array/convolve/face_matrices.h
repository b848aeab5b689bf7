/* The matrices that apply a line of taps to the DCT blocks of an axis (block_convolve.h). */
#ifndef CVOL_ARRAY_CONVOLVE_FACE_MATRICES_H
#define CVOL_ARRAY_CONVOLVE_FACE_MATRICES_H

#include "array/convolve/block_convolve.h"
#include "cvol/algebra.h"

/* For one axis. Blocks 1 .. count - 3 share their matrices. */
typedef struct cvol_axis_matrices {
    float *memory;
    size_t kinds, block_count;
} cvol_axis_matrices;

/* n samples in blocks of B; the line's radius is at most B. transposed: the form for the x axis.
 * Errors: MEMORY. */
int cvol_axis_matrices_make(cvol_context *context, cvol_axis_matrices *out,
                            const cvol_kernel_line *line, size_t n, int block, int transposed);
void cvol_axis_matrices_free(cvol_axis_matrices *matrices);

/* The matrices of block i. */
cvol_face_matrices cvol_axis_matrices_at(const cvol_axis_matrices *matrices, size_t i, int block,
                                         int radius);

#endif
