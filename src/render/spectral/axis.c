/* Matrices from a tile's coefficients to the places over which its samples are spread: inverse
 * transform and footprint in one (axis.h). */
#include "render/spectral/axis.h"

#include <string.h>

#include "render/spectral/tile.h"
#include "transform/block.h"

/* G[p][u] of a tile with this number of samples. */
static void fill(float *out, const cvol_compose_job *job, const cvol_tile_axis *axis, int samples)
{
    const int B = job->baked->tile, width = B < 16 ? 16 : B;
    const float *columns = cvol_block_columns(B);
    const cvol_intermediate_line *line = &axis->line;
    const ptrdiff_t step = (ptrdiff_t)job->image_grid->step;
    memset(out, 0, (size_t)(axis->places * B) * sizeof *out);
    for (int p = 0; p < axis->places; p++)
        for (int q = line->low; q <= line->high; q++) {
            /* the sample with this weight at the place */
            const ptrdiff_t x = (axis->first + p) * step - line->place - q;
            const float weight = (float)line->weights[q - line->low];
            if (x >= 0 && x < samples)
                for (int u = 0; u < B; u++)
                    out[p * B + u] += weight * columns[x * width + u];
        }
}

/* Transposes to rows of frequencies. */
static void turn(float *out, const float *in, int places, int B, int width)
{
    for (int u = 0; u < B; u++)
        for (int p = 0; p < places; p++)
            out[u * width + p] = in[p * B + u];
}

static int same_weights(const cvol_intermediate_line *a, const cvol_intermediate_line *b,
                        ptrdiff_t step)
{
    return (a->place - b->place) % step == 0 && a->low == b->low && a->high == b->high &&
           !memcmp(a->weights, b->weights, sizeof a->weights);
}

static ptrdiff_t ceil_divide(ptrdiff_t a, ptrdiff_t b)
{
    return a > 0 ? (a + b - 1) / b : -(-a / b);
}

void cvol_tile_axis_make(cvol_tile_axis *axis, const cvol_compose_job *job, int width, int a,
                         size_t k)
{
    const int B = job->baked->tile;
    const ptrdiff_t step = (ptrdiff_t)job->image_grid->step;
    const cvol_intermediate_line line = cvol_intermediate_line_make(job->image_grid, job->shape, a,
                                                                    k);
    const int made = axis->places > 0 && same_weights(&line, &axis->line, step);
    axis->line = line;
    axis->first = ceil_divide(line.place + line.low, step);
    axis->places = (int)((line.place + B - 1 + line.high) / step - axis->first + 1);
    if (made)
        return;
    const int rest = (int)((job->baked->samples[a] - 1) % (size_t)B) + 1;
    float columns[CVOL_TILE_PLACES * CVOL_BLOCK_MAX];
    for (int which = 0; which < (rest < B ? 2 : 1); which++) {
        fill(columns, job, axis, which ? rest : B);
        turn(which ? axis->last : axis->whole, columns, axis->places, B, width);
    }
}
