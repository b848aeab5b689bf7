/* The pruned transforms of cvol_multiply_grid: from two low boxes of slots to the samples of their
 * product on a grid, and to the low box that is kept. */
#ifndef CVOL_ARRAY_MULTIPLY_PASSES_H
#define CVOL_ARRAY_MULTIPLY_PASSES_H

#include "array/multiply/lines.h"

typedef struct cvol_passes {
    cvol_transform transform;
    size_t numbers;      /* floats per coefficient: 2 complex, 1 DCT */
    size_t n[3], m[3];   /* samples and points; axes inner, mid, outer */
    size_t width;        /* coefficients of a row of the inner axis: m / 2 + 1 or m */
    size_t row;          /* floats from one row of samples to the next */
    size_t depth, slabs; /* outer places of a slab; number of slabs */
    double prescale;     /* of products, so that the transforms give the kept slots */
    int all_points;      /* m = n: the products are the result's samples */
    cvol_slot_box in[2], out;
    const float *slots[2]; /* of the operands */
    float *owned[2];       /* the same if they had to be gathered */
    float *lines[3];       /* [v][outer][u]: a, b and the product, the outer axis as points */
    float *kept;           /* slots of the product's box `out` */
    double *energy; /* dropped energy of each unit of work: the sum in their order has the same bits
                       for any number of threads */
    double *largest; /* |product| of each slab */
    size_t energies;
} cvol_passes;

/* Derives all other members from transform, n, m, in, out; allocates lines, kept, energy and
 * largest. Errors: MEMORY. */
int cvol_passes_start(cvol_context *context, cvol_passes *passes);
/* Fills kept, energy, largest. Errors: MEMORY, CANCELLED. */
int cvol_passes_run(cvol_context *context, cvol_passes *passes);
void cvol_passes_free(cvol_passes *passes);

#endif
