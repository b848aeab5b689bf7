/* Compares rows of samples with decoded values, eight at a time. */
#include <math.h>

#include "base/cpu.h"
#include "base/vector_double.h"
#include "codec/rate/compare_rows.h"

enum { PARTS = 8, LANES = CVOL_VD_LANES, VECTORS = PARTS / LANES };

void CVOL_SIMD(cvol_compare_samples)(cvol_row_distance *out, const void *samples, size_t first,
                                     const void *decoded, cvol_type type, size_t count);
void CVOL_SIMD(cvol_compare_reals)(cvol_row_distance *out, const void *samples, size_t first,
                                   const float *real, double offset, cvol_type type, size_t count);
void CVOL_SIMD(cvol_compare_stored)(cvol_row_distance *out, const void *samples, size_t first,
                                    const float *real, size_t count, const cvol_sample_format *as);

/* Eight partial sums, in vectors. */
typedef struct sums {
    cvol_vd mosts[VECTORS], squares[VECTORS];
} sums;
typedef struct real_sums {
    cvol_vd mosts[VECTORS], errors[VECTORS], squares[VECTORS], norms[VECTORS];
} real_sums;

CVOL_INLINE double sum_of(const cvol_vd vectors[VECTORS])
{
    double parts[PARTS];
    memcpy(parts, vectors, sizeof parts);
    return ((parts[0] + parts[1]) + (parts[2] + parts[3])) +
           ((parts[4] + parts[5]) + (parts[6] + parts[7]));
}

CVOL_INLINE double most_of(const cvol_vd vectors[VECTORS])
{
    double parts[PARTS], most = 0;
    memcpy(parts, vectors, sizeof parts);
    for (int k = 0; k < PARTS; k++)
        most = parts[k] > most ? parts[k] : most;
    return most;
}

CVOL_INLINE void add(sums *to, int k, cvol_vd a, cvol_vd b)
{
    const cvol_vd error = cvol_vd_size(a - b);
    to->mosts[k] = cvol_vd_above(error, to->mosts[k]);
    to->squares[k] += error * error;
}

CVOL_INLINE void add_real(real_sums *to, int k, cvol_vd a, cvol_vd real)
{
    const cvol_vd_floats rounded = __builtin_convertvector(real, cvol_vd_floats);
    const cvol_vd value = __builtin_convertvector(rounded, cvol_vd), size = cvol_vd_size(value);
    const cvol_vd error = cvol_vd_size(a - value);
    to->errors[k] = cvol_vd_above(error, to->errors[k]);
    to->squares[k] += error * error;
    to->norms[k] += size * size;
    to->mosts[k] = cvol_vd_above(size, to->mosts[k]);
}

/* Adds the last samples one by one to the first sum. */
CVOL_INLINE void add_last(sums *to, double a, double b)
{
    const double error = fabs(a - b);
    to->mosts[0][0] = error > to->mosts[0][0] ? error : to->mosts[0][0];
    to->squares[0][0] += error * error;
}

CVOL_INLINE void add_last_real(real_sums *to, double a, double real)
{
    const double value = (double)(float)real, size = fabs(value), error = fabs(a - value);
    to->errors[0][0] = error > to->errors[0][0] ? error : to->errors[0][0];
    to->squares[0][0] += error * error;
    to->norms[0][0] += size * size;
    to->mosts[0][0] = size > to->mosts[0][0] ? size : to->mosts[0][0];
}

CVOL_INLINE void finish(cvol_row_distance *out, const sums *from)
{
    out->most = most_of(from->mosts);
    out->squares = sum_of(from->squares);
}

CVOL_INLINE void finish_real(cvol_row_distance *out, const real_sums *from)
{
    out->real_most = most_of(from->mosts);
    out->real_error = most_of(from->errors);
    out->real_squares = sum_of(from->squares);
    out->real_norms = sum_of(from->norms);
}

/* CASE(type, load, conversion from floats) */
#define FOR_TYPE(number, CASE)                           \
    switch (number) {                                    \
    case CVOL_UINT8:                                     \
        CASE(uint8_t, CVOL_VD_LOAD_SMALL, AS_INTEGERS);  \
        break;                                           \
    case CVOL_INT8:                                      \
        CASE(int8_t, CVOL_VD_LOAD_SMALL, AS_INTEGERS);   \
        break;                                           \
    case CVOL_UINT16:                                    \
        CASE(uint16_t, CVOL_VD_LOAD_SMALL, AS_INTEGERS); \
        break;                                           \
    case CVOL_INT16:                                     \
        CASE(int16_t, CVOL_VD_LOAD_SMALL, AS_INTEGERS);  \
        break;                                           \
    case CVOL_UINT32:                                    \
        CASE(uint32_t, CVOL_VD_LOAD_TYPE, AS_INTEGERS);  \
        break;                                           \
    case CVOL_INT32:                                     \
        CASE(int32_t, CVOL_VD_LOAD_TYPE, AS_INTEGERS);   \
        break;                                           \
    case CVOL_FLOAT32:                                   \
        CASE(float, CVOL_VD_LOAD_TYPE, AS_FLOATS);       \
        break;                                           \
    case CVOL_FLOAT64:                                   \
        CASE(double, CVOL_VD_LOAD_TYPE, AS_DOUBLES);     \
        break;                                           \
    }

