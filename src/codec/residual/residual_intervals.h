/* Cells of the real line, for corrections of float types that leave no error (residual_code.h). */
#ifndef CVOL_CODEC_RESIDUAL_RESIDUAL_INTERVALS_H
#define CVOL_CODEC_RESIDUAL_RESIDUAL_INTERVALS_H

#include <math.h>
#include <stdint.h>

#include "base/vector.h"
#include "codec/entropy/token_stream.h"
#include "codec/residual/float_bits.h"
#include "codec/residual/residual_rule.h"

/* s: how much wider than 2^unit a base's cells are. */
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

/* The exponent of the last bit that is told of values in cell a >= 1 (of either sign). */
CVOL_INLINE int cvol_cell_last(const cvol_residual_rule *rule, cvol_float_kind kind, uint64_t a,
                               int t)
{
    int last = 63 - __builtin_clzll(a) + t - (kind.digits - 1);
    last = last < kind.lowest ? kind.lowest : last;
    return last < rule->grain ? rule->grain : last;
}

/* The rest of a value in cell a of width 2^t (a = 0: a cell beside 0). */
void cvol_cell_put_rest(cvol_token_writer *out, const cvol_residual_rule *rule, double value,
                        uint64_t a, int t);
/* The magnitude of the value; negative if there is none. */
double cvol_cell_take_rest(cvol_token_reader *in, const cvol_residual_rule *rule, uint64_t a,
                           int t);

#endif
