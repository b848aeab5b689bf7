/* Common code of tests of operations on whole arrays: arrays of many shapes, and comparison of
 * results. */
#ifndef CVOL_TESTS_SUPPORT_OPERATIONS_H
#define CVOL_TESTS_SUPPORT_OPERATIONS_H

#include "random.h"
#include "support_whole.h"

struct whole_shape {
    int rank;
    size_t dims[3];
};
enum { WHOLE_SHAPES = 17 };
extern const struct whole_shape whole_shapes[WHOLE_SHAPES];

/* The kept terms of the array, by round. */
support_whole whole_make(cvol_context *context, random_state *r, cvol_transform transform,
                         const struct whole_shape *shape, int round);

/* An array of these, and its evaluated samples. */
typedef struct whole_case {
    const struct whole_shape *shape;
    size_t count; /* of samples */
    cvol_transform transform;
    int round;
    uint64_t seed; /* the samples that it was made from */
    support_whole a;
    double *samples;
} whole_case;

/* Calls `check` with `rounds` arrays of each shape under each transform from `first` to the
 * last. */
void whole_each(cvol_context *context, random_state *r, cvol_transform first, int rounds,
                void (*check)(cvol_context *context, random_state *r, const whole_case *w));

/* Compares a result with `dense`, the operation on the array's samples (NULL: not compared), and
 * with `exact`, the operation on the exact ones. scale: the norm to which rounding is relative. */
void whole_check(const char *what, uint64_t seed, const cvol_array *result, const double *dense,
                 const double *exact, double scale);

/* Applies matrix[new n][n] along an axis; frees `in`. */
double *whole_apply(double *in, size_t dims[3], int axis, const double *matrix, size_t n_new);

/* The caller frees these. The kernel's sums: samples are mirrored beyond the ends, or periodic. */
double *whole_copy(const double *in, size_t count);
double *whole_filtered(const double *in, const size_t dims[3], const cvol_kernel *kernel,
                       int mirrored);

/* A group's context is its state; the teardown prints the worst relative error of a result's
 * samples. */
int whole_set_up(void **state);
int whole_tear_down(void **state);

#endif
