/* Section MASK: an array's mask, brick by brick (mask_code.h). */
#ifndef CVOL_CODEC_MASK_MASK_SECTION_H
#define CVOL_CODEC_MASK_MASK_SECTION_H

#include "array/core/array.h"
#include "codec/brick/bricks.h"
#include "codec/entropy/range_coder.h"
#include "codec/section/section.h"

/* Encodes one brick's mask; the bytes replace the content of *out. Returns 1, or 0 when memory is
 * short. */
int cvol_mask_put_brick(cvol_range_encoder *coder, cvol_bytes *out, const cvol_array *array,
                        size_t brick);

/* The total bytes of all bricks' masks. Errors: MEMORY. */
int cvol_mask_measure(cvol_context *context, uint64_t *bytes, const cvol_array *array);

/* Reads an array's mask from a file; with a box only the bricks that meet it. Errors: CORRUPT,
 * MEMORY. */
int cvol_mask_take(cvol_context *context, cvol_array *array, const cvol_fills *fills,
                   const cvol_brick_index *index, const cvol_section *section, const cvol_box *box,
                   const char *name);

#endif
