/* Intervals of the real line, for exact residuals of float types (residual_code.h). Identifiers
 * call them cells. */
#ifndef CVOL_CODEC_RESIDUAL_RESIDUAL_INTERVALS_H
#define CVOL_CODEC_RESIDUAL_RESIDUAL_INTERVALS_H

#include <math.h>
#include <stdint.h>

#include "base/vector.h"
#include "codec/entropy/token_stream.h"
#include "codec/residual/float_bits.h"
#include "codec/residual/residual_rule.h"

/* s: log2 of the width of the base's intervals relative to 2^unit. */
CVOL_INLINE int cvol_cell_widening(const cvol_residual_rule *rule, cvol_float_kind kind,
                                   double base)
{
    const int last = cvol_exponent_of(base) - (kind.digits - 1);
    return base != 0 && last > rule->unit ? last - rule->unit : 0;
}

CVOL_INLINE int64_t cvol_cell_of(double value, double per_cell)
{
    const int64_t cell = (int64_t)(fabs(value) * per_cell);
    return signbit(value) ? -1 - cell : cell;
}

/* The exponent of the last coded bit of values in interval a >= 1 (of either sign). */
CVOL_INLINE int cvol_cell_last(const cvol_residual_rule *rule, cvol_float_kind kind, uint64_t a,
                               int t)
{
    int last = 63 - __builtin_clzll(a) + t - (kind.digits - 1);
    last = last < kind.lowest ? kind.lowest : last;
    return last < rule->grain ? rule->grain : last;
}

/* Writes the bits of a value within interval a of width 2^t (a = 0: an interval next to 0). */
void cvol_interval_put_offset(cvol_token_writer *out, const cvol_residual_rule *rule, double value,
                              uint64_t a, int t);
/* Reads the magnitude of the value; negative if the bits are invalid. */
double cvol_interval_take_offset(cvol_token_reader *in, const cvol_residual_rule *rule, uint64_t a,
                                 int t);

#endif
