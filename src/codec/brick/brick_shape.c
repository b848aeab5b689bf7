/* Valid shapes of bricks. */
#include "codec/brick/brick_shape.h"

#include "base/context.h"
#include "codec/quantize/coding.h"

enum { UNIT = 16 };

cvol_brick_shape cvol_brick_shape_make(const int side[3])
{
    cvol_brick_shape brick = {{CVOL_BRICK_SIDE, CVOL_BRICK_SIDE, CVOL_BRICK_SIDE}, CVOL_RUN_BRICKS};
    if (!side[0] && !side[1] && !side[2])
        return brick;
    for (int a = 0; a < 3; a++)
        brick.side[a] = (size_t)side[a];
    if (!cvol_brick_shape_is_usual(&brick))
        brick.run = 1;
    return brick;
}

int cvol_brick_shape_is_usual(const cvol_brick_shape *brick)
{
    return brick->side[0] == CVOL_BRICK_SIDE && brick->side[1] == CVOL_BRICK_SIDE &&
           brick->side[2] == CVOL_BRICK_SIDE && brick->run == CVOL_RUN_BRICKS;
}

int cvol_brick_side_is_valid(uint64_t side, int block)
{
    return side >= UNIT && side <= CVOL_BRICK_SIDE && side % UNIT == 0 && block > 0 &&
           side % (uint64_t)block == 0;
}

int cvol_brick_sides_check(cvol_context *context, const int side[3], int block)
{
    if (!side[0] && !side[1] && !side[2])
        return CVOL_OK;
    for (int a = 0; a < 3; a++)
        if (side[a] < 0 || !cvol_brick_side_is_valid((uint64_t)side[a], block))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "a brick's side along %c is %d, must be 16, 32, 48 or 64, and a "
                             "multiple of the block, %d",
                             "xyz"[a], side[a], block);
    return CVOL_OK;
}
