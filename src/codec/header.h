/* Section HEAD: what the array is. */
#ifndef CVOL_CODEC_HEADER_H
#define CVOL_CODEC_HEADER_H

#include "array/array.h"
#include "base/bytes.h"

/* All fields of HEAD but the samples themselves. */
typedef struct cvol_header {
    cvol_grid grid;
    uint32_t transform, block;
    double step, offset;
    double value_min, value_max, range_min, range_max;
    double psnr_db, max_error, l2_error;
    uint64_t coefficients;
} cvol_header;

void cvol_header_put(cvol_bytes *out, const cvol_array *array);
/* Reads and checks every field. Errors: CORRUPT, FORMAT, LIMIT, UNSUPPORTED. */
int cvol_header_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                     const char *name);

#endif