#define COMPARE_SAMPLES(type, LOAD, AS)                                            \
    do {                                                                           \
        const type *a = (const type *)samples + first, *b = (const type *)decoded; \
        size_t i = 0;                                                              \
        for (; i + PARTS <= count; i += PARTS)                                     \
            for (int k = 0; k < VECTORS; k++) {                                    \
                cvol_vd x, y;                                                      \
                LOAD(x, a + i + k * LANES, type);                                  \
                LOAD(y, b + i + k * LANES, type);                                  \
                add(&all, k, x, y);                                                \
            }                                                                      \
        for (; i < count; i++)                                                     \
            add_last(&all, (double)a[i], (double)b[i]);                            \
    } while (0)

void CVOL_SIMD(cvol_compare_samples)(cvol_row_distance *out, const void *samples, size_t first,
                                     const void *decoded, cvol_type type, size_t count)
{
    sums all = {0};
    FOR_TYPE(type, COMPARE_SAMPLES);
    finish(out, &all);
}

#define COMPARE_REALS(type, LOAD, AS)                                                     \
    do {                                                                                  \
        const type *a = (const type *)samples + first;                                    \
        size_t i = 0;                                                                     \
        for (; i + PARTS <= count; i += PARTS)                                            \
            for (int k = 0; k < VECTORS; k++) {                                           \
                cvol_vd x;                                                                \
                LOAD(x, a + i + k * LANES, type);                                         \
                add_real(&all, k, x, cvol_vd_load_floats(real + i + k * LANES) + offset); \
            }                                                                             \
        for (; i < count; i++)                                                            \
            add_last_real(&all, (double)a[i], (double)real[i] + offset);                  \
    } while (0)

void CVOL_SIMD(cvol_compare_reals)(cvol_row_distance *out, const void *samples, size_t first,
                                   const float *real, double offset, cvol_type type, size_t count)
{
    real_sums all = {0};
    FOR_TYPE(type, COMPARE_REALS);
    finish_real(out, &all);
}

/* Within lo .. hi; NaN stays. */
CVOL_INLINE cvol_vd clamp(cvol_vd real, const cvol_sample_format *as)
{
    return cvol_vd_below(cvol_vd_splat(as->hi), cvol_vd_above(cvol_vd_splat(as->lo), real));
}

#define AS_INTEGERS(real) cvol_vd_as_integers(real, as->lo, as->hi)
#define AS_DOUBLES(real) clamp(real, as)
#define AS_FLOATS(real) \
    __builtin_convertvector(__builtin_convertvector(clamp(real, as), cvol_vd_floats), cvol_vd)

#define COMPARE_STORED(type, LOAD, AS)                                                          \
    do {                                                                                        \
        const type *a = (const type *)samples + first;                                          \
        size_t i = 0;                                                                           \
        for (; i + PARTS <= count; i += PARTS)                                                  \
            for (int k = 0; k < VECTORS; k++) {                                                 \
                const cvol_vd decoded = cvol_vd_load_floats(real + i + k * LANES) + as->offset; \
                cvol_vd x;                                                                      \
                LOAD(x, a + i + k * LANES, type);                                               \
                add(&all, k, x, AS(decoded));                                                   \
                add_real(&reals, k, x, decoded);                                                \
            }                                                                                   \
        for (; i < count; i++) {                                                                \
            const cvol_vd decoded = cvol_vd_splat((double)real[i] + as->offset);                \
            const cvol_vd stored = AS(decoded);                                                 \
            add_last(&all, (double)a[i], stored[0]);                                            \
            add_last_real(&reals, (double)a[i], decoded[0]);                                    \
        }                                                                                       \
    } while (0)

void CVOL_SIMD(cvol_compare_stored)(cvol_row_distance *out, const void *samples, size_t first,
                                    const float *real, size_t count, const cvol_sample_format *as)
{
    sums all = {0};
    real_sums reals = {0};
    FOR_TYPE(as->type, COMPARE_STORED);
    finish(out, &all);
    finish_real(out, &reals);
}
