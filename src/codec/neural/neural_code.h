/* The neural coder of a brick (format.md, section 21): contexts from the whole brick; slower. */
#ifndef CVOL_CODEC_NEURAL_NEURAL_CODE_H
#define CVOL_CODEC_NEURAL_NEURAL_CODE_H

#include "base/bytes.h"
#include "codec/quantize/brick_box.h"
#include "codec/quantize/context.h"

typedef struct cvol_neural_brick cvol_neural_brick;

/* NULL when memory is short. */
cvol_neural_brick *cvol_neural_create(void);
void cvol_neural_free(cvol_neural_brick *brick);

/* Begins a brick of `box` of an array. */
void cvol_neural_start(cvol_neural_brick *brick, const cvol_array *array,
                       const cvol_brick_box *box);
/* Add a cell's split and its sub-blocks, in order; scan NULL: a sub-block in padding. Values in
 * scan order as for cvol_sub_block_encode. Returns the place of the values in the brick, which has
 * room for all values of the sub-block. */
void cvol_neural_put_split(cvol_neural_brick *brick, const size_t place[3], uint16_t split);
int cvol_neural_put_sub_block(cvol_neural_brick *brick, const int at[3], int size_class,
                              const cvol_scan *scan, const int32_t *values, int used);
/* Encodes the brick; returns 0 when memory is short. context: made for the brick; its records are
 * made again. */
int cvol_neural_finish(cvol_neural_brick *brick, cvol_bytes subbands[CVOL_SUBBANDS],
                       cvol_brick_context *context);

/* Decodes `count` subbands. CVOL_OK or CVOL_ERROR_CORRUPT. */
int cvol_neural_decode(cvol_neural_brick *brick, cvol_brick_context *context,
                       const cvol_span subbands[CVOL_SUBBANDS], int count);
/* A cell's split, and its values by place, as the file codes them. */
uint16_t cvol_neural_cell(const cvol_neural_brick *brick, const size_t place[3],
                          int32_t values[CVOL_CELL_SAMPLES],
                          uint64_t found[CVOL_CELL_SAMPLES / 64]);

#endif
