/* Operands of the bench's whole arrays: the same terms for cvol and for the classical way. */
#ifndef BENCH_ALGEBRA_OPERANDS_H
#define BENCH_ALGEBRA_OPERANDS_H

#include "dense.h"

typedef enum operand_kind {
    OPERAND_LOW_BOX, /* white noise below frequency k on every axis */
    /* Scattered: rank 1, DFT and DHT, s terms of magnitude 1 to 2. The number of terms of a product
       is at most: */
    OPERAND_BANDS,      /* one band of s/2 frequencies (and its mirror) about any carrier: 4 s */
    OPERAND_HARMONICS,  /* s/16 frequencies from each of 8 multiples of one fundamental: 4.2 s */
    OPERAND_PROGRESSION /* the multiples 1 .. s/2 of one odd step modulo n, all over n: 2 s + 1 */
} operand_kind;

typedef struct operand_shape {
    operand_kind kind;
    cvol_transform transform;
    int rank;
    size_t dims[3];
    size_t count; /* k of a low box; else s */
    size_t step;  /* of the progression; the fundamental: the same for both operands */
} operand_shape;

typedef struct operand {
    cvol_array *array;
    dense_terms terms;
} operand;

/* k on the axes of the rank, 1 beyond. */
void operand_low(size_t low[3], const operand_shape *shape);
/* Random terms, from the seed *state; uses d's buffers. */
void operand_make(cvol_context *context, operand *out, const operand_shape *shape, dense *d,
                  uint64_t *state);
void operand_free(operand *o);

#endif
