/* Where dense samples come from: all in memory, or read slab by slab. */
#ifndef CVOL_CODEC_BRICK_SLAB_SOURCE_H
#define CVOL_CODEC_BRICK_SLAB_SOURCE_H

#include "array/block/brick.h"

typedef struct cvol_slab_source {
    /* Makes sheets first .. first + count - 1 available, until the next call. Not for two threads
     * at once. */
    int (*fetch)(cvol_context *context, void *user, cvol_slab *out, size_t first, size_t count);
    void *user;
    int whole; /* all samples are in memory: many sheets cost no more than few */
} cvol_slab_source;

/* Fetches what layers layer .. end - 1 of bricks need: their sheets, and two more at either end, as
 * far as the volume has them, which the pre-filter of lapped volumes reads. */
int cvol_slab_fetch_layers(cvol_context *context, cvol_slab *slab, const cvol_slab_source *source,
                           const cvol_array *shape, size_t layer, size_t end);

#endif
