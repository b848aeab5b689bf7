/* Finds the coefficients of a dense block that are large enough to be kept, and packs them. */
#ifndef CVOL_ARRAY_TRUNCATE_BUILD_PACK_H
#define CVOL_ARRAY_TRUNCATE_BUILD_PACK_H

#include <stdint.h>

/* The scan reads whole vectors: buffers of coefficients, keys, places and values are this much
 * longer than a block. */
#define CVOL_SCAN_MARGIN 16

typedef struct cvol_scan_task {
    const float *coefficients; /* B^rank, u fastest; ignored beyond the box */
    const float *keys;         /* magnitudes that decide; NULL: the coefficients' own */
    int box[3], rank, block_log2;
    float least; /* keys of at least this are kept; positive */
    uint32_t *places;
    float *values;
    /* results: */
    uint32_t count;
    double lost; /* sum of squares of the others */
} cvol_scan_task;

/* Magnitudes of 2^CVOL_MAX_BITS steps and more cannot be quantized. */
enum { CVOL_MAX_BITS = 30 };

typedef struct cvol_pack_task {
    const float *values;    /* all three readable up to the margin */
    const uint32_t *places; /* rising */
    uint32_t count;
    int block_log2;
    double step;
    float least;       /* magnitudes below become zero */
    int32_t *integers; /* result: to the nearest, halves away from zero; up to the margin */
    uint32_t *words;   /* result: the nonzero terms; room for two per value, and the margin */
    uint32_t word_count, terms;
    uint8_t low[3];    /* as cvol_block's */
    double lost, norm; /* sums of squares: of the quantization errors, of the values */
    double largest;    /* magnitude */
} cvol_pack_task;

/* Both have the same bits on every processor. */
void cvol_block_scan(cvol_scan_task *task);
void cvol_block_pack(cvol_pack_task *task);

#endif
