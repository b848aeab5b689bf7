/* The source of a picture by the sheet engine: the volume itself, or one of its levels. */
#ifndef CVOL_RENDER_SHEET_SOURCE_H
#define CVOL_RENDER_SHEET_SOURCE_H

#include "render/sheet/band/skip.h"
#include "render/sheet/frame/level.h"
#include "render/sheet/frame/mask.h"

/* The volume, and levels 1 to 3. */
#define CVOL_SHEET_SOURCES 4

typedef struct cvol_sheet_source {
    const cvol_array
        *array;             /* blocks and ranges: the volume's or the level's; NULL: not made yet */
    cvol_array *ranged;     /* the array with ranges, if the volume came without them */
    cvol_sheet_mask mask;   /* of the volume's blocks */
    cvol_sheet_level level; /* samples: NULL for the volume itself */
    cvol_visibility by_transfer, everything;
} cvol_sheet_source;

/* Makes level `level` of an array (0: the array itself), which must outlive it; all zero is an
 * empty one. Errors: MEMORY, CANCELLED. */
int cvol_sheet_source_make(cvol_context *context, cvol_sheet_source *out, const cvol_array *array,
                           int level);
/* Finds the visible part under a transfer function. */
void cvol_sheet_source_find_visible(cvol_sheet_source *source, const cvol_transfer *transfer);
/* Widens the range of the array, to which the codes of blocks refer; transfer: as above, or NULL.
 * Errors: MEMORY. */
int cvol_sheet_source_widen(cvol_context *context, cvol_sheet_source *source, const double range[2],
                            const cvol_transfer *transfer);
void cvol_sheet_source_free(cvol_sheet_source *source);

/* The mask of its blocks; NULL if they have none. */
const cvol_sheet_mask *cvol_sheet_source_mask(const cvol_sheet_source *source);
/* The treatment of masked samples when the source is drawn; `mask`: the volume's, or NULL. */
cvol_sheet_masked cvol_sheet_source_masked(const cvol_sheet_source *source, const cvol_mask *mask);

#endif
