/* The source of dense samples: all in memory, or read slab by slab.
 *
 * A volume that is not in memory is read in strips: a layer of bricks, or some of its rows of
 * bricks if the samples of a layer take more than `strip_bytes`. The division depends on the volume
 * only, so sums over strips do not depend on the number of processes. */
#ifndef CVOL_CODEC_BRICK_SLAB_SOURCE_H
#define CVOL_CODEC_BRICK_SLAB_SOURCE_H

#include "array/block/brick.h"
#include "base/team.h"
#include "codec/brick/bricks.h"

typedef struct cvol_slab_source {
    /* Makes the rows and slices that *slab names available until the next call, and sets *slab to
     * what is available: these, or more. Not thread-safe. */
    int (*fetch)(cvol_context *context, void *user, cvol_slab *slab);
    void *user;
    int whole;          /* all samples are in memory: a fetch of any size costs the same */
    size_t strip_bytes; /* of samples, as far as one row of bricks takes no more; 0: no limit */
    cvol_team *team;    /* processes that share the work, each with such a source, or NULL */
} cvol_slab_source;

/* Bricks of layers layers[0] .. layers[1] - 1, in rows rows[0] .. rows[1] - 1 of bricks: of one
 * layer, or all rows. */
typedef struct cvol_strip {
    size_t layers[2], rows[2];
} cvol_strip;

/* The strips of a volume, layer after layer. */
typedef struct cvol_strips {
    size_t grid[3];   /* bricks */
    size_t rows;      /* rows of bricks in a strip; the last one of a layer may have fewer */
    size_t per_layer; /* strips */
} cvol_strips;

cvol_strips cvol_strips_of(const cvol_slab_source *source, const cvol_array *shape);
cvol_strip cvol_strip_at(const cvol_strips *strips, size_t number);
/* The number of the strip of a brick. */
size_t cvol_strip_of(const cvol_strips *strips, size_t brick);
/* The first brick of a strip, and the one after its last one. */
void cvol_strip_bricks(size_t bricks[2], const cvol_strips *strips, const cvol_strip *strip);
/* The samples of a strip, without those around it. */
cvol_box cvol_strip_samples(const cvol_array *shape, const cvol_strip *strip);

/* Fetches the samples of a strip, and two more rows and slices at either end within the volume,
 * which the pre-filter of lapped volumes reads. */
int cvol_slab_fetch_strip(cvol_context *context, cvol_slab *slab, const cvol_slab_source *source,
                          const cvol_array *shape, const cvol_strip *strip);

#endif
