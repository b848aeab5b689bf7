/* All bricks of an array, encoded and decoded by as many threads as the context allows: the bytes
 * and the terms are the same for any number. */
#ifndef CVOL_CODEC_BRICK_BRICKS_H
#define CVOL_CODEC_BRICK_BRICKS_H

#include "codec/brick/brick_code.h"
#include "codec/brick/brick_index.h"

/* Who gets the bytes: called for brick after brick in order, from the calling thread. */
typedef struct cvol_brick_sink {
    int (*take)(cvol_context *context, void *user, size_t brick,
                const cvol_span subbands[CVOL_SUBBANDS]);
    void *user;
} cvol_brick_sink;

/* Encodes the terms of a volume. Memory: a few bricks a thread. Errors: MEMORY, CANCELLED, the
 * sink's. */
int cvol_bricks_encode(cvol_context *context, const cvol_array *array,
                       const cvol_token_tables *tables, const cvol_brick_sink *sink);

/* Whether all terms are what the array's `dependent` and `ends` say: 1, 0, or an error's code
 * negated. Errors: MEMORY. */
int cvol_bricks_fit(cvol_context *context, const cvol_array *array);

/* Counts the tokens that this takes (token_tables.h). Errors: MEMORY, CANCELLED. */
int cvol_bricks_count(cvol_context *context, cvol_token_counts *counts, const cvol_array *array);

/* A box of samples, [begin, end). */
typedef struct cvol_box {
    size_t begin[3], end[3];
} cvol_box;

/* The subbands as they lie in a file, of which the first `count` are there. */
typedef struct cvol_brick_source {
    const cvol_brick_index *index;
    const uint8_t *subbands[CVOL_SUBBANDS];
    int count;
    int is_checked; /* only: terms are decoded, and not kept; the volume is of no use then */
} cvol_brick_source;

/* Checks and decodes those subbands into a volume that has no terms yet; sets its coefficients. If
 * box is not NULL, only of the bricks that its samples need; others are left without terms, and
 * unread. `name` begins the message. Errors: CORRUPT, MEMORY, CANCELLED. */
int cvol_bricks_decode(cvol_context *context, cvol_array *array, const cvol_token_tables *tables,
                       const cvol_brick_source *source, const cvol_box *box, const char *name);

#endif
