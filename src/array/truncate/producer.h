/* Producers: what computes the dense blocks of coefficients that an array is built from (build.h).
 */
#ifndef CVOL_ARRAY_TRUNCATE_PRODUCER_H
#define CVOL_ARRAY_TRUNCATE_PRODUCER_H

#include "cvol/array.h"

/* What a producer says of a block: coefficients beyond box[] are zero and need not have been
 * written (they are read as zero); energy is the exact sum of squares if the producer already left
 * terms out, else negative. */
typedef struct cvol_dense_block {
    float
        *coefficients; /* B^rank, u fastest; 64-byte aligned, written by the producer where it is */
    int box[3];        /* per axis one past the highest frequency that may be non-zero */
    double energy;
    float max_abs;  /* of the block's samples before truncation; negative: not known */
    uint16_t split; /* what the coefficients are those of; 0 at first: they are the block's own */
    /* Instead of all that, where a block has few coefficients: `count` of them that are not zero,
     * in rising order of their places; -1: the block is dense. */
    uint32_t *places;
    float *values;
    int count;
} cvol_dense_block;

typedef struct cvol_producer {
    /* Fills *block for block `index`; scratch is `scratch_bytes` of the thread's own, 64-byte
     * aligned, zero at first and then as the last call left it. 0, or an error code without a
     * message. */
    int (*produce)(const void *user, cvol_dense_block *block, size_t index, void *scratch);
    const void *user;
    size_t scratch_bytes;
    const char *what; /* for progress: "multiplying" */
} cvol_producer;

/* What became of it. */
typedef struct cvol_build_result {
    double dropped; /* L2 norm of what was dropped or lost to quantization, all blocks, exactly */
    double norm;    /* L2 norm of all coefficients produced */
    double max_abs; /* the largest of the blocks' own; negative if one was not known */
    double sample;  /* bounds what a sample lost: the most that a block did (L2); blocks only */
    double gain; /* what the operation multiplies samples by at most, where that is more than 1 */
} cvol_build_result;

#endif
