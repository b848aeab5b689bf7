/* Reference operations for arrays: the same on dense samples in double precision. */
#ifndef CVOL_TESTS_SUPPORT_EXACT_H
#define CVOL_TESTS_SUPPORT_EXACT_H

#include "cvol/cvol.h"

typedef struct support_shape {
    size_t dims[3];
    int rank, block;
    cvol_transform transform;
} support_shape;

/* The sample at x, which may be beyond the ends of an axis of n samples. */
size_t support_extended(const support_shape *s, long x, size_t n);
/* In place. */
void support_filter(double *samples, const support_shape *s, const cvol_kernel *kernel);
void support_gradient(double *samples, const support_shape *s, const double spacing[3]);
/* a becomes the circular convolution a * b. */
void support_convolve(double *a, const double *b, const support_shape *s);
/* Resamples arrays in blocks, by factor 2 or -2; the caller frees the result, *s becomes its
 * shape. */
double *support_resample(const double *samples, support_shape *s, int factor);

#endif
