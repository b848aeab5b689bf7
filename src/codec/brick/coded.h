/* An array's encoded bricks, kept with the array that they decode to, so that writing it does not
 * encode again. */
#ifndef CVOL_CODEC_BRICK_CODED_H
#define CVOL_CODEC_BRICK_CODED_H

#include "codec/brick/brick_index.h"
#include "codec/brick/bricks.h"

typedef struct cvol_coded {
    cvol_token_tables *tables;
    cvol_brick_index index;
    cvol_bytes subbands[CVOL_SUBBANDS];
} cvol_coded;

/* Makes it for an array of this shape, without bricks. Errors: MEMORY. */
int cvol_coded_make(cvol_context *context, cvol_coded **out, const cvol_token_tables *tables,
                    const cvol_array *shape);
void cvol_coded_free(cvol_coded *coded); /* NULL is allowed */
/* A sink (bricks.h) that keeps all bricks, in order. */
cvol_brick_sink cvol_coded_sink(cvol_coded *coded);
/* Decodes all bricks, or those that a box needs, into an array without terms. Errors: MEMORY,
 * CANCELLED. */
int cvol_coded_decode(cvol_context *context, cvol_array *array, const cvol_coded *coded,
                      const cvol_box *box);
/* Gives the coded bricks to the array that they decode to, which has a coding; writing it uses
 * them. */
void cvol_coded_attach(cvol_array *array, cvol_coded *coded);
/* The coded bricks of an array, or NULL. */
const cvol_coded *cvol_coded_of(const cvol_array *array);
/* Hands all bricks to a sink, in order. */
int cvol_coded_write(cvol_context *context, const cvol_coded *coded, const cvol_brick_sink *sink);
/* The bytes of one brick. */
void cvol_coded_brick(cvol_span subbands[CVOL_SUBBANDS], const cvol_coded *coded, size_t brick);

#endif
