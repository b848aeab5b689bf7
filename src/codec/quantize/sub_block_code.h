/* Coding of one part's quantized coefficients.
 *
 * Tokens of a part, in order; subband 0's stream has the first three.
 *  1. The difference of its DC to its prediction: a number (below) and, if it is not 0, a raw bit
 *     for its sign (1: negative).
 *  2. The bit length L of the index of its last coefficient that is not 0, in scan order; 0 if only
 *     the DC is left.
 *  3. For each subband that has indices up to it, in that subband's stream: in the last one first
 * the index' bits behind the leading 1: two, or one if L = 2, as a token, the others raw. Then all
 *     coefficients of the subband, as far as the last: a magnitude, and if it is not 0 a raw sign.
 *
 * Numbers: a token below 4 is the number; L + 1 says that it has L >= 3 bits, those behind the
 * first are raw; 15 that L > 13, and five raw bits say L. Magnitudes m, at a level whose shift is
 * k: the token is m >> k, and k raw bits follow, the low ones of m. Token 15: (m >> k) - 15 = r
 * follows first: the bit length of r + 1, less one, as a token of the escape row (15: four raw bits
 * say by how much it is more), and as many raw bits of r + 1. Of the last coefficient m - 1 is
 * coded.
 */
#ifndef CVOL_CODEC_QUANTIZE_SUB_BLOCK_CODE_H
#define CVOL_CODEC_QUANTIZE_SUB_BLOCK_CODE_H

#include "codec/entropy/token_stream.h"
#include "codec/quantize/brick_box.h"
#include "codec/quantize/context.h"

/* The low bits of a magnitude that are raw, by level. */
extern const uint8_t cvol_level_shift[CVOL_LEVELS];
extern const uint8_t cvol_fine_level_shift[CVOL_FINE_LEVELS];

/* How magnitudes are coded at one place: what tables and how many raw bits. */
typedef struct cvol_place_code {
    int row, escape_row, shift;
} cvol_place_code;

/* Of a coefficient, or of the last one, after neighbours of this scattered sum. dependent: whether
 * indices are coded; odd: whether their values are odd. */
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

/* The bit length of a difference's number, and so on: what a number's token is. */
CVOL_INLINE uint32_t cvol_number_token(uint64_t number)
{
    if (number < 4)
        return (uint32_t)number;
    const int length = 64 - __builtin_clzll(number);
    return length > 13 ? 15 : (uint32_t)length + 1;
}

/* Codes a part: values in scan order, the last of values[0 .. used) is not 0 unless used = 1.
 * scatter: all zero, and so again after it. */
void cvol_sub_block_encode(cvol_token_writer streams[CVOL_SUBBANDS], const cvol_scan *scan,
                           const cvol_sub_block_context *context, const int32_t *indices, int used,
                           int trellis, uint16_t *scatter);

/* Where a decoded part's values go. */
typedef struct cvol_sub_block_target {
    int32_t *values; /* by place */
    uint64_t *found; /* a bit for every place whose value is not 0 */
    int first;       /* place of the part's frequency 0 */
    int in_cell;     /* whether places are those of a cell's part */
    int trellis;     /* whether what is coded are indices */
} cvol_sub_block_target;

/* Decodes the first `subbands` subbands of a part. *dc and *length are what the brick's context
 * notes. 0 if what the streams say cannot be. */
int cvol_sub_block_decode(cvol_token_reader streams[CVOL_SUBBANDS], int subbands,
                          const cvol_scan *scan, const cvol_sub_block_context *context,
                          const cvol_sub_block_target *target, int32_t *dc, int *length,
                          uint16_t *scatter);

#endif
