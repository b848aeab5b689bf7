/* The parts of the plan `sparse` (sparse.c explains how they work together). DFT and DHT.
 *
 * Terms: the *working group* is the cyclic group of length[0] x length[1] x length[2] places in
 * which the product's terms are found. It is the array's own group if its lengths divide well, else
 * a group so long that no sum of two frequencies wraps around. A *cell* is a box of cell[]
 * neighbouring places. A *fold* takes the places modulo fold[]; length = fold x nodes, so a place w
 * = r + fold t lies in the bin r at the node t. */
#ifndef CVOL_ARRAY_MULTIPLY_SPARSE_H
#define CVOL_ARRAY_MULTIPLY_SPARSE_H

#include "array/core/array.h"
#include "array/truncate/build.h"
#include "array/truncate/producer.h"

#define CVOL_SPARSE_NODES 4096 /* most places that fall into one bin */
#define CVOL_SPARSE_SHIFTS \
    12 /* most samplings, and terms in a bin; beyond that a full transform is equally cheap */

/* The nodes at which a column may have terms, rising; unused ones are 0. */
typedef struct cvol_sparse_nodes {
    uint16_t count, at[CVOL_SPARSE_SHIFTS];
} cvol_sparse_nodes;

/* A complex coefficient F (orthonormal) at a place of the working group, and its conjugate at the
 * mirror place. */
typedef struct cvol_sparse_term {
    uint32_t at[3];
    int alone; /* it is its own mirror, and real */
    float re, im;
} cvol_sparse_term;

typedef struct cvol_sparse_terms {
    cvol_sparse_term *terms;
    size_t count;
    size_t extent[3]; /* largest |signed frequency| */
} cvol_sparse_terms;

typedef struct cvol_sparse_shape {
    cvol_transform transform;
    size_t dims[3], length[3];
    size_t multiplier,
        inverse; /* rank 1: working place = multiplier * place modulo n; 1: no dilation */
    size_t cell[3], cells[3]; /* places per cell, cells per axis */
    size_t cell_count, cell_places;
    uint8_t *present;     /* of each cell, x fastest: 1 if the product may have terms in it */
    size_t present_count; /* the number of 1s in it */
    size_t fold[3], nodes[3], node_count, bins; /* bins: the product of fold[] */
    size_t columns[3], column_count;            /* fold / cell: cells under the fold */
    cvol_sparse_nodes *present_nodes;           /* of each column */
    size_t most;                                /* the largest count in one column */
    double *node_roots[3];                      /* e(t / nodes[a]) of each axis, re and im */
    double cost_ns, least_ns; /* by the model: of this fold, of the best possible one */
    size_t shift_count, shifts[CVOL_SPARSE_SHIFTS][3];
    double gain; /* bounds the L2 norm of the solver, times sqrt(shift_count); 1 at best */
} cvol_sparse_shape;

/* ---- sparse_terms.c -------------------------------------------------------------------------- */

/* The array's terms of at least magnitude `least`, as complex coefficients at places of the array;
 * *tail is the L2 norm of the smaller ones. Errors: MEMORY. */
int cvol_sparse_terms_make(cvol_context *context, cvol_sparse_terms *out, double *tail,
                           const cvol_array *array, double least);
/* Rank 1: moves the place u to multiplier u modulo n. */
void cvol_sparse_terms_dilate(cvol_sparse_terms *terms, size_t n, size_t multiplier);
/* Moves the terms to their places in the working group. */
void cvol_sparse_terms_move(cvol_sparse_terms *terms, const cvol_sparse_shape *shape);
void cvol_sparse_terms_free(cvol_sparse_terms *terms);

/* ---- sparse_dilate.c ------------------------------------------------------------------------- */

/* Rank 1: a multiplier m, prime to n, that brings all places near 0; 1 if none was found. */
size_t cvol_sparse_multiplier(const cvol_sparse_terms *a, const cvol_sparse_terms *b, size_t n,
                              size_t *inverse);

/* ---- sparse_support.c ------------------------------------------------------------------------ */

/* Chooses the working group and the cells, moves the terms into it, and finds the cells in which
 * the product can have terms: a certain superset. *found 0: there is no structure. Errors:
 * MEMORY. */
int cvol_sparse_support(cvol_context *context, cvol_sparse_shape *shape, int *found,
                        cvol_sparse_terms *a, cvol_sparse_terms *b);
