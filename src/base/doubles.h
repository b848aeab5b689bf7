/* Samples of any type as doubles. */
#ifndef CVOL_BASE_DOUBLES_H
#define CVOL_BASE_DOUBLES_H

#include "cvol/base.h"

/* Converts samples first .. first + count - 1 to doubles, from out[0] on. Exact for all types. */
void cvol_doubles_load(double *out, cvol_type type, const void *samples, size_t first,
                       size_t count);

#endif
