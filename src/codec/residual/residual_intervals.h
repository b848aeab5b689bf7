/* Cells of the real line, for corrections of float types that leave no error (residual_code.h). */
#ifndef CVOL_CODEC_RESIDUAL_RESIDUAL_INTERVALS_H
#define CVOL_CODEC_RESIDUAL_RESIDUAL_INTERVALS_H

#include <math.h>

#include "codec/residual/residual_code.h"

/* A float type: its digits, its smallest last place, its exponent's bias. */
typedef struct cvol_float_kind {
    int digits, lowest, bias;
} cvol_float_kind;

static inline cvol_float_kind cvol_float_kind_of(cvol_type type)
{
    return type == CVOL_FLOAT32 ? (cvol_float_kind){24, -149, 127}
                                : (cvol_float_kind){53, -1074, 1023};
}

/* 2^e, -1022 <= e <= 1023. */
CVOL_INLINE double cvol_power_of_two(int e)
{
    const uint64_t bits = (uint64_t)(e + 1023) << 52;
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* floor(log2 |value|) of a normal number. */
CVOL_INLINE int cvol_exponent_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return (int)(bits >> 52 & 2047) - 1023;
}

/* s: how much wider than 2^unit a base's cells are. */
CVOL_INLINE int cvol_cell_widening(const cvol_correction_rule *rule, cvol_float_kind kind,
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
CVOL_INLINE int cvol_cell_last(const cvol_correction_rule *rule, cvol_float_kind kind, uint64_t a,
                               int t)
{
    int last = 63 - __builtin_clzll(a) + t - (kind.digits - 1);
    last = last < kind.lowest ? kind.lowest : last;
    return last < rule->grain ? rule->grain : last;
}

/* The rest of a value in cell a of width 2^t (a = 0: a cell beside 0). */
void cvol_cell_put_rest(cvol_token_writer *out, const cvol_correction_rule *rule, double value,
                        uint64_t a, int t);
/* The magnitude of the value; negative if there is none. */
double cvol_cell_take_rest(cvol_token_reader *in, const cvol_correction_rule *rule, uint64_t a,
                           int t);

#endif
