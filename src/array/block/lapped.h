/* Samples of lapped volumes: what blocks evaluate to, post-filtered across their faces
 * (transform/lap.h), before `offset` is added.
 *
 * A sample beside a face is made of samples of both cells, so whoever wants one cell evaluates its
 * neighbours too. Whoever wants many is better served by the stream: it evaluates layer of cells
 * after layer, every cell of a box once, and hands out finished samples while they are in the
 * cache.
 */
#ifndef CVOL_ARRAY_BLOCK_LAPPED_H
#define CVOL_ARRAY_BLOCK_LAPPED_H

#include "array/core/array.h"

/* Widens a box of samples to what the filters of all faces that its samples stand beside read. */
void cvol_lapped_widen(size_t begin[3], size_t end[3], const cvol_array *array);

/* Post-filters a box of what blocks evaluate to, in place: along x, then y, then z. Samples whose
 * faces do not lie in the box with all of their samples (see above) are not what they are to be. */
void cvol_lapped_filter(float *samples, const cvol_array *array, const size_t begin[3],
                        const size_t size[3], const size_t stride[3]);

/* ---- the stream -------------------------------------------------------------------------------
 */

/* A part of the box: finished samples without the offset. */
typedef struct cvol_piece {
    size_t begin[3], end[3]; /* of the volume; along x all of the box */
    const float *samples[2]; /* of each array, the sample at `begin` first */
    size_t line, sheet;      /* floats from line to line and from sheet to sheet */
    size_t index;            /* below cvol_stream_pieces; the same for any number of threads */
} cvol_piece;

typedef struct cvol_stream {
    const cvol_array
        *arrays[2];          /* volumes in blocks of 16, lapped or not; the second may be NULL */
    size_t begin[3], end[3]; /* the box, within the volume */
    void (*take)(void *user,
                 const cvol_piece *piece); /* on any thread; pieces cover the box once */
    void *user;
    const char *what; /* for progress: "decoding"; NULL: it is told by the caller */
} cvol_stream;

/* A stream of all samples. */
cvol_stream cvol_stream_of(const cvol_array *a, const cvol_array *b);
/* No index of a piece is as large; some may not come. */
size_t cvol_stream_pieces(const cvol_stream *stream);
/* Memory: floats of four sheets, and of two rows of cells for each thread. Errors: MEMORY,
 * CANCELLED. */
int cvol_stream_run(cvol_context *context, const cvol_stream *stream);

#endif
