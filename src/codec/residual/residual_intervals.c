/* The bits that select a value within its interval. */
#include "codec/residual/residual_intervals.h"

enum { DEEP_ZERO = 14, DEEP_MORE = 15, DEEP_BITS = 11 };

static void put_bits(cvol_token_writer *out, uint64_t value, int count)
{
    if (count > 32) {
        cvol_raw_put(out, (uint32_t)value, 32);
        value >>= 32;
        count -= 32;
    }
    if (count > 0)
        cvol_raw_put(out, (uint32_t)value, count);
}

static uint64_t take_bits(cvol_token_reader *in, int count)
{
    uint64_t value = 0;
    int at = 0;
    if (count > 32) {
        value = cvol_raw_take(in, 32);
        at = 32;
    }
    if (count > at)
        value |= (uint64_t)cvol_raw_take(in, count - at) << at;
    return value;
}

/* The number of mantissa bits, at this exponent field, below the grain. */
static int unused_bits(const cvol_residual_rule *rule, cvol_float_kind kind, int field)
{
    const int last = (field ? field : 1) - kind.bias - (kind.digits - 1);
    const int unused = rule->grain - last;
    return unused < 0 ? 0 : unused < kind.digits - 1 ? unused : kind.digits - 1;
}

static void put_next_to_zero(cvol_token_writer *out, const cvol_residual_rule *rule,
                             cvol_float_kind kind, double value, int t)
{
    uint64_t bits;
    if (rule->type == CVOL_FLOAT32) {
        const float magnitude = (float)fabs(value);
        uint32_t word;
        memcpy(&word, &magnitude, sizeof word);
        bits = word;
    } else {
        const double magnitude = fabs(value);
        memcpy(&bits, &magnitude, sizeof bits);
    }
    if (!bits) {
        cvol_token_put(out, CVOL_ROW_RESIDUAL_DEEP, DEEP_ZERO);
        return;
    }
    const int field = (int)(bits >> (kind.digits - 1)), depth = t + kind.bias - field;
    cvol_token_put(out, CVOL_ROW_RESIDUAL_DEEP,
                   depth <= DEEP_ZERO ? (uint32_t)depth - 1 : DEEP_MORE);
    if (depth > DEEP_ZERO)
        cvol_raw_put(out, (uint32_t)depth - DEEP_MORE, DEEP_BITS);
    const int unused = unused_bits(rule, kind, field);
    put_bits(out, (bits & ((UINT64_C(1) << (kind.digits - 1)) - 1)) >> unused,
             kind.digits - 1 - unused);
}

static double take_next_to_zero(cvol_token_reader *in, const cvol_residual_rule *rule,
                                cvol_float_kind kind, int t)
{
    const uint32_t token = cvol_token_take(in, CVOL_ROW_RESIDUAL_DEEP);
    if (token == DEEP_ZERO)
        return 0;
    int depth = (int)token + 1;
    if (token == DEEP_MORE)
        depth = DEEP_MORE + (int)cvol_raw_take(in, DEEP_BITS);
    const int field = t + kind.bias - depth;
    if (field < 0)
        return -1;
    const int unused = unused_bits(rule, kind, field);
    const uint64_t mantissa = take_bits(in, kind.digits - 1 - unused) << unused;
    const uint64_t bits = (uint64_t)field << (kind.digits - 1) | mantissa;
    if (rule->type == CVOL_FLOAT32) {
        const uint32_t word = (uint32_t)bits;
        float value;
        memcpy(&value, &word, sizeof value);
        return (double)value;
    }
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

void cvol_interval_put_offset(cvol_token_writer *out, const cvol_residual_rule *rule, double value,
                              uint64_t a, int t)
{
    const cvol_float_kind kind = cvol_float_kind_of(rule->type);
    if (!a) {
        put_next_to_zero(out, rule, kind, value, t);
        return;
    }
    const int last = cvol_cell_last(rule, kind, a, t);
    if (t <= last)
        return;
    const double rest = fabs(value) - (double)a * cvol_power_of_two(t);
    put_bits(out, (uint64_t)ldexp(rest, -last), t - last);
}

double cvol_interval_take_offset(cvol_token_reader *in, const cvol_residual_rule *rule, uint64_t a,
                                 int t)
{
    const cvol_float_kind kind = cvol_float_kind_of(rule->type);
    if (!a)
        return take_next_to_zero(in, rule, kind, t);
    const int last = cvol_cell_last(rule, kind, a, t);
    double value = (double)a * cvol_power_of_two(t);
    if (t > last)
        value += ldexp((double)take_bits(in, t - last), last);
    return value;
}
