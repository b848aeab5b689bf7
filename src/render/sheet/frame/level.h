/* A volume at a coarser resolution, for the sheet engine: level l has one sample for 2^l of the
 * volume along each axis (one if the volume has only one), made from the lowest B / 2^l frequencies
 * of its blocks. These few samples are evaluated once, and stored in blocks of 16^3.
 *
 * A separate background or mask has the level's resolution, too: a background is mixed into the
 * samples by its share, and samples without a value have a cover. Along each axis sample s lies at
 * first + s pitch, pitch = 2^l, first = (pitch - 1) / 2. The last samples are repeated up to the
 * end of their blocks. */
#ifndef CVOL_RENDER_SHEET_FRAME_LEVEL_H
#define CVOL_RENDER_SHEET_FRAME_LEVEL_H

#include "render/sheet/frame/frame.h"
#include "render/sheet/frame/mask.h"

#define CVOL_LEVEL_BLOCK 16
#define CVOL_LEVEL_BLOCK_SAMPLES (CVOL_LEVEL_BLOCK * CVOL_LEVEL_BLOCK * CVOL_LEVEL_BLOCK)

typedef struct cvol_sheet_level {
    cvol_array *shape;    /* for visibility: offset and ranges, but no terms */
    float *samples;       /* [shape->block_count][16][16][16], x fastest */
    float *cover;         /* the share of each that has a value; NULL: all have values */
    cvol_sheet_mask mask; /* of cover: states only */
} cvol_sheet_level;

/* Samples along an axis. */
size_t cvol_sheet_level_size(size_t samples, int level);
/* Returns 1 if a level's samples are few enough to be stored. */
int cvol_sheet_level_fits(const cvol_array *array, int level);

/* Makes a level, 1 to 3; all zero is an empty one. Errors: MEMORY, CANCELLED. */
int cvol_sheet_level_make(cvol_context *context, cvol_sheet_level *out, const cvol_array *array,
                          int level);
/* The same of slices begin .. end - 1 of the volume, but every sample is the mean of its cell in
 * the level before: of the terms of that level alone. It costs about twice as much. begin, and end
 * unless it is that of the volume, are multiples of 32. The filter of a lapped volume needs blocks
 * on both sides of their faces: the first and the last samples of some slices lack it. */
int cvol_sheet_level_make_means(cvol_context *context, cvol_sheet_level *out,
                                const cvol_array *array, int level, size_t begin, size_t end);
void cvol_sheet_level_free(cvol_sheet_level *level);

/* Copies block `index` into a view's memory: sample (lane, row, sheet) goes to out[lane + row
 * row_stride + sheet sheet_stride]. `from`: the level's samples or cover. */
void cvol_sheet_level_copy(float *out, ptrdiff_t row_stride, ptrdiff_t sheet_stride,
                           const float *from, size_t index, const cvol_sheet_plan *plan);
/* Samples in the plan's int16 format. */
void cvol_sheet_level_copy_int16(int16_t *out, ptrdiff_t row_stride, ptrdiff_t sheet_stride,
                                 const float *from, size_t index, const cvol_sheet_plan *plan);

#endif
