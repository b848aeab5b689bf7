/* The codec's state of an array. */
#include "codec/quantize/coding.h"

#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"

static void destroy(cvol_coding *coding)
{
    cvol_file_coding *own = (cvol_file_coding *)coding;
    if (own->coded)
        own->free_coded(own->coded);
    free(own);
}

static cvol_coding *make(const cvol_coding *bricks, const cvol_coding *terms)
{
    const cvol_file_coding *shape = bricks ? (const cvol_file_coding *)bricks : &cvol_coding_usual;
    const cvol_file_coding *as = terms ? (const cvol_file_coding *)terms : &cvol_coding_usual;
    cvol_file_coding *coding = cvol_allocate_zero(1, sizeof *coding);
    if (!coding)
        return NULL;
    coding->base = cvol_coding_usual.base;
    coding->brick = shape->brick;
    coding->trellis = as->trellis;
    coding->true_length = as->true_length;
    return &coding->base;
}

static void brick_sides(size_t side[3], const cvol_coding *coding)
{
    for (int a = 0; a < 3; a++)
        side[a] = ((const cvol_file_coding *)coding)->brick.side[a];
}

static int finer_bits(const cvol_coding *coding)
{
    return ((const cvol_file_coding *)coding)->true_length;
}

static const cvol_coding_ops ops = {destroy, make, brick_sides, finer_bits};

const cvol_file_coding cvol_coding_usual = {
    .base = {&ops},
    .brick = {{CVOL_BRICK_SIDE, CVOL_BRICK_SIDE, CVOL_BRICK_SIDE}, CVOL_RUN_BRICKS}};

int cvol_coding_need(cvol_context *context, cvol_array *array)
{
    if (!array->coding)
        array->coding = make(NULL, NULL);
    return array->coding ? CVOL_OK
                         : cvol_fail_memory(context, sizeof(cvol_file_coding), "an array's coding");
}

int cvol_coding_copy(cvol_context *context, cvol_array *array, const cvol_array *from)
{
    const int code = cvol_coding_need(context, array);
    if (code)
        return code;
    cvol_file_coding *own = cvol_coding_own(array);
    const cvol_file_coding *as = cvol_coding_of(from);
    own->trellis = as->trellis;
    own->neural = as->neural;
    own->true_length = as->true_length;
    own->brick = as->brick;
    return CVOL_OK;
}
