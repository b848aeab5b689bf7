/* Conversion of every sample type from and to floats, element by element. */
#include <math.h>

#include "array/core/samples.h"
#include "base/cpu.h"
#include "base/vector_double.h"

enum { LANES = CVOL_VD_LANES };

void CVOL_SIMD(cvol_samples_load)(float *line, const void *samples, cvol_type type, size_t first,
                                  size_t count, double offset);
void CVOL_SIMD(cvol_samples_convert)(void *out, const float *in, size_t count,
                                     const cvol_sample_format *as);

/* ---- loading ---------------------------------------------------------------------------- */

#define LOAD(type)                                        \
    do {                                                  \
        const type *from = (const type *)samples + first; \
        for (size_t i = 0; i < count; i++)                \
            line[i] = (float)((double)from[i] - offset);  \
    } while (0)

/* The same for small integers and a small integer offset: in integers, which are exact. */
#define LOAD_SMALL(type)                                  \
    do {                                                  \
        const type *from = (const type *)samples + first; \
        const int32_t less = (int32_t)offset;             \
        for (size_t i = 0; i < count; i++)                \
            line[i] = (float)((int32_t)from[i] - less);   \
    } while (0)

/* Differences have less than 24 bits. */
#define LOAD_INTEGERS(type)                                             \
    do {                                                                \
        if (fabs(offset) < 0x1p22 && (double)(int32_t)offset == offset) \
            LOAD_SMALL(type);                                           \
        else                                                            \
            LOAD(type);                                                 \
    } while (0)

void CVOL_SIMD(cvol_samples_load)(float *line, const void *samples, cvol_type type, size_t first,
                                  size_t count, double offset)
{
    switch (type) {
    case CVOL_UINT8:
        LOAD_INTEGERS(uint8_t);
        break;
    case CVOL_INT8:
        LOAD_INTEGERS(int8_t);
        break;
    case CVOL_UINT16:
        LOAD_INTEGERS(uint16_t);
        break;
    case CVOL_INT16:
        LOAD_INTEGERS(int16_t);
        break;
    case CVOL_UINT32:
        LOAD(uint32_t);
        break;
    case CVOL_INT32:
        LOAD(int32_t);
        break;
    case CVOL_FLOAT32:
        LOAD(float);
        break;
    case CVOL_FLOAT64:
        LOAD(double);
        break;
    }
}

/* ---- storing ---------------------------------------------------------------------------- */

/* Integers, through integers of 32 bits. */
#define STORE_LANES(type, wide, whole, to)                                          \
    do {                                                                            \
        typedef wide wide_lanes __attribute__((vector_size(LANES * sizeof(wide)))); \
        typedef type type_lanes __attribute__((vector_size(LANES * sizeof(type)))); \
        const type_lanes lanes = __builtin_convertvector(                           \
            __builtin_convertvector(whole, wide_lanes), type_lanes);                \
        memcpy(to, &lanes, sizeof lanes);                                           \
    } while (0)

#define STORE_INTEGERS(type, wide)                                                              \
    do {                                                                                        \
        type *to = out;                                                                         \
        size_t i = 0;                                                                           \
        for (; i + LANES <= count; i += LANES) {                                                \
            const cvol_vd whole = cvol_vd_as_integers(cvol_vd_load_floats(in + i) + as->offset, \
                                                      as->lo, as->hi);                          \
            STORE_LANES(type, wide, whole, to + i);                                             \
        }                                                                                       \
        for (; i < count; i++) {                                                                \
            const double real = (double)in[i] + as->offset + 0.5;                               \
            const double above = real > as->lo ? real : as->lo;                                 \
            to[i] = (type)floor(above < as->hi ? above : as->hi);                               \
        }                                                                                       \
    } while (0)

#define STORE_REALS(type)                                       \
    do {                                                        \
        type *to = out;                                         \
        for (size_t i = 0; i < count; i++) {                    \
            const double real = (double)in[i] + as->offset;     \
            const double above = real < as->lo ? as->lo : real; \
            to[i] = (type)(above > as->hi ? as->hi : above);    \
        }                                                       \
    } while (0)

void CVOL_SIMD(cvol_samples_convert)(void *out, const float *in, size_t count,
                                     const cvol_sample_format *as)
{
    switch (as->type) {
    case CVOL_UINT8:
        STORE_INTEGERS(uint8_t, int32_t);
        break;
    case CVOL_INT8:
        STORE_INTEGERS(int8_t, int32_t);
        break;
    case CVOL_UINT16:
        STORE_INTEGERS(uint16_t, int32_t);
        break;
    case CVOL_INT16:
        STORE_INTEGERS(int16_t, int32_t);
        break;
    case CVOL_UINT32:
        STORE_INTEGERS(uint32_t, uint32_t);
        break;
    case CVOL_INT32:
        STORE_INTEGERS(int32_t, int32_t);
        break;
    case CVOL_FLOAT32:
        STORE_REALS(float);
        break;
    case CVOL_FLOAT64:
        STORE_REALS(double);
        break;
    }
}