/* ---- sparse_columns.c ------------------------------------------------------------------------ */

/* Chooses the cheapest fold that pays. *found 0: none does. Errors: MEMORY. */
int cvol_sparse_choose_fold(cvol_context *context, cvol_sparse_shape *shape, int *found,
                            size_t terms);
void cvol_sparse_shape_free(cvol_sparse_shape *shape);

/* ---- sparse_shifts.c ------------------------------------------------------------------------- */

/* Chooses the shifts, so that they separate every column's nodes with a small gain; *found 0: there
 * are none. Errors: MEMORY. */
int cvol_sparse_choose_shifts(cvol_context *context, cvol_sparse_shape *shape, int *found);
/* The least squares solution for these nodes: matrix[2 (shift_count i + s)] and the next are the
 * complex weight of shift s for node i. Returns the Frobenius norm, times sqrt(shift_count)
 * (infinity: the shifts do not separate the nodes). */
double cvol_sparse_solver(const cvol_sparse_shape *shape, const cvol_sparse_nodes *nodes,
                          double *matrix);

/* ---- sparse_fold.c --------------------------------------------------------------------------- */

/* e(j / n) = exp(2 pi i j / n) for all j < n from two short tables. */
typedef struct cvol_sparse_roots {
    size_t n, low_mask;
    int low_bits;
    float *low, *high; /* pairs */
} cvol_sparse_roots;
int cvol_sparse_roots_make(cvol_context *context, cvol_sparse_roots roots[3],
                           const cvol_sparse_shape *shape);
void cvol_sparse_roots_free(cvol_sparse_roots roots[3]);
/* *re + i *im = sum over the axes: e(at shift / length). */
static inline void cvol_sparse_phase(const cvol_sparse_roots roots[3], const size_t at[3],
                                     const size_t shift[3], float *re, float *im)
{
    float x = 1, y = 0;
    for (int a = 0; a < 3; a++) {
        if (!shift[a])
            continue;
        const size_t j = at[a] * shift[a] % roots[a].n;
        const float *low = roots[a].low + 2 * (j & roots[a].low_mask);
        const float *high = roots[a].high + 2 * (j >> roots[a].low_bits);
        const float c = low[0] * high[0] - low[1] * high[1];
        const float d = low[0] * high[1] + low[1] * high[0];
        const float t = x * c - y * d;
        y = x * d + y * c;
        x = t;
    }
    *re = x;
    *im = y;
}

/* values[s]: the half complex fold of the product at shift s, scaled so that a single term w of the
 * product (orthonormal) appears as itself times e(w shift / length). *noise bounds the L2 norm of
 * the rounding in all of them. values: shift_count arrays of cvol_sparse_half(shape) floats. */
size_t cvol_sparse_half(const cvol_sparse_shape *shape);
int cvol_sparse_fold(cvol_context *context, float *const *values, double *noise,
                     const cvol_sparse_shape *shape, const cvol_sparse_roots roots[3],
                     const cvol_sparse_terms *a, const cvol_sparse_terms *b);

/* ---- sparse_solve.c -------------------------------------------------------------------------- */

/* The product's slots in the present cells of the working group, cell after cell. */
typedef struct cvol_sparse_found {
    int plain; /* the working group is the array's own group: slots of its transform; else of the
                  DFT */
    uint32_t *index; /* of each cell: its number among the present ones; UINT32_MAX: none */
    float *slots;
} cvol_sparse_found;

/* Solves every column. *stray is the L2 norm of the folds in columns that must be empty. Errors:
 * MEMORY. */
int cvol_sparse_solve(cvol_context *context, cvol_sparse_found *found, double *stray,
                      const cvol_sparse_shape *shape, const cvol_sparse_roots roots[3],
                      float *const *values);
void cvol_sparse_found_free(cvol_sparse_found *found);

/* ---- sparse_keep.c --------------------------------------------------------------------------- */

/* Truncates by `keep`. spent: the L2 norm of the terms left out before. *kept 0: rounding and
 * `spent` exceed the allowed loss; `out` is still empty. */
int cvol_sparse_keep(cvol_context *context, cvol_array *out, cvol_build_result *result, int *kept,
                     const cvol_sparse_shape *shape, const cvol_sparse_found *found, double noise,
                     double spent, const cvol_keep *keep);

#endif
