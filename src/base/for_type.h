/* Common code for every type of samples. */
#ifndef CVOL_BASE_FOR_TYPE_H
#define CVOL_BASE_FOR_TYPE_H

#include <stdint.h>

#include "cvol/base.h"

/* Applies CASE(type) to the C type of a cvol_type. */
#define CVOL_FOR_TYPE(number, CASE) \
    switch (number) {               \
    case CVOL_UINT8:                \
        CASE(uint8_t);              \
        break;                      \
    case CVOL_INT8:                 \
        CASE(int8_t);               \
        break;                      \
    case CVOL_UINT16:               \
        CASE(uint16_t);             \
        break;                      \
    case CVOL_INT16:                \
        CASE(int16_t);              \
        break;                      \
    case CVOL_UINT32:               \
        CASE(uint32_t);             \
        break;                      \
    case CVOL_INT32:                \
        CASE(int32_t);              \
        break;                      \
    case CVOL_FLOAT32:              \
        CASE(float);                \
        break;                      \
    case CVOL_FLOAT64:              \
        CASE(double);               \
        break;                      \
    }

#endif
