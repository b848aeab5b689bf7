/* Coding of one sub-block's quantized coefficients.
 *
 * Tokens of a sub-block, in order; the stream of subband 0 has the first three.
 * 1. The difference of its DC to its prediction: a number (below) and, if it is not 0, a raw bit
 * for its sign (1: negative).
 * 2. The bit length L of the index of its last nonzero coefficient, in scan order; 0 if only the DC
 * is left.
 * 3. For each subband that has indices up to it, in that subband's stream: in the last one first
 * the index's bits after the leading 1: two, or one if L = 2, as a token, the others raw. Then all
 * coefficients of the subband, up to the last: a magnitude, and if it is not 0 a raw sign.
 *
 * Numbers: a token below 4 is the number; L + 1 means a number of L >= 3 bits, whose bits after the
 * first follow, raw; 15 means L > 13, and five raw bits give L. Magnitudes m, at a level with shift
 * k: the token is m >> k, and the k low bits of m follow, raw. Token 15: (m >> k) - 15 = r follows
 * first: the bit length of r + 1, minus one, as a token of the escape row (15: four raw bits
 * follow, the excess), and the bits of r + 1 after the first, raw. The last coefficient is coded as
 * m - 1. */
#ifndef CVOL_CODEC_QUANTIZE_SUB_BLOCK_CODE_H
#define CVOL_CODEC_QUANTIZE_SUB_BLOCK_CODE_H

#include "codec/entropy/token_stream.h"
#include "codec/quantize/brick_box.h"
#include "codec/quantize/context.h"

/* The number of raw low bits of a magnitude, by level. */
extern const uint8_t cvol_level_shift[CVOL_LEVELS];
extern const uint8_t cvol_fine_level_shift[CVOL_FINE_LEVELS];

/* The coding of magnitudes at one place: table rows and number of raw bits. */
typedef struct cvol_place_code {
    int row, escape_row, shift;
} cvol_place_code;

/* The code of a coefficient, or of the last one, after neighbours with this scattered sum. trellis:
 * it codes indices; odd: their values are odd. */
CVOL_INLINE cvol_place_code cvol_value_code(int size_class, int band, uint32_t sum, int trellis,
                                            int odd)
{
    if (!trellis) {
        const int level = cvol_level_of(sum);
        return (cvol_place_code){CVOL_ROW_VALUE + (size_class * CVOL_BANDS + band) * CVOL_LEVELS +
                                     level,
                                 CVOL_ROW_ESCAPE + level, cvol_level_shift[level]};
    }
    const int level = cvol_fine_level_of(sum);
    return (cvol_place_code){
        CVOL_ROW_INDEX +
            ((odd * CVOL_INDEX_SIZES + size_class) * CVOL_BANDS + band) * CVOL_FINE_LEVELS + level,
        CVOL_ROW_INDEX_ESCAPE + level, cvol_fine_level_shift[level]};
}
CVOL_INLINE cvol_place_code cvol_last_code(int size_class, uint32_t sum, int trellis, int odd)
{
    if (!trellis) {
        const int level = cvol_level_of(sum);
        return (cvol_place_code){CVOL_ROW_LAST + size_class * CVOL_LEVELS + level,
                                 CVOL_ROW_ESCAPE + level, cvol_level_shift[level]};
    }
    const int level = cvol_fine_level_of(sum);
    return (cvol_place_code){CVOL_ROW_LAST_INDEX +
                                 (odd * CVOL_INDEX_SIZES + size_class) * CVOL_FINE_LEVELS + level,
                             CVOL_ROW_INDEX_ESCAPE + level, cvol_fine_level_shift[level]};
}
CVOL_INLINE int cvol_more_row(int size_class, int length)
{
    return CVOL_ROW_MORE + size_class * CVOL_LENGTHS + length;
}

/* The token of a number. */
CVOL_INLINE uint32_t cvol_number_token(uint64_t number)
{
    if (number < 4)
        return (uint32_t)number;
    const int length = 64 - __builtin_clzll(number);
    return length > 13 ? 15 : (uint32_t)length + 1;
}

/* Codes a sub-block: values in scan order; the last of indices[0 .. used) is not 0 unless used = 1.
 * scatter: zero on entry and on return. */
void cvol_sub_block_encode(cvol_token_writer streams[CVOL_SUBBANDS], const cvol_scan *scan,
                           const cvol_sub_block_context *context, const int32_t *indices, int used,
                           int trellis, uint16_t *scatter);

/* The destination of a decoded sub-block's values. */
typedef struct cvol_sub_block_target {
    int32_t *values; /* by place */
    uint64_t *found; /* a bit for every place with a nonzero value */
    int first;       /* place of the sub-block's frequency 0 */
    int in_cell;     /* places are in a cell, not in the sub-block */
    int trellis;     /* the stream codes indices */
} cvol_sub_block_target;

/* Decodes the first `subbands` subbands of a sub-block. *dc and *length are for the brick's
 * context. Returns 0 if the streams are invalid. */
int cvol_sub_block_decode(cvol_token_reader streams[CVOL_SUBBANDS], int subbands,
                          const cvol_scan *scan, const cvol_sub_block_context *context,
                          const cvol_sub_block_target *target, int32_t *dc, int *length,
                          uint16_t *scatter);

#endif
