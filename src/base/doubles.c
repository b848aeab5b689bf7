/* Samples of any type as doubles: doubles.h. */
#include "base/doubles.h"

#include "base/for_type.h"

void cvol_doubles_load(double *out, cvol_type type, const void *samples, size_t first, size_t count)
{
#define LOAD(t)                        \
    for (size_t i = 0; i < count; i++) \
    out[i] = (double)((const t *)samples)[first + i]
    CVOL_FOR_TYPE(type, LOAD);
#undef LOAD
}
