/* Section MASK: an array's mask, brick by brick (mask_code.h). */
#ifndef CVOL_CODEC_MASK_SECTION_H
#define CVOL_CODEC_MASK_SECTION_H

#include "array/array.h"
#include "codec/bricks.h"
#include "codec/section.h"
#include "codec/token_stream.h"

/* The bytes of one brick's mask; they replace those of *out. 1, or 0 when memory is short. */
int cvol_mask_brick(cvol_token_writer *writer, cvol_bytes *out, const cvol_token_tables *tables,
                    const cvol_array *array, size_t brick);

/* Adds the tokens of all bricks' masks, if there is a mask, to *counts. Errors: MEMORY. */
int cvol_mask_count(cvol_context *context, cvol_token_counts *counts, const cvol_array *array);

/* Gives an array the mask that a file has; of a box only what meets it. Errors: CORRUPT, MEMORY. */
int cvol_mask_take(cvol_context *context, cvol_array *array, const cvol_fills *fills,
                   const cvol_token_tables *tables, const cvol_brick_index *index,
                   const cvol_section *section, const cvol_box *box, const char *name);

#endif
