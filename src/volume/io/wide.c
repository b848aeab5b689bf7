/* Integers of 64 bits and complex numbers as samples. */
#include "volume/io/wide.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/context.h"

/* Integers up to this magnitude are exact doubles. */
#define EXACT_MOST ((int64_t)1 << 53)

/* Copies go through memory: samples overwrite the elements that they came from. */
#define CONVERT(from, to, value)                                      \
    for (size_t i = 0; i < count; i++) {                              \
        from element;                                                 \
        memcpy(&element, bytes + i * sizeof element, sizeof element); \
        const to sample = (to)(value);                                \
        memcpy(bytes + i * sizeof sample, &sample, sizeof sample);    \
    }

static int fail_value(cvol_context *context, const char *path, const char *value)
{
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                     "%s: holds the 64-bit integer %s, which is exact neither in 32 bits nor as a "
                     "double",
                     path, value);
}

static int narrow_signed(cvol_context *context, cvol_type *type, uint8_t *bytes, size_t count,
                         int as_double, const char *path)
{
    int64_t least = INT64_MAX, most = INT64_MIN;
    for (size_t i = 0; i < count; i++) {
        int64_t value;
        memcpy(&value, bytes + i * sizeof value, sizeof value);
        least = value < least ? value : least;
        most = value > most ? value : most;
    }
    if (!as_double && least >= INT32_MIN && most <= INT32_MAX) {
        *type = CVOL_INT32;
        CONVERT(int64_t, int32_t, element)
    } else if (!as_double && least >= 0 && most <= UINT32_MAX) {
        *type = CVOL_UINT32;
        CONVERT(int64_t, uint32_t, element)
    } else if (least >= -EXACT_MOST && most <= EXACT_MOST) {
        *type = CVOL_FLOAT64;
        CONVERT(int64_t, double, element)
    } else {
        char text[32];
        snprintf(text, sizeof text, "%lld", (long long)(most > EXACT_MOST ? most : least));
        return fail_value(context, path, text);
    }
    return CVOL_OK;
}

static int narrow_unsigned(cvol_context *context, cvol_type *type, uint8_t *bytes, size_t count,
                           int as_double, const char *path)
{
    uint64_t most = 0;
    for (size_t i = 0; i < count; i++) {
        uint64_t value;
        memcpy(&value, bytes + i * sizeof value, sizeof value);
        most = value > most ? value : most;
    }
    if (!as_double && most <= UINT32_MAX) {
        *type = CVOL_UINT32;
        CONVERT(uint64_t, uint32_t, element)
    } else if (most <= (uint64_t)EXACT_MOST) {
        *type = CVOL_FLOAT64;
        CONVERT(uint64_t, double, element)
    } else {
        char text[32];
        snprintf(text, sizeof text, "%llu", (unsigned long long)most);
        return fail_value(context, path, text);
    }
    return CVOL_OK;
}

typedef struct complex_number {
    float re, im;
} complex_number;

int cvol_wide_narrow(cvol_context *context, cvol_type *type, void *data, size_t count,
                     cvol_wide wide, int as_double, const char *path)
{
    uint8_t *bytes = data;
    if (wide == CVOL_WIDE_INT64)
        return narrow_signed(context, type, bytes, count, as_double, path);
    if (wide == CVOL_WIDE_UINT64)
        return narrow_unsigned(context, type, bytes, count, as_double, path);
    *type = CVOL_FLOAT32;
    CONVERT(complex_number, float,
            sqrt((double)element.re * (double)element.re + (double)element.im * (double)element.im))
    return CVOL_OK;
}
