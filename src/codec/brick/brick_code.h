/* Coding of one brick: a box of 64^3 samples, or of the size in the array's `brick`. Its cells are
 * coded together, independently of all other bricks.
 *
 * Bricks are numbered x fastest, and so are the blocks in a brick (in 64^3: 4^3 cells of 16, 8^3
 * blocks of 8, 2^3 of 32; fewer at the volume's end). A brick's coefficients are coded in four
 * *subbands*, from coarse to fine: for a sub-block of side M, subband s has the coefficients with
 * all of u, v, w below max(1, M 2^(s - 3)) that no earlier subband has. Each subband is a separate
 * string of bytes (token_stream.h), which may be empty; the first s subbands decode without the
 * others. */
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

/* The order of a cell's sub-blocks is the order of cvol_cell_list_sub_blocks. In cells of 16, the
 * token of the split precedes them: 0 none, 1 into octants of 8, 2 (followed by a token for octants
 * 0 .. 3 and one for 4 .. 7, lowest bit first) into octants, some of which are split, 3 all into
 * fours. */

/* 1 if the brick's terms are possible results of the array's coding: of trellis quantization
 * (trellis_states.h) and of true length (true_length.h); 0 if not; CVOL_ERROR_MEMORY, which is
 * negative, when memory is short. */
int cvol_brick_fits(cvol_brick_coder *coder, const cvol_array *array, size_t brick);
/* Encodes the terms of one brick of an array, as indices if it has trellis quantization; the bytes
 * replace the content of subbands[]. Returns 1, or 0 when memory is short. */
int cvol_brick_encode(cvol_brick_coder *coder, cvol_bytes subbands[CVOL_SUBBANDS],
                      const cvol_array *array, size_t brick);

/* Adds the last encoded brick's tokens to the counts. */
void cvol_brick_coder_count(const cvol_brick_coder *coder, cvol_token_counts *counts);

/* The result of decoding a brick. */
typedef struct cvol_brick_terms {
    const uint32_t *words; /* of all its blocks in order; owned by the coder, valid until its
                              next use */
    size_t word_count, terms;
} cvol_brick_terms;

/* Decodes the first `count` subbands of a brick, and sets `words` (their number) and `split` of its
 * blocks in the array's table. The array must have its step: the sum of a block's term magnitudes
 * times step must fit into float. Returns CVOL_OK, CVOL_ERROR_CORRUPT or CVOL_ERROR_MEMORY, without
 * a message. */
int cvol_brick_decode(cvol_brick_coder *coder, cvol_brick_terms *out, cvol_array *array,
                      size_t brick, const cvol_span subbands[CVOL_SUBBANDS], int count);

#endif
