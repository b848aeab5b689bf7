/* Common code of tests of operations on whole arrays: arrays made of random samples without the
 * compressor, and dense samples in double precision as reference. */
#ifndef CVOL_TESTS_SUPPORT_WHOLE_H
#define CVOL_TESTS_SUPPORT_WHOLE_H

#include "array/core/array.h"
#include "random.h"

/* An array and its samples, x fastest. */
typedef struct support_whole {
    cvol_array *array;
    double *exact;
} support_whole;

/* Random samples plus `offset`, of which the array keeps a low box (0: none) and every place beyond
 * it with probability share; its error bound is true. */
support_whole support_whole_make(cvol_context *context, random_state *r, cvol_transform transform,
                                 int rank, const size_t dims[3], const size_t low[3], double share,
                                 double offset);
void support_whole_free(support_whole *w);

/* All N evaluated samples, by the direct sums; freed by free(). */
double *support_whole_samples(const cvol_array *array);
/* Allocates; the test fails without memory. */
double *support_doubles(size_t count);
double support_distance(const double *a, const double *b, size_t count);
double support_norm(const double *a, size_t count);

#endif
