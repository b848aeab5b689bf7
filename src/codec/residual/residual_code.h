/* Residual: it is added to a brick's exactly evaluated samples (array/block/exact.h), so that every
 * sample is within a bound of the original, or equal to it.
 *
 * Every sample that is not masked has a whole number k, in raster order, x fastest.
 *
 * Bounded: sample = base + quantum k, clamped to value_min .. value_max. For integer types the
 * quantum is 2 floor(E) + 1. For float types it is smaller than 2 E by the largest rounding error
 * of the type.
 *
 * Exact, integer types: the same with quantum 1.
 *
 * Exact, float types: the real line is divided into intervals ("cells") of width T = 2^t, t = unit
 * + s, s = max(0, exponent of base's last place - unit). A value v >= 0 is in interval floor(v /
 * T), a value with its sign set in interval -1 - floor(|v| / T). k is v's interval minus the
 * base's. Then follow, raw, the bits that select the value in the interval, from the interval's
 * last place, or `grain` if that is coarser, up: t - last place. In the two intervals next to 0 an
 * exponent comes first, as its distance below T's: a token below 14 is this distance minus one; 14
 * means zero; after 15 follow 11 raw bits, the excess over 15.
 *
 * k is coded as a magnitude and, if it is not 0, a raw sign (1: negative). The row of the magnitude
 * depends on its neighbours' magnitudes (in the brick; others count as 0, masked ones as their
 * expected magnitude, sum / 12):
 *     sum = 2 ((-1, 0, 0) + (0, -1, 0) + (0, 0, -1)) + (-1, -1, 0) + (1, -1, 0)
 *         + (-1, 0, -1) + (1, 0, -1) + (0, -1, -1) + (0, 1, -1),
 * in the first slice twice that. Magnitudes enter as |k| 2^s, at most 2^28 - 1, and the sum is
 * divided by 2^s. The sum gives a level: the count of 0 1 2 3 4 6 8 11 15 20 28 40 56 80 112 that
 * are less, up to a sum of 160; beyond it, with e its bit length minus one and h the bit after the
 * first, 2 + 2 e + h. Levels below 14 have shift 0, 14 and 15 have 1, others e - 5. The token is
 * the magnitude without its low `shift` bits, which follow, raw; 15 escapes larger values: r = that
 * - 14 >= 1 follows, first its bit length minus one as a token (15: six raw bits follow, the
 * excess), then its bits after the leading 1, raw. Levels from 24 on use the rows of 22 and 23. If
 * all k of a brick are 0 and no other bits are needed, its stream may be empty. */
#ifndef CVOL_CODEC_RESIDUAL_RESIDUAL_CODE_H
#define CVOL_CODEC_RESIDUAL_RESIDUAL_CODE_H

#include "codec/brick/brick_code.h"
#include "codec/entropy/token_stream.h"
#include "codec/residual/residual_rule.h"

/* One thread's memory for coding in either direction. NULL when memory is short. */
typedef struct cvol_residual_coder cvol_residual_coder;
cvol_residual_coder *cvol_residual_coder_create(void);
void cvol_residual_coder_free(cvol_residual_coder *coder);

/* A brick's size, its base in x-fastest order, and its masked samples. */
typedef struct cvol_residual_brick {
    size_t size[3];
    const double *base;
    const uint8_t *which; /* NULL: none */
} cvol_residual_brick;

/* Encodes a brick; the bytes replace the content of *out. counts: adds to them; may be NULL.
 * Returns CVOL_OK, CVOL_ERROR_MEMORY, or CVOL_ERROR_TARGET if a sample's error would exceed
 * `bound`. */
int cvol_residual_encode(cvol_residual_coder *coder, cvol_bytes *out,
                         const cvol_residual_rule *rule, double bound,
                         const cvol_token_tables *tables, const void *samples,
                         const cvol_residual_brick *brick, cvol_token_counts *counts);

/* Decodes a brick; does not change masked samples. Returns CVOL_OK or CVOL_ERROR_CORRUPT. */
int cvol_residual_decode(cvol_residual_coder *coder, void *samples, const cvol_residual_rule *rule,
                         const cvol_token_tables *tables, const cvol_residual_brick *brick,
                         cvol_span data);

#endif
