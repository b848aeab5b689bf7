/* Converts dense samples to a brick's bytes. */
#ifndef CVOL_CODEC_BRICK_BRICK_SAMPLES_H
#define CVOL_CODEC_BRICK_BRICK_SAMPLES_H

#include "array/block/brick.h"
#include "codec/brick/brick_code.h"
#include "codec/quantize/split_choice.h"

/* One thread's memory: about 3 MiB. */
typedef struct cvol_brick_maker cvol_brick_maker;
cvol_brick_maker *cvol_brick_maker_create(const cvol_array *shape);
void cvol_brick_maker_free(cvol_brick_maker *maker);

/* The settings that all bricks of a pass share. */
typedef struct cvol_brick_recipe {
    const cvol_array *shape; /* dims, block, lapped, offset */
    const cvol_token_tables *tables;
    const cvol_token_costs *costs; /* of these tables */
    cvol_chooser_options options;
    cvol_token_counts *counts; /* adds to them; may be NULL */
    cvol_array *kept; /* of the same shape, or NULL: CVOL_SPLIT_FAST sets `words` and `split` of
                         its blocks */
} cvol_brick_recipe;

/* The largest number of samples of one brick's cells, as from cvol_brick_gather. */
#define CVOL_BRICK_SAMPLES ((size_t)CVOL_BRICK_SIDE * CVOL_BRICK_SIDE * CVOL_BRICK_SIDE)

/* Encodes a brick from its cells; the bytes replace the content of subbands[]. *error: the squared
 * error of all coefficients, in steps squared. Returns CVOL_OK, CVOL_ERROR_MEMORY, or
 * CVOL_ERROR_TARGET if the step is too small for a value; without a message. */
int cvol_brick_make(cvol_brick_maker *maker, cvol_bytes subbands[CVOL_SUBBANDS], double *error,
                    const cvol_brick_recipe *recipe, const float *cells, size_t brick);
/* Passes on the code of cvol_brick_make, with a message for an error. */
int cvol_brick_check(cvol_context *context, int code);
/* Adds the last brick's tokens to the counts. */
void cvol_brick_maker_count(const cvol_brick_maker *maker, cvol_token_counts *counts);
/* The terms of the last brick made with `kept`; owned by the maker, valid until its next use. */
cvol_brick_terms cvol_brick_maker_terms(const cvol_brick_maker *maker);
/* The cells of a brick from the slab's samples; owned by the maker, valid until its next use. */
const float *cvol_brick_cells(cvol_brick_maker *maker, const cvol_array *shape,
                              const cvol_slab *slab, size_t brick);

#endif
