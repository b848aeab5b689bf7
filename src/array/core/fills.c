/* Fills: bit patterns of masked samples (fills.h). */
#include "array/core/fills.h"

#include <math.h>
#include <string.h>

#include "array/core/words.h"

int cvol_fills_add(cvol_fills *fills, uint64_t bits)
{
    for (int i = 0; i < fills->count; i++)
        if (fills->bits[i] == bits)
            return 1;
    if (fills->count == CVOL_FILLS_MAX)
        return 0;
    fills->bits[fills->count++] = bits;
    return 1;
}

void cvol_fills_unite(uint8_t number[CVOL_FILLS_MAX + 1], cvol_fills *fills,
                      const cvol_fills *other)
{
    number[0] = 0;
    for (int i = 0; i < other->count; i++) {
        number[1 + i] = 1;
        if (!cvol_fills_add(fills, other->bits[i]))
            continue;
        while (fills->bits[number[1 + i] - 1] != other->bits[i])
            number[1 + i]++;
    }
}

int cvol_fills_of_value(uint64_t *bits, cvol_type type, double value)
{
    *bits = 0;
    if (type == CVOL_FLOAT64) {
        memcpy(bits, &value, sizeof value);
        return 1;
    }
    if (type == CVOL_FLOAT32) {
        const float number = (float)value;
        uint32_t word;
        memcpy(&word, &number, sizeof word);
        *bits = word;
        return 1;
    }
    const int size = (int)cvol_type_size(type);
    const int is_signed = type == CVOL_INT8 || type == CVOL_INT16 || type == CVOL_INT32;
    const double span = ldexp(1, 8 * size), lo = is_signed ? -span / 2 : 0;
    const double nearest = floor(value + 0.5);
    if (nearest != value || !(nearest >= lo && nearest < lo + span))
        return 0;
    *bits = (uint64_t)(int64_t)nearest & ((UINT64_C(1) << 8 * size) - 1);
    return 1;
}

double cvol_fills_value(const cvol_fills *fills, int which, cvol_type type)
{
    const uint64_t bits = fills->bits[which];
    const int unused = 64 - 8 * (int)cvol_type_size(type);
    double value = 0;
    if (type == CVOL_FLOAT64) {
        memcpy(&value, &bits, sizeof value);
    } else if (type == CVOL_FLOAT32) {
        const uint32_t word = (uint32_t)bits;
        float number;
        memcpy(&number, &word, sizeof number);
        value = (double)number;
    } else if (type == CVOL_INT8 || type == CVOL_INT16 || type == CVOL_INT32) {
        value = (double)((int64_t)(bits << unused) >> unused);
    } else {
        value = (double)bits;
    }
    return value;
}

int cvol_fills_convert(cvol_fills *fills, cvol_type from, cvol_type to)
{
    double least, largest;
    cvol_type_get_range(&least, &largest, to);
    for (int i = 0; i < fills->count; i++) {
        double value = cvol_fills_value(fills, i, from);
        if (fills->background)
            value = fmin(fmax(value, least), largest);
        if (fills->background && cvol_type_is_integer(to))
            value = floor(value + 0.5);
        if (!cvol_fills_of_value(&fills->bits[i], to, value))
            return 0;
    }
    return 1;
}

int cvol_fills_add_nonfinite(cvol_fills *fills, cvol_type type, const void *samples, size_t count)
{
    if (cvol_type_is_integer(type))
        return 1;
    const int is_double = type == CVOL_FLOAT64;
    const uint64_t exponent = is_double ? UINT64_C(0x7ff) << 52 : UINT64_C(0xff) << 23;
    for (size_t i = 0; i < count; i++) {
        const uint64_t bits = is_double ? ((const cvol_word64 *)samples)[i]
                                        : ((const cvol_word32 *)samples)[i];
        if ((bits & exponent) == exponent && !cvol_fills_add(fills, bits))
            return 0;
    }
    return 1;
}

size_t cvol_fills_match(uint8_t *which, const cvol_fills *fills, cvol_type type,
                        const void *samples, size_t count)
{
    memset(which, 0, count);
    for (int f = 0; f < fills->count; f++) {
        const uint64_t bits = fills->bits[f];
        const uint8_t mark = (uint8_t)(f + 1);
#define MATCH(word)                                   \
    for (size_t i = 0; i < count; i++)                \
        if (((const word *)samples)[i] == (word)bits) \
    which[i] = mark
        CVOL_FOR_BYTES(cvol_type_size(type), MATCH);
#undef MATCH
    }
    size_t found = 0;
    for (size_t i = 0; i < count; i++)
        found += which[i] != 0;
    return found;
}
