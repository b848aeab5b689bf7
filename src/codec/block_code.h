/* Coding of one block's quantised coefficients, within a group of blocks.
 *
 * A block is coded as: the difference of its DC to the mean of its left, upper and front
 * neighbours in the group; whether it has anything else; the index of the last non-zero
 * coefficient in scan order; then, up to there, each coefficient as zero / one / two / more, with
 * the rest in Exp-Golomb form (Teuhola 1978), all by the adaptive range coder; signs uncoded.
 * Contexts as in block_model.h. doc/format.md has every detail.
 */
#ifndef CVOL_CODEC_BLOCK_CODE_H
#define CVOL_CODEC_BLOCK_CODE_H

#include <stddef.h>
#include <stdint.h>

#include "codec/block_model.h"
#include "codec/range_coder.h"

/* A group has 128 / B blocks an axis, 16^3 at most. */
enum { CVOL_GROUP_SIDE = 128, CVOL_GROUP_BLOCKS_MAX = 16 * 16 * 16 };

/* The state of a group's coding, for either direction. About 0.5 MB. */
typedef struct cvol_block_coder {
    cvol_block_model model;
    const cvol_scan *scan;
    size_t count[3];                             /* blocks of the group along each axis */
    int32_t dc[CVOL_GROUP_BLOCKS_MAX];           /* of the blocks coded so far */
    uint8_t last_length[CVOL_GROUP_BLOCKS_MAX];  /* bits of their last index */
    uint16_t scatter[CVOL_SCATTER_MAX];          /* all zero between blocks */
    int32_t values[CVOL_BLOCK_SAMPLES_MAX];      /* decoder: by place, zero between blocks */
    uint64_t found[CVOL_BLOCK_SAMPLES_MAX / 64]; /* decoder: which places are not zero */
} cvol_block_coder;

/* Starts a group of count[] blocks of side B. */
void cvol_block_coder_start(cvol_block_coder *coder, int block, const size_t count[3]);

/* What the coded neighbours of a block tell about it. */
typedef struct cvol_block_context {
    int any, dc, last;  /* contexts of those decisions */
    int64_t prediction; /* of the DC */
} cvol_block_context;
cvol_block_context cvol_block_context_of(const cvol_block_coder *coder, size_t index);

/* Codes block `index` of the group: values in scan order, all of magnitude at most
 * CVOL_VALUE_LIMIT; those from `used` >= 1 on are zero. */
void cvol_block_encode(cvol_block_coder *coder, cvol_range_encoder *stream, size_t index,
                       const int32_t *values, int used);

/* What a decoded block is. */
typedef struct cvol_decoded_block {
    uint32_t words, terms; /* words written, and terms in them */
    uint64_t sum;          /* of the magnitudes */
} cvol_decoded_block;

/* Decodes block `index` of the group and writes its terms (array/array.h) to `words`, which has
 * room for 2 B^3. The result is 1, or 0 if what the stream says cannot be. */
int cvol_block_decode(cvol_block_coder *coder, cvol_range_decoder *stream, size_t index,
                      uint32_t *words, cvol_decoded_block *out);

#endif
