/* Vectors of 16 floats in plain C: the compiler splits them where the machine's are shorter. */
#ifndef CVOL_BASE_VECTOR_H
#define CVOL_BASE_VECTOR_H

#include <stdint.h>
#include <string.h>

typedef float cvol_v16 __attribute__((vector_size(64)));
typedef int32_t cvol_i16 __attribute__((vector_size(64)));

#define CVOL_INLINE static inline __attribute__((always_inline))

/* Loads and stores at any address. */
CVOL_INLINE cvol_v16 cvol_load16(const float *from)
{
    cvol_v16 v;
    memcpy(&v, from, sizeof v);
    return v;
}

CVOL_INLINE void cvol_store16(float *to, cvol_v16 v)
{
    memcpy(to, &v, sizeof v);
}

/* All sixteen the same. */
CVOL_INLINE cvol_v16 cvol_splat16(float value)
{
    return value - (cvol_v16){0};
}

#endif
