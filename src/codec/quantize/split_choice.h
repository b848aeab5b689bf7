/* Chooses a cell's split and values: the ones with the least error plus lambda times bits (Sullivan
 * and Baker 1994, from the leaves of the octree up). */
#ifndef CVOL_CODEC_QUANTIZE_SPLIT_CHOICE_H
#define CVOL_CODEC_QUANTIZE_SPLIT_CHOICE_H

#include "codec/quantize/rd_choice.h"
#include "transform/cell.h"

/* Ways to choose splits. */
typedef enum cvol_split_choice {
    CVOL_SPLIT_BEST,    /* by least cost */
    CVOL_SPLIT_FAST,    /* by weight alone (split_fast.h) */
    CVOL_SPLIT_NEVER,   /* whole cells */
    CVOL_SPLIT_OCTANTS, /* DCTs of 8 */
    CVOL_SPLIT_FOURS    /* DCTs of 4 */
} cvol_split_choice;

/* For the neural coder (neural_code.h): the highest relative cost at which a whole cell, or an
 * unsplit octant, wins over its sub-blocks; the chooser then tries more splits. 0: another
 * coder. */
typedef struct cvol_split_bias {
    float cell, octant;
} cvol_split_bias;

typedef struct cvol_chooser_options {
    double step;
    cvol_split_choice split;
    int plain;   /* the nearest values */
    int trellis; /* indices (trellis_states.h); the step is half the distance between values of
                    one set */
    cvol_split_bias split_bias;
} cvol_chooser_options;

/* The result for a cell. */
typedef struct cvol_cell_choice {
    uint16_t split;
    int parts;
    float error;                          /* squared, in steps squared; includes padding */
    int32_t *values[CVOL_SUB_BLOCKS_MAX]; /* of each sub-block, in scan order; indices with
                                             trellis */
    int used[CVOL_SUB_BLOCKS_MAX];        /* 0: a value exceeds the limit */
    /* With trellis: the unquantized coefficients, divided by twice the step. */
    const float *scaled[CVOL_SUB_BLOCKS_MAX];
} cvol_cell_choice;

/* One thread's memory. */
typedef struct cvol_cell_chooser cvol_cell_chooser;
cvol_cell_chooser *cvol_cell_chooser_create(void);
void cvol_cell_chooser_free(cvol_cell_chooser *chooser);

/* Chooses for a cell's samples (16^3 floats, aligned) at `place` within the brick, and records its
 * sub-blocks in the brick's context. The first inside[] samples along each axis belong to the
 * volume. The result holds until the chooser's next use. */
void cvol_cell_choose(cvol_cell_chooser *chooser, cvol_cell_choice *out, const float *samples,
                      const int inside[3], cvol_brick_context *brick, const size_t place[3],
                      const cvol_token_costs *costs, const cvol_chooser_options *options);

#endif
