/* How an array is coded in a file: what the codec keeps with an array. No other room knows it; the
 * array frees and copies it through cvol_coding_ops (array/core/array.h).
 */
#ifndef CVOL_CODEC_QUANTIZE_CODING_H
#define CVOL_CODEC_QUANTIZE_CODING_H

#include "array/core/array.h"

/* A volume is coded in bricks of this many samples along each axis. `run` bricks in a row share a
 * checksum, CVOL_RUN_BRICKS at most. */
enum { CVOL_RUN_BRICKS = 16 };
typedef struct cvol_brick_shape {
    size_t side[3], run;
} cvol_brick_shape;

struct cvol_coded;

typedef struct cvol_file_coding {
    cvol_coding base; /* first: cvol_array.coding points to it */
    int trellis;      /* rank 3, DCT, B = 16: terms may be coded by half of what they are, as
                           trellis quantization chose them (codec/quantize/trellis_states.h) */
    int neural; /* trellis: coded by the networks of maximum effort (codec/neural/neural_code.h) */
    int true_length; /* rank 3, DCT, B = 16: cells that the volume ends in may be coded by DCTs of
                 their true length (codec/quantize/true_length.h), with a step 2^ends times the
                 array's; 0: not */
    cvol_brick_shape brick;
    struct cvol_coded *coded; /* the bricks as they were coded (codec/brick/coded.h), or NULL */
    void (*free_coded)(struct cvol_coded *coded);
} cvol_file_coding;

/* That of arrays without any: usual bricks, all else 0. */
extern const cvol_file_coding cvol_coding_usual;

static inline const cvol_file_coding *cvol_coding_of(const cvol_array *array)
{
    return array->coding ? (const cvol_file_coding *)array->coding : &cvol_coding_usual;
}

/* Gives an array a coding of its own if it has none. Errors: MEMORY. */
int cvol_coding_need(cvol_context *context, cvol_array *array);
/* The coding of an array that has one, to be changed. */
static inline cvol_file_coding *cvol_coding_own(cvol_array *array)
{
    return (cvol_file_coding *)array->coding;
}
/* Gives an array the coding of another one, without the coded bricks. Errors: MEMORY. */
int cvol_coding_copy(cvol_context *context, cvol_array *array, const cvol_array *from);

#endif
