/* The cost of a product of two whole arrays by each plan: a model, in milliseconds on one
 * thread. */
#ifndef CVOL_ARRAY_MULTIPLY_COST_H
#define CVOL_ARRAY_MULTIPLY_COST_H

#include "array/core/array.h"

/* The model's description of a product. */
typedef struct cvol_multiply_task {
    cvol_transform transform;
    int rank;
    size_t dims[3];
    size_t extent[2][3]; /* of the operands, see cvol_spectrum_extent */
    double terms[2];
    int low_only;      /* only a low box is kept ... */
    size_t kept[3];    /* ... of this k */
    size_t most[3];    /* candidates are below this frequency of each axis; 0: all are */
    double kept_terms; /* bounds the number of kept terms; negative: unknown */
} cvol_multiply_task;

cvol_multiply_task cvol_multiply_task_of(const cvol_array *a, const cvol_array *b,
                                         const cvol_keep *keep);

/* The points per axis of the plan `grid`: no aliases, fast transforms; dims if that is no more. */
void cvol_multiply_points(size_t points[3], const cvol_multiply_task *task);

/* The points of one axis of n samples for a product of frequencies up to `extent`. */
size_t cvol_multiply_length(cvol_transform transform, size_t n, size_t extent);

double cvol_multiply_cost_direct(const cvol_multiply_task *task);
/* With points = dims: the plan `full`. */
double cvol_multiply_cost_grid(const cvol_multiply_task *task, const size_t points[3]);
/* INFINITY under DCT. */
double cvol_multiply_cost_sparse(const cvol_multiply_task *task);

/* Returns 1 if `direct` sums in a dense array of `hull` places, 0 for a hash table. */
int cvol_multiply_is_dense(double hull, double products);

#endif
