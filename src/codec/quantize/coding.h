/* The coding of an array in a file: the codec's state of an array. Other folders do not use it; the
 * array frees and copies it through cvol_coding_ops (array/core/array.h). */
#ifndef CVOL_CODEC_QUANTIZE_CODING_H
#define CVOL_CODEC_QUANTIZE_CODING_H

#include "array/core/array.h"

/* A volume is coded in bricks of this many samples along each axis. `run` bricks in a row share a
 * checksum; at most CVOL_RUN_BRICKS. */
enum { CVOL_RUN_BRICKS = 16 };
typedef struct cvol_brick_shape {
    size_t side[3], run;
} cvol_brick_shape;

struct cvol_coded;

typedef struct cvol_file_coding {
    cvol_coding base; /* first: cvol_array.coding points to it */
    int trellis;      /* rank 3, DCT, B = 16: terms are results of trellis quantization, coded as
                         indices of about half their value (codec/quantize/trellis_states.h) */
    int neural; /* with trellis: coded by the networks of effort max (codec/neural/neural_code.h) */
    int true_length; /* rank 3, DCT, B = 16: cells that cross the volume's end are coded by DCTs
                        of their true length (codec/quantize/true_length.h), with a step
                        2^true_length times the array's; 0: not */
    cvol_brick_shape brick;
    struct cvol_coded *coded; /* the encoded bricks (codec/brick/coded.h), or NULL */
    void (*free_coded)(struct cvol_coded *coded);
} cvol_file_coding;

/* The coding of arrays that have none: usual bricks, other members 0. */
extern const cvol_file_coding cvol_coding_usual;

static inline const cvol_file_coding *cvol_coding_of(const cvol_array *array)
{
    return array->coding ? (const cvol_file_coding *)array->coding : &cvol_coding_usual;
}

/* Gives an array its own coding if it has none. Errors: MEMORY. */
int cvol_coding_need(cvol_context *context, cvol_array *array);
/* The coding of an array that has one, for changes. */
static inline cvol_file_coding *cvol_coding_own(cvol_array *array)
{
    return (cvol_file_coding *)array->coding;
}
/* Gives an array a copy of another's coding, without the encoded bricks. Errors: MEMORY. */
int cvol_coding_copy(cvol_context *context, cvol_array *array, const cvol_array *from);

#endif
