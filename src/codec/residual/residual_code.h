/* residual: what is added to the exactly evaluated samples (array/block/exact.h) of a brick, so
 * that none is further from the original than a bound, or none differs at all.
 *
 * Every sample that is not masked has a whole number k, in raster order, x fastest.
 *
 * Bounded:            sample = base + quantum k, clamped to value_min .. value_max. Integer types:
 *                     the quantum is 2 floor(E) + 1. Float types: it is smaller than 2 E by what
 *                     rounding to the type may cost.
 * Exact, integers:    the same with quantum 1.
 * Exact, float types: the line of reals is cut into cells of width T = 2^t, t = unit + s, s =
 * max(0, exponent of base's last place - unit). A value v >= 0 is in cell floor(v / T), one with
 * its sign set in cell -1 - floor(|v| / T). k is v's cell less that of the base. Then, raw, the
 * bits that say which value of the cell it is, from the cell's last place, or `grain` if that is
 * coarser, up: t - last place. In the two cells beside 0 an exponent comes first, by how much it is
 * less than T's: a token below 14 is one less than that; 14 says zero; after 15 come 11 raw bits
 * that say how much more than 15 it is.
 *
 * k is coded as a magnitude and, if it is not 0, a raw sign (1: negative). The magnitude's row is
 * chosen by its neighbours' magnitudes (of those in the brick; others count as 0; masked ones as
 * what they were expected to be, sum / 12):
 *
 *     sum = 2 ((-1, 0, 0) + (0, -1, 0) + (0, 0, -1)) + (-1, -1, 0) + (1, -1, 0)
 *         + (-1, 0, -1) + (1, 0, -1) + (0, -1, -1) + (0, 1, -1),    in the first sheet twice that.
 *
 * Magnitudes enter as |k| 2^s, at most 2^28 - 1, and the sum is divided by 2^s. Of the sum comes a
 * level: how many of 0 1 2 3 4 6 8 11 15 20 28 40 56 80 112 are less, up to a sum of 160; beyond,
 * with e its bit length less one and h the bit after the first, 2 + 2 e + h. Levels below 14 have
 * the shift 0, 14 and 15 have 1, others e - 5. The token is the magnitude without its low `shift`
 * bits, which follow, raw; 15 stands for more: r = that - 14 >= 1 follows, first its bit length
 * less one as a token (15: six raw bits say how much more), then its bits behind the leading 1,
 * raw. Rows of levels from 24 on are those of 22 and 23. If all k of a brick are 0 and nothing else
 * is to be said, its stream may be empty.
 */
#ifndef CVOL_CODEC_RESIDUAL_RESIDUAL_CODE_H
#define CVOL_CODEC_RESIDUAL_RESIDUAL_CODE_H

#include "codec/brick/brick_code.h"
#include "codec/entropy/token_stream.h"
#include "codec/residual/residual_rule.h"

/* One thread's memory for coding in either direction. NULL when memory is short. */
typedef struct cvol_residual_coder cvol_residual_coder;
cvol_residual_coder *cvol_residual_coder_create(void);
void cvol_residual_coder_free(cvol_residual_coder *coder);

/* A brick's samples, in the rule's type, x fastest; their base; which of them are masked. */
typedef struct cvol_residual_brick {
    size_t size[3];
    const double *base;
    const uint8_t *which; /* NULL: none */
} cvol_residual_brick;

/* Codes a brick; the bytes replace those of *out. counts: added to; may be NULL. CVOL_OK,
 * CVOL_ERROR_MEMORY, or CVOL_ERROR_TARGET where a sample would be further off than `bound`. */
int cvol_residual_encode(cvol_residual_coder *coder, cvol_bytes *out,
                         const cvol_residual_rule *rule, double bound,
                         const cvol_token_tables *tables, const void *samples,
                         const cvol_residual_brick *brick, cvol_token_counts *counts);

/* Decodes it; masked samples are left as they are. CVOL_OK or CVOL_ERROR_CORRUPT. */
int cvol_residual_decode(cvol_residual_coder *coder, void *samples, const cvol_residual_rule *rule,
                         const cvol_token_tables *tables, const cvol_residual_brick *brick,
                         cvol_span data);

#endif
