/* One block of a kernel's result, from its own and its neighbours' terms, in the transform domain.
 *
 * Along one axis of n samples in blocks of B, mirrored at its ends, a line of taps g acts on blocks
 * as
 *     out_i = sum_{d = -1, 0, 1} H_d in_{i + d},     H_d = D C_d D^T,
 *     C_d[x][y] = sum of the g[m] for which sample B i + x - m, mirrored, is sample B (i + d) + y
 * with D the DCT of the block: three B x B matrices, the same for all blocks except those at the
 * ends. A kernel is a sum of products of such lines, so a block's result is
 *     sum_parts weight sum_{d in {-1, 0, 1}^3} (H_dx (x) H_dy (x) H_dz) in_{b + d}
 * It differs from a convolution of the samples only by rounding: no block face is left out. */
#ifndef CVOL_ARRAY_CONVOLVE_BLOCK_CONVOLVE_H
#define CVOL_ARRAY_CONVOLVE_BLOCK_CONVOLVE_H

#include "array/core/array.h"
#include "transform/block.h"

/* The matrices of one line at one block, d = -1, 0, 1; NULL if there is no neighbour or it has no
 * effect. Along x transposed, rows padded to width: [u in][u out]; along y and z [out][in]. */
typedef struct cvol_face_matrices {
    const float *of[3];
} cvol_face_matrices;

typedef struct cvol_convolve_part {
    float weight; /* times the array's step */
    cvol_face_matrices x, y, z;
} cvol_convolve_part;

/* Scratch memory of one thread. */
typedef struct cvol_convolve_work {
    float lanes[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX] __attribute__((aligned(64)));
    float rows[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX] __attribute__((aligned(64)));
    float sum[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX] __attribute__((aligned(64)));
} cvol_convolve_work;

/* out[B^3], completely. near[1 + dx + 3 (1 + dy) + 9 (1 + dz)]: the block and its neighbours; NULL
 * if there is none. */
void cvol_block_convolve(float *out, const cvol_block *const near[27],
                         const cvol_convolve_part *parts, int part_count, int block_log2,
                         cvol_convolve_work *work);

#endif
