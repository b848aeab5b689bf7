/* The chirp z-transform (Rabiner, Schafer and Rader 1969; Bluestein 1970): a spectrum of K
 * neighbouring frequencies at M points of any start and spacing.
 *
 *     FORWARD  y[j] = sum_{u < K} x[u] exp(+2 pi i (start + j step) (first + u) / n)
 *     ADJOINT  x[u] = sum_{j < M} y[j] exp(-2 pi i (start + j step) (first + u) / n)
 *
 * j u = (j^2 + u^2 - (j - u)^2) / 2 makes the sum a convolution, which takes two complex transforms
 * of a length >= K + M - 1. Phases are reduced to one turn exactly, in fixed point of 128 bits, so
 * they are as accurate for squares of 2^32 as for small numbers.
 */
#ifndef CVOL_TRANSFORM_CHIRP_H
#define CVOL_TRANSFORM_CHIRP_H

#include "cvol/base.h"

typedef struct cvol_chirp cvol_chirp;

typedef struct cvol_chirp_shape {
    int64_t first;      /* the lowest frequency */
    size_t frequencies; /* K */
    double start, step; /* finite */
    size_t points;      /* M */
    double n;           /* the period, > 0 */
} cvol_chirp_shape;

/* A plan of one direction. Freed by cvol_chirp_free; NULL is allowed there.
 * Errors: MEMORY, LIMIT. */
int cvol_chirp_create(cvol_context *context, cvol_chirp **out, const cvol_chirp_shape *shape,
                      int adjoint);
void cvol_chirp_free(cvol_chirp *chirp);

/* Floats of scratch that one apply needs, as cvol_fft_allocate gives them. */
size_t cvol_chirp_work(const cvol_chirp *chirp);

/* One line. out and in are pairs of floats, the strides count pairs; they may overlap. Plans may be
 * applied by several threads at once, each with its own work. Errors: MEMORY. */
int cvol_chirp_apply(cvol_context *context, const cvol_chirp *chirp, float *out, size_t out_stride,
                     const float *in, size_t in_stride, float *work);

#endif
