/* What the coder knows before it codes: scan orders, contexts and their first probabilities.
 *
 * The coefficients of a block are coded in order of u + v + w, ties in order of place. A
 * coefficient's context is made of
 *  - its level: the scattered sum of the magnitudes m (cut at 2000) of those coefficients coded
 *    before it that are near: a coefficient at (u, v, w) adds 2 m to its neighbours at distance 1
 *    along an axis and m to those at (2, 0, 0), (1, 1, 0) and the like; the DC adds at most 2 m,
 * and the sum is cut into 22 classes;
 *  - its band: six classes of u + v + w relative to B, times how many of u, v, w are 0 (0, 1, 2).
 */
#ifndef CVOL_CODEC_BLOCK_MODEL_H
#define CVOL_CODEC_BLOCK_MODEL_H

#include <stdint.h>

#include "codec/range_coder.h"

enum {
    CVOL_BANDS = 18,
    CVOL_LEVELS = 22,
    CVOL_LEVEL_TABLE = 1024,
    CVOL_PREFIXES = 24,
    CVOL_LAST_CONTEXTS = 17,
    CVOL_SCATTER_LIMIT = 2000,
    CVOL_BLOCK_SAMPLES_MAX = 32 * 32 * 32,
    CVOL_SCATTER_MAX = 34 * 34 * 34
};

/* One place of a scan order. */
typedef struct cvol_scan_entry {
    uint16_t place;   /* u + B v + B^2 w */
    uint16_t scatter; /* the same with sides of B + 2, so that scattering needs no bounds */
    uint16_t band;
} cvol_scan_entry;

typedef struct cvol_scan {
    int block, count, block_log2;
    const cvol_scan_entry *entries; /* count = B^3 of them */
    const uint16_t *index_of_place; /* the inverse */
    const uint8_t *level;           /* class of a scattered sum below CVOL_LEVEL_TABLE */
} cvol_scan;

/* The scan of B = 8, 16 or 32; static, read-only after the first call. */
const cvol_scan *cvol_scan_of(int block);

/* The probabilities of all contexts (see block_code.c for their use). Every one is of the same
 * type, so that the model is also an array. */
typedef struct cvol_block_model {
    cvol_probability zero[CVOL_BANDS][CVOL_LEVELS]; /* is it 0 or more? */
    cvol_probability one[CVOL_BANDS][CVOL_LEVELS];  /* 1 or more? */
    cvol_probability two[3][CVOL_LEVELS];           /* 2 or more? */
    cvol_probability rest[CVOL_LEVELS][CVOL_PREFIXES];
    cvol_probability rest_second[CVOL_PREFIXES];
    cvol_probability any[16]; /* anything but the DC? by the neighbour blocks that have */
    cvol_probability last_bits[CVOL_LAST_CONTEXTS][16];
    cvol_probability last_more[16][4];
    cvol_probability dc_zero[16];
    cvol_probability dc_rest[4][CVOL_PREFIXES];
    cvol_probability dc_second[CVOL_PREFIXES];
} cvol_block_model;

enum { CVOL_MODEL_SIZE = sizeof(cvol_block_model) / sizeof(cvol_probability) };

/* First probabilities of 0 in units of 2^-16, for B = 8, 16 and 32. */
extern const uint16_t cvol_block_defaults[3][CVOL_MODEL_SIZE];

/* The state at the start of a group. */
void cvol_block_model_start(cvol_block_model *model, int block);

#endif
