/* Encodes and decodes all bricks of an array on all threads of the context. Bytes and terms do not
 * depend on the number of threads. */
#ifndef CVOL_CODEC_BRICK_BRICKS_H
#define CVOL_CODEC_BRICK_BRICKS_H

#include "codec/brick/brick_code.h"
#include "codec/brick/brick_index.h"

/* The receiver of the bytes: called for each brick in order, from the calling thread. */
typedef struct cvol_brick_sink {
    int (*take)(cvol_context *context, void *user, size_t brick,
                const cvol_span subbands[CVOL_SUBBANDS]);
    void *user;
} cvol_brick_sink;

/* Encodes the terms of a volume. Memory: a few bricks per thread. Errors: MEMORY, CANCELLED, the
 * sink's. */
int cvol_bricks_encode(cvol_context *context, const cvol_array *array,
                       const cvol_token_tables *tables, const cvol_brick_sink *sink);

/* Tests if all terms are possible results of the array's trellis and true_length: returns 1, 0, or
 * an error code, which is negative. Errors: MEMORY. */
int cvol_bricks_fit(cvol_context *context, const cvol_array *array);

/* Counts the tokens of cvol_bricks_encode (token_tables.h). Errors: MEMORY, CANCELLED. */
int cvol_bricks_count(cvol_context *context, cvol_token_counts *counts, const cvol_array *array);

/* A box of samples, [begin, end). */
typedef struct cvol_box {
    size_t begin[3], end[3];
} cvol_box;

/* The subbands in a file; the first `count` are available. */
typedef struct cvol_brick_source {
    const cvol_brick_index *index;
    const uint8_t *subbands[CVOL_SUBBANDS];
    int count;
    const uint8_t *levels; /* of each brick, 0 to 3; NULL: all subbands of all bricks */
    int is_checked; /* only test: terms are decoded but not kept, and the volume is discarded; the
                       processes of the context's team test different bricks */
} cvol_brick_source;

/* Checks and decodes those subbands into a volume without terms; sets its coefficients. If box is
 * not NULL, it decodes only the bricks that the box's samples need, does not read others, and
 * leaves them without terms. `name` begins the message. Errors: CORRUPT, MEMORY, CANCELLED. */
int cvol_bricks_decode(cvol_context *context, cvol_array *array, const cvol_token_tables *tables,
                       const cvol_brick_source *source, const cvol_box *box, const char *name);

#endif
