/* The inputs of the kernels of exact evaluation (exact_simd.c). */
#ifndef CVOL_ARRAY_BLOCK_EXACT_KERNEL_H
#define CVOL_ARRAY_BLOCK_EXACT_KERNEL_H

#include "array/core/array.h"

/* Matrices in units of 1, C 2^-20. */
typedef struct cvol_exact_bases {
    /* Along x, for place u = 2 g + c: its contribution to eight sums of each of two kinds. For a
     * whole block these are the even and the odd frequencies, folded about the centre; for a split
     * block its lower and its upper half. [way][u][8 c ..] is not zero. */
    double rows[3][16][16] __attribute__((aligned(64)));
    /* Along y and z: [f][x], x < M / 2. */
    double of_16[16][8], of_8[8][4], of_4[4][2];
    double filter[4];
} cvol_exact_bases;

/* Four samples across each face, as doubles; like cvol_lap_faces, along one axis. */
typedef struct cvol_exact_faces {
    int64_t stride, count, face_stride; /* across */
    int64_t lines[2], line_stride[2];
} cvol_exact_faces;

#endif
