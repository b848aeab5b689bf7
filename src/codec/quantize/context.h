/* Contexts of a sub-block from the brick's coded sub-blocks.
 *
 * A sub-block's neighbours cover the samples next to its first sample along -x, -y and -z, as far
 * as they lie in the same brick; they are coded before it. Their DC values, scaled to its size,
 * predict its DC; the bit lengths of their last indices predict its number of coefficients. */
#ifndef CVOL_CODEC_QUANTIZE_CONTEXT_H
#define CVOL_CODEC_QUANTIZE_CONTEXT_H

#include <stdint.h>

#include "array/core/array.h"
#include "codec/entropy/scan.h"
#include "codec/entropy/token_tables.h"
#include "codec/quantize/true_length.h"

/* A brick as a grid of 4^3 samples. */
enum { CVOL_BRICK_UNITS = 16, CVOL_BRICK_UNITS_ALL = 16 * 16 * 16, CVOL_BRICK_CELLS = 4 };

typedef struct cvol_brick_context {
    int64_t mean[CVOL_BRICK_UNITS_ALL];   /* DC value times a weight for its size: about the mean */
    uint8_t length[CVOL_BRICK_UNITS_ALL]; /* bit length of the last index, as for size class 3 */
    uint8_t split[CVOL_BRICK_CELLS * CVOL_BRICK_CELLS * CVOL_BRICK_CELLS]; /* token of each cell */
    int true_length; /* of the array (coding.h) */
    int inside[3];   /* with true length: samples of the volume from the brick's first one on */
    int32_t limit;   /* of values, with true length */
    cvol_true_length_scans scans;
} cvol_brick_context;

typedef struct cvol_sub_block_context {
    int64_t prediction; /* of the DC */
    int dc_row;         /* of the DC's difference */
    int around;         /* class of the neighbours' last indices */
} cvol_sub_block_context;

/* Begins a brick whose first block is `first` (of x, y, z). Returns 0 when memory is short. */
int cvol_brick_context_start(cvol_brick_context *brick, const cvol_array *array,
                             const size_t first[3]);
/* Samples of the volume in the cell at `place` within the brick; NULL if the cell is complete, or
 * the array does not use true length. */
const int *cvol_brick_cell_inside(int inside[3], const cvol_brick_context *brick,
                                  const size_t place[3]);
/* The scan of a sub-block; NULL if it lies in padding and is not coded. */
const cvol_scan *cvol_brick_scan(const cvol_brick_context *brick, const int at[3], int size_class);
/* The scan of any sub-block, by the axes along which it crosses the volume's end; *seen: 0 if it
 * lies in padding. */
const cvol_scan *cvol_brick_scan_of(const cvol_brick_context *brick, const int at[3],
                                    int size_class, int *seen);
/* Records a sub-block in padding; predicts its DC from its neighbours and returns it. */
int32_t cvol_sub_block_note_unseen(cvol_brick_context *brick, const int at[3], int size_class);

/* The context of the sub-block of this scan whose first sample is 4 at[] within the brick. */
cvol_sub_block_context cvol_sub_block_context_of(const cvol_brick_context *brick, const int at[3],
                                                 const cvol_scan *scan);
/* Records a sub-block: its DC value and the bit length of its last index (0: no other
 * coefficients). */
void cvol_sub_block_note(cvol_brick_context *brick, const int at[3], const cvol_scan *scan,
                         int32_t dc, int length);
/* The bit length to record for a sub-block with `used` coded values. */
static inline int cvol_sub_block_length(const cvol_scan *scan, int used)
{
    return used > 1 ? cvol_bit_length(scan->index[used - 1]) : 0;
}

/* The row of the split token of the cell at `cell` within the brick; cvol_split_note records the
 * token. */
int cvol_split_row(const cvol_brick_context *brick, const int cell[3]);
void cvol_split_note(cvol_brick_context *brick, const int cell[3], int token);

/* The row for the bit length of a sub-block's last index. */
static inline int cvol_length_row(const cvol_sub_block_context *context, int size_class,
                                  uint64_t dc_difference)
{
    const int dc = dc_difference == 0 ? 0 : dc_difference == 1 ? 1 : dc_difference < 4 ? 2 : 3;
    return CVOL_ROW_LENGTH + (size_class * CVOL_AROUND + context->around) * CVOL_DC_CLASSES + dc;
}

#endif
