/* The product of two DCT blocks, sample by sample, as coefficients: evaluate, multiply, transform.
 *
 *     (oa + fa) (ob + fb) = oa ob + (oa fb + ob fa + fa fb)
 *
 * fa, fb are the samples of the blocks' terms, oa, ob the arrays' offsets. The kernel gives the
 * coefficients of the bracket. Two blocks with frequencies below Ka and Kb give one with
 * frequencies below Ka + Kb - 1; along y and z this number of points suffices if it is less than B.
 * If it is more, frequencies fold, which is correct: the result is the product of samples. */
#ifndef CVOL_ARRAY_MULTIPLY_BLOCK_PRODUCT_H
#define CVOL_ARRAY_MULTIPLY_BLOCK_PRODUCT_H

#include "array/core/array.h"
#include "transform/block.h"

typedef struct cvol_product_factor {
    const cvol_block *block;
    float step, offset;
} cvol_product_factor;

/* Scratch memory of one thread. */
typedef struct cvol_product_work {
    float memory[4][CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX] __attribute__((aligned(64)));
} cvol_product_work;

/* out[B^3]: coefficients within box[3], which is set; 0 along an axis: all are zero. */
void cvol_block_product(float *out, int box[3], const cvol_product_factor *a,
                        const cvol_product_factor *b, int block_log2, cvol_product_work *work);

#endif
