/* Chooses the shape of bricks if the options state none. A plane needs all bricks that it meets, so
 * each axis should have many bricks. A brick costs two dozen bytes for lengths, ends of streams and
 * checksums, and its first cells have less context than cells in the middle of a larger brick:
 * below about 2 kB per brick this costs more than 1 %. Small files are read fast anyway, and keep
 * the usual shape. */
#include "codec/rate/brick_choice.h"

#include "codec/brick/brick_shape.h"
#include "codec/rate/target.h"

enum { UNIT = 16, LAYERS = 9, BRICK_BYTES = 2048, SMALL_FILE = 2 << 20 };

/* The target as a ratio of raw to file bytes, if the target is a size; else 0. */
static double ratio_of(const cvol_grid *grid, const cvol_compress_options *options)
{
    if (cvol_compress_needs_residual(options))
        return 0;
    if (options->target == CVOL_TARGET_RATIO)
        return options->target_value;
    return options->target == CVOL_TARGET_BITS
               ? 8 * (double)cvol_type_size(grid->type) / options->target_value
               : 0;
}

/* Samples of a brick within the volume. */
static double samples_of(const cvol_brick_shape *brick, const cvol_grid *grid)
{
    double samples = 1;
    for (int a = 0; a < 3; a++)
        samples *= (double)(brick->side[a] < grid->dims[a] ? brick->side[a] : grid->dims[a]);
    return samples;
}

cvol_brick_shape cvol_brick_shape_choose(const cvol_grid *grid,
                                         const cvol_compress_options *options)
{
    cvol_brick_shape brick = cvol_brick_shape_make(options->brick);
    const double ratio = ratio_of(grid, options);
    if (options->brick[0] || options->effort == CVOL_EFFORT_MAX || options->block != UNIT ||
        !(ratio > 0) || (double)cvol_grid_bytes(grid) / ratio < SMALL_FILE)
        return brick;
    brick.run = 1;
    for (int a = 0; a < 3; a++)
        while (brick.side[a] > UNIT && grid->dims[a] <= (LAYERS - 1) * brick.side[a])
            brick.side[a] -= UNIT;
    while (samples_of(&brick, grid) * (double)cvol_type_size(grid->type) < ratio * BRICK_BYTES) {
        int most = -1; /* the axis with most bricks */
        for (int a = 0; a < 3; a++)
            if (brick.side[a] < CVOL_BRICK_SIDE &&
                (most < 0 || grid->dims[a] * brick.side[most] > grid->dims[most] * brick.side[a]))
                most = a;
        if (most < 0)
            break;
        brick.side[most] += UNIT;
    }
    return brick;
}
