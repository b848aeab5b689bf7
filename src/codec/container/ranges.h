/* Section RNGE: bounds of each block's samples, coarse if they are wide.
 *
 * A cell of 16^3 samples has one pair of bounds (blocks of 8 share their cell's; a block of 32 has
 * its own). They are rounded outwards to 1/8 to 1/16 of their distance. This halves their bytes or
 * better, and skips almost the same blocks. */
#ifndef CVOL_CODEC_CONTAINER_RANGES_H
#define CVOL_CODEC_CONTAINER_RANGES_H

#include "array/core/array.h"
#include "base/bytes.h"
#include "codec/section/section.h"

/* Computes the block ranges of a volume as a file will store them, and lowers max_abs to their
 * bound. Errors: MEMORY. */
int cvol_ranges_find(cvol_context *context, cvol_array *array);

/* Appends the section's content. Errors: MEMORY. */
int cvol_ranges_put(cvol_context *context, cvol_bytes *out, const cvol_array *array);
/* Sets the block ranges from the content. Errors: CORRUPT, MEMORY. */
int cvol_ranges_take(cvol_context *context, cvol_array *array, const cvol_section *section,
                     const char *name);

#endif
