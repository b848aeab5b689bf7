/* Coding of one brick: a box of 64^3 samples, or of what the array's `brick` says, whose cells are
 * coded together, and apart from all other bricks.
 *
 * Bricks are numbered x fastest, and so are the blocks in a brick (of 64^3: 4^3 cells of 16, 8^3
 * blocks of 8, 2^3 of 32; fewer at the volume's end). A brick's coefficients are coded in four
 * *subbands*, from coarse to fine: of a part of side M, subband s has the coefficients with all of
 * u, v, w below max(1, M 2^(s - 3)) that no earlier subband has. Each subband is a string of bytes
 * of its own (token_stream.h), maybe empty; the first s subbands decode without the others.
 */
#ifndef CVOL_CODEC_BRICK_BRICK_CODE_H
#define CVOL_CODEC_BRICK_BRICK_CODE_H

#include "array/core/array.h"
#include "base/bytes.h"
#include "codec/entropy/token_tables.h"
#include "codec/quantize/brick_box.h"

/* One thread's memory for coding bricks in either direction. */
typedef struct cvol_brick_coder cvol_brick_coder;
/* The tables must outlive the coder. NULL when memory is short. */
cvol_brick_coder *cvol_brick_coder_create(const cvol_token_tables *tables);
void cvol_brick_coder_free(cvol_brick_coder *coder);

/* The order of a cell's parts is that of cvol_cell_list_sub_blocks; before them, of cells of 16,
 * comes the token of the split: 0 none, 1 into octants of 8, 2 (followed by a token for octants 0
 * .. 3 and one for 4 .. 7, lowest bit first) octants of which some are split, 3 all into fours. */

/* Whether the terms of a brick are what the array says: what trellis quantization gives
 * (trellis_states.h), and what ends give (true_length.h). */
int cvol_brick_fits(cvol_brick_coder *coder, const cvol_array *array, size_t brick);
/* Encodes the terms of one brick of an array, of a dependent one as indices; the bytes replace
 * those of subbands[]. 1, or 0 when memory is short. */
int cvol_brick_encode(cvol_brick_coder *coder, cvol_bytes subbands[CVOL_SUBBANDS],
                      const cvol_array *array, size_t brick);

/* Adds what the last brick was encoded in to the counts. */
void cvol_brick_coder_count(const cvol_brick_coder *coder, cvol_token_counts *counts);

/* What a brick decoded to. */
typedef struct cvol_brick_terms {
    const uint32_t *words; /* of all its blocks in order, the coder's until its next use */
    size_t word_count, terms;
} cvol_brick_terms;

/* Decodes the first `count` subbands of a brick, and sets `words` (how many) and `split` of its
 * blocks in the array's table. The array has its step already: the sum over a block of its terms'
 * magnitudes times step is within float. CVOL_OK, CVOL_ERROR_CORRUPT or CVOL_ERROR_MEMORY, without
 * a message. */
int cvol_brick_decode(cvol_brick_coder *coder, cvol_brick_terms *out, cvol_array *array,
                      size_t brick, const cvol_span subbands[CVOL_SUBBANDS], int count);

#endif
