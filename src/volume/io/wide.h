/* Elements of files that are wider than samples: integers of 64 bits, and complex numbers. */
#ifndef CVOL_VOLUME_IO_WIDE_H
#define CVOL_VOLUME_IO_WIDE_H

#include "cvol/base.h"

typedef enum cvol_wide {
    CVOL_WIDE_NONE,
    CVOL_WIDE_INT64,
    CVOL_WIDE_UINT64,
    CVOL_WIDE_COMPLEX64 /* two floats; samples are their magnitudes */
} cvol_wide;

/* Elements have the size of this type: it stands for them until they are narrow. */
#define CVOL_WIDE_TYPE CVOL_FLOAT64

/* Makes samples of `count` elements in the machine's byte order, in place, and sets their type.
 * Integers become int32 or uint32 if all fit and not as_double, or else float64 if all are exact.
 * Errors: UNSUPPORTED (an integer fits none of these; the message begins with `path`). */
int cvol_wide_narrow(cvol_context *context, cvol_type *type, void *data, size_t count,
                     cvol_wide wide, int as_double, const char *path);

#endif
