/* The small coder of a brick (format.md, section 21): contexts from everywhere in the brick,
 * slower. */
#ifndef CVOL_CODEC_NEURAL_NEURAL_CODE_H
#define CVOL_CODEC_NEURAL_NEURAL_CODE_H

#include "base/bytes.h"
#include "codec/quantize/brick_box.h"
#include "codec/quantize/context.h"

typedef struct cvol_small_brick cvol_small_brick;

/* NULL when memory is short. */
cvol_small_brick *cvol_small_create(void);
void cvol_small_free(cvol_small_brick *brick);

/* Begins a brick of `box` of an array. */
void cvol_small_start(cvol_small_brick *brick, const cvol_array *array, const cvol_brick_box *box);
/* A cell's split and its parts, in order; scan NULL: a part that nobody sees. Values in scan order
 * as for cvol_part_encode. Where they are in the brick: all of the part's have room there. */
void cvol_small_put_split(cvol_small_brick *brick, const size_t place[3], uint16_t split);
int cvol_small_put_part(cvol_small_brick *brick, const int at[3], int size_class,
                        const cvol_scan *scan, const int32_t *values, int used);
/* Codes all; 0 when memory is short. context: made for the brick, its notes are taken anew. */
int cvol_small_finish(cvol_small_brick *brick, cvol_bytes shells[CVOL_SHELLS],
                      cvol_brick_context *context);

/* Decodes `count` shells. CVOL_OK or CVOL_ERROR_CORRUPT. */
int cvol_small_decode(cvol_small_brick *brick, cvol_brick_context *context,
                      const cvol_span shells[CVOL_SHELLS], int count);
/* How a cell was split, and its values by place, as a file codes them. */
uint16_t cvol_small_cell(const cvol_small_brick *brick, const size_t place[3],
                         int32_t values[CVOL_CELL_SAMPLES], uint64_t found[CVOL_CELL_SAMPLES / 64]);

#endif
