/* The members of a brick coder, for the modules that choose its input. */
#ifndef CVOL_CODEC_BRICK_BRICK_INTERNAL_H
#define CVOL_CODEC_BRICK_BRICK_INTERNAL_H

#include "codec/neural/neural_choice.h"
#include "codec/neural/neural_code.h"
#include "codec/quantize/brick_box.h"
#include "codec/quantize/rd_cost.h"
#include "codec/quantize/sub_block_code.h"
#include "transform/cell.h"

typedef struct cvol_brick_coder cvol_brick_coder;
struct cvol_brick_coder {
    const cvol_token_tables *tables;
    cvol_token_writer writers[CVOL_SUBBANDS];
    cvol_brick_context context;
    uint32_t *words; /* decoder: the terms so far */
    size_t word_count, word_capacity;
    int32_t scanned[CVOL_SUB_BLOCK_SAMPLES_MAX];     /* encoder: a sub-block's values in scan
                                                        order */
    int32_t values[CVOL_SUB_BLOCK_SAMPLES_MAX];      /* of a block, by place; zero between blocks */
    uint64_t found[CVOL_SUB_BLOCK_SAMPLES_MAX / 64]; /* places that are not zero */
    uint16_t scatter[CVOL_SCATTER_MAX];              /* zero between sub-blocks */
    cvol_neural_brick *neural;           /* for arrays of the neural coder; NULL before the first */
    cvol_neural_chooser *neural_chooser; /* for the same arrays */
    int is_neural;                       /* the current brick uses the neural coder */
    int last_values;                     /* of it: the position of the last sub-block's values */
};

/* Starts all streams of a brick of an array; returns 0 when memory is short. */
int cvol_brick_start(cvol_brick_coder *coder, const cvol_array *array, const cvol_brick_box *box);
/* Codes a sub-block: values in scan order. */
void cvol_brick_put_sub_block(cvol_brick_coder *coder, const int at[3], const cvol_scan *scan,
                              const int32_t *values, int used, int trellis);
/* Keeps the last sub-block's coefficients, divided by twice the step, in scan order.
 * cvol_brick_choose_again needs them for all sub-blocks. */
void cvol_brick_keep_scaled(cvol_brick_coder *coder, const float *scaled, int count);
/* Chooses all values again, because values change the cost of later ones (neural_choice.h). Returns
 * the increase of the squared error, in steps squared. */
double cvol_brick_choose_again(cvol_brick_coder *coder, const cvol_token_costs *costs);
/* Records a sub-block that lies in padding. */
void cvol_brick_pass_sub_block(cvol_brick_coder *coder, const int at[3], int size_class);
/* Codes the split of the cell at `place`, and records it. */
void cvol_brick_put_split(cvol_brick_coder *coder, const size_t place[3], uint16_t split);
/* Ends all streams. Returns 1, or 0 when memory ran out. */
int cvol_brick_finish(cvol_brick_coder *coder, cvol_bytes subbands[CVOL_SUBBANDS]);

#endif
