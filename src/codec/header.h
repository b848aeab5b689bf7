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
    cvol_ledger ledger;
    double range_min, range_max;
    double psnr_db, max_error;
    uint64_t coefficients;
    double threshold;
    uint32_t measured, rank;
} cvol_header;

/* Whether an array's terms are coded in groups (RNGE, INDX, DATA); others have a section of their
 * own. */
int cvol_header_is_volume(const cvol_header *header);
void cvol_header_put(cvol_bytes *out, const cvol_array *array);
/* Reads and checks every field. Errors: CORRUPT, FORMAT, LIMIT, UNSUPPORTED. */
int cvol_header_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                     const char *name);

#endif
