/* Producers: they compute the dense blocks of coefficients from which an array is built
 * (build.h). */
#ifndef CVOL_ARRAY_TRUNCATE_PRODUCER_H
#define CVOL_ARRAY_TRUNCATE_PRODUCER_H

#include "cvol/array.h"

/* A producer's result for a block. Coefficients beyond box[] are zero and need not be written (they
 * are read as zero). energy is the exact sum of squares if the producer already left terms out,
 * else negative. */
typedef struct cvol_dense_block {
    float
        *coefficients; /* B^rank, u fastest; 64-byte aligned, written by the producer where it is */
    int box[3];        /* per axis one past the highest frequency that may be non-zero */
    double energy;
    float max_abs;       /* of the block's samples before truncation; negative: unknown */
    uint16_t split;      /* the split of the coefficients; 0 at first: the block's own */
    float expected_step; /* from the builder: about the step of quantization; 0: unknown */
    /* Alternatively, for a block of few coefficients: `count` nonzero ones, in rising order of
     * their places; -1: the block is dense. */
    uint32_t *places;
    float *values;
    int count;
} cvol_dense_block;

typedef struct cvol_producer {
    /* Fills *block for block `index`; scratch is `scratch_bytes` of the thread's own, 64-byte
     * aligned, zero at first, then as the last call left it. Returns 0, or an error code without a
     * message. */
    int (*produce)(const void *user, cvol_dense_block *block, size_t index, void *scratch);
    const void *user;
    size_t scratch_bytes;
    const char *what; /* for progress: "multiplying" */
} cvol_producer;

/* The result of a build. */
typedef struct cvol_build_result {
    double dropped; /* L2 norm of dropped terms and of quantization errors, all blocks, exactly */
    double norm;    /* L2 norm of all coefficients produced */
    double max_abs; /* the largest of all blocks; negative if one was unknown */
    double sample;  /* bounds the loss of a sample, before the post-filter: the largest loss of a
                       block (L2), or of a sample under CVOL_KEEP_LOSS; blocks only */
    double gain;    /* the operation's largest factor on samples, if above 1 */
    double
        factors; /* products: the largest magnitude of a factor, times the other one; blocks only */
    int is_default; /* the rule CVOL_KEEP_LOSS chose what was dropped */
} cvol_build_result;

#endif
