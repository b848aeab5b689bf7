/* Rules of residuals: chooses quantum and unit for a bound, and validates rules. */
#include "codec/residual/residual_rule.h"

#include <float.h>
#include <limits.h>
#include <math.h>

#include "codec/residual/float_bits.h"

/* The most bits of an interval's number, so that doubles count intervals with room to spare. */
enum { CELL_BITS = 46, CELL_BITS_MAX = 48 };

static int clamp(int value, int lo, int hi)
{
    return value < lo ? lo : value > hi ? hi : value;
}

/* The exponent of a number's lowest set bit; INT_MAX for 0. */
static int last_bit(double value)
{
    if (value == 0)
        return INT_MAX;
    int exponent;
    const double fraction = frexp(fabs(value), &exponent);
    const uint64_t digits = (uint64_t)ldexp(fraction, 53);
    return exponent - 53 + __builtin_ctzll(digits);
}

void cvol_residual_scan(int *grain, double *largest, cvol_type type, const void *samples,
                        const uint8_t *which, size_t count)
{
    if (cvol_type_is_integer(type))
        return;
    for (size_t i = 0; i < count; i++) {
        if (which && which[i])
            continue;
        const double value = type == CVOL_FLOAT32 ? (double)((const float *)samples)[i]
                                                  : ((const double *)samples)[i];
        if (!isfinite(value)) /* no residual represents it: it is masked, or rejected later */
            continue;
        const int last = last_bit(value);
        *grain = last < *grain ? last : *grain;
        *largest = fabs(value) > *largest ? fabs(value) : *largest;
    }
}

/* Intervals of exact residuals have a sixteenth of the step's width: k then resolves the base's
 * error, and the raw bits below are noise. */
static void choose_cells(cvol_residual_rule *rule, double step, int grain, double largest)
{
    const int is_double = rule->type == CVOL_FLOAT64;
    const cvol_float_kind kind = cvol_float_kind_of(rule->type);
    int unit = cvol_exponent_of(step) - 4;
    rule->exact = 1;
    rule->quantum = 0;
    if (grain != INT_MAX && unit < grain)
        unit = grain;
    if (largest > 0 && unit < ilogb(largest) - CELL_BITS)
        unit = ilogb(largest) - CELL_BITS;
    rule->unit = clamp(unit, 1 - kind.bias, is_double ? 1000 : 120);
    rule->grain = clamp(grain, kind.lowest, rule->unit);
}

cvol_residual_rule cvol_residual_rule_for(cvol_type type, double bound, double step,
                                          double value_min, double value_max, int grain,
                                          double largest)
{
    cvol_residual_rule rule = {.type = type, .value_min = value_min, .value_max = value_max};
    if (cvol_type_is_integer(type)) {
        rule.exact = bound < 1;
        rule.quantum = 2 * floor(bound < 0x1p32 ? bound : 0x1p32) + 1;
        return rule;
    }
    /* Rounding to the type moves a sample by at most half of its last place, and computing it in
     * double by less than a double's last place. */
    const double place = largest * (type == CVOL_FLOAT32 ? (double)FLT_EPSILON : DBL_EPSILON);
    rule.quantum = 2 * bound * (1 - 0x1p-40) - place - 4 * largest * DBL_EPSILON;
    /* If a last place is too wide for that, half of the quantum suffices: a sum within half a
     * quantum of a sample rounds to this sample if places are wider, and otherwise to at most a
     * quantum from it. */
    if (bound > 0 && !(rule.quantum > bound))
        rule.quantum = bound * (1 - 0x1p-40) - 8 * largest * DBL_EPSILON;
    if (!(bound > 0 && rule.quantum > bound / 2) || (value_max - value_min) / rule.quantum > 0x1p48)
        choose_cells(&rule, step, grain, largest);
    return rule;
}

int cvol_residual_rule_needs_base(const cvol_residual_rule *rule)
{
    return rule->exact && !cvol_type_is_integer(rule->type);
}

int cvol_residual_rule_valid(const cvol_residual_rule *rule)
{
    if (!isfinite(rule->value_min) || !isfinite(rule->value_max) ||
        rule->value_min > rule->value_max)
        return 0;
    if (cvol_type_is_integer(rule->type))
        return rule->quantum >= 1 && rule->quantum < 0x1p34 && fmod(rule->quantum, 2) == 1;
    if (!rule->exact)
        return isfinite(rule->quantum) && rule->quantum > 0;
    const cvol_float_kind kind = cvol_float_kind_of(rule->type);
    const double largest = fmax(fabs(rule->value_min), fabs(rule->value_max));
    return rule->unit >= 1 - kind.bias && rule->unit <= (rule->type == CVOL_FLOAT64 ? 1000 : 120) &&
           rule->grain >= kind.lowest && rule->grain <= rule->unit &&
           (largest == 0 || rule->unit >= ilogb(largest) - CELL_BITS_MAX);
}
