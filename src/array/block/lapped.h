/* Samples of lapped volumes: evaluated blocks, post-filtered across their faces (transform/lap.h),
 * before `offset` is added.
 *
 * A sample near a face depends on both blocks, so evaluating one block needs its neighbours too.
 * For many blocks the stream is cheaper: it evaluates every block of a box once, layer after layer,
 * and passes on finished samples while they are in the cache. */
#ifndef CVOL_ARRAY_BLOCK_LAPPED_H
#define CVOL_ARRAY_BLOCK_LAPPED_H

#include "array/core/array.h"

/* Widens a box of samples by the reach of the filters of all faces near its samples. */
void cvol_lapped_widen(size_t begin[3], size_t end[3], const cvol_array *array);

/* Post-filters a box of evaluated blocks in place: along x, then y, then z. Samples near a face
 * that lies only partly in the box (see above) are wrong. */
void cvol_lapped_filter(float *samples, const cvol_array *array, const size_t begin[3],
                        const size_t size[3], const size_t stride[3]);

/* ---- the stream ------------------------------------------------------------------------------ */

/* A part of the box: finished samples without the offset. */
typedef struct cvol_piece {
    size_t begin[3], end[3]; /* of the volume; along x all of the box */
    const float *samples[2]; /* of each array, the sample at `begin` first */
    size_t line, sheet;      /* floats from line to line and from slice to slice */
    size_t index;            /* below cvol_stream_pieces; the same for any number of threads */
} cvol_piece;

typedef struct cvol_stream {
    const cvol_array
        *arrays[2];          /* volumes in blocks of 16, lapped or not; the second may be NULL */
    size_t begin[3], end[3]; /* the box, within the volume */
    void (*take)(void *user,
                 const cvol_piece *piece); /* on any thread; pieces cover the box once */
    void *user;
    const char *what; /* for progress: "decoding"; NULL: the caller reports it */
} cvol_stream;

/* A stream of all samples. */
cvol_stream cvol_stream_of(const cvol_array *a, const cvol_array *b);
/* An upper limit of the indices of pieces; some indices may not occur. */
size_t cvol_stream_pieces(const cvol_stream *stream);
/* Memory: floats of four slices, and of two rows of blocks per thread. Errors: MEMORY,
 * CANCELLED. */
int cvol_stream_run(cvol_context *context, const cvol_stream *stream);

#endif
