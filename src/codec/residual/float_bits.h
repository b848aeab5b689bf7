/* Exponents and last places of floating-point numbers. */
#ifndef CVOL_CODEC_RESIDUAL_FLOAT_BITS_H
#define CVOL_CODEC_RESIDUAL_FLOAT_BITS_H

#include <stdint.h>
#include <string.h>

#include "base/vector.h"
#include "cvol/base.h"

/* A float type: its digits, exponent of its smallest last place, and exponent bias. */
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

#endif
