/* The source of dense samples: all in memory, or read slab by slab. */
#ifndef CVOL_CODEC_BRICK_SLAB_SOURCE_H
#define CVOL_CODEC_BRICK_SLAB_SOURCE_H

#include "array/block/brick.h"
#include "base/team.h"

typedef struct cvol_slab_source {
    /* Makes slices first .. first + count - 1 available until the next call. Not thread-safe. */
    int (*fetch)(cvol_context *context, void *user, cvol_slab *out, size_t first, size_t count);
    void *user;
    int whole;       /* all samples are in memory: a fetch of any size costs the same */
    cvol_team *team; /* processes that share the work, each with such a source, or NULL */
} cvol_slab_source;

/* Fetches the slices of layers layer .. end - 1 of bricks, and two more at either end within the
 * volume, which the pre-filter of lapped volumes reads. */
int cvol_slab_fetch_layers(cvol_context *context, cvol_slab *slab, const cvol_slab_source *source,
                           const cvol_array *shape, size_t layer, size_t end);

#endif
