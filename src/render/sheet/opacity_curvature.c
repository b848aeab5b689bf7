/* Opacity curvature between neighbouring samples: see opacity_curvature.h. */
#include "render/sheet/opacity_curvature.h"

#include <math.h>

#include "array/core/array.h"
#include "base/memory.h"
#include "render/transfer/transfer.h"

/* The number of blocks that are sampled, evenly among the visible ones. */
#define BLOCKS 160
/* Samples next to a block's faces, which the filter of lapped arrays would still change. */
#define MARGIN 2
#define OPACITIES 1024

typedef struct opacities {
    float of[OPACITIES];
    float from, scale;
} opacities;

static void fill_opacities(opacities *out, const cvol_array *array, const cvol_transfer *transfer)
{
    const double lo = array->range_min, hi = array->range_max;
    for (int i = 0; i < OPACITIES; i++)
        out->of[i] =
            (float)cvol_transfer_at(transfer, lo + (hi - lo) * (i + 0.5) / OPACITIES).opacity;
    out->from = (float)(lo - array->offset);
    out->scale = (float)(OPACITIES / (hi - lo));
}

static inline float opacity_of(const opacities *table, float value)
{
    const float at = (value - table->from) * table->scale;
    return table->of[at > 0 ? at < OPACITIES ? (int)at : OPACITIES - 1 : 0];
}

typedef struct curvature {
    double squares, opacity;
    size_t count;
} curvature;

/* Adds the lines of a block along an axis whose samples lie `stride` apart; end: the end of the
 * sampled part. */
static void add_curvature(curvature *sum, const opacities *table, const float *samples, int block,
                          const int end[3], int stride)
{
    for (int z = MARGIN; z < end[2]; z += 2)
        for (int y = MARGIN; y < end[1]; y++)
            for (int x = MARGIN; x < end[0]; x++) {
                const float *at = samples + x + block * (y + block * z);
                const float here = opacity_of(table, at[0]);
                const float between = opacity_of(table, 0.5f * (at[-stride] + at[stride]));
                if (here <= 0 && between <= 0)
                    continue;
                sum->squares += (double)((here - between) * (here - between));
                sum->opacity += (double)here;
                sum->count++;
            }
}

/* Padding samples are don't-care. */
static void find_ends(int end[3], const cvol_array *array, size_t index)
{
    for (int a = 0; a < 3; a++) {
        const size_t first = index % array->blocks[a] * (size_t)array->block;
        const size_t inside = array->grid.dims[a] - first;
        index /= array->blocks[a];
        end[a] = (inside < (size_t)array->block ? (int)inside : array->block) - MARGIN;
    }
}

double cvol_opacity_curvature(const cvol_array *array, const cvol_transfer *transfer,
                              const cvol_visibility *visibility)
{
    const int block = array->block;
    opacities table;
    curvature sum = {0, 0, 0};
    size_t shown = 0, intersected = 0;
    if (!(array->range_max > array->range_min))
        return 0;
    float *samples = cvol_allocate(cvol_array_block_terms(array), sizeof *samples);
    if (!samples)
        return -1;
    fill_opacities(&table, array, transfer);
    for (size_t i = 0; i < array->block_count; i++)
        shown += cvol_visibility_of(visibility, &array->block_table[i]) != 0;
    for (size_t i = 0; i < array->block_count; i++) {
        if (!cvol_visibility_of(visibility, &array->block_table[i]))
            continue;
        const size_t before = intersected * BLOCKS / shown;
        if (++intersected * BLOCKS / shown == before)
            continue;
        int end[3];
        find_ends(end, array, i);
        cvol_block_evaluate(samples, array, i);
        for (int stride = 1; stride < block * block * block; stride *= block)
            add_curvature(&sum, &table, samples, block, end, stride);
    }
    free(samples);
    return sum.opacity > 0 ? sqrt(sum.squares * (double)sum.count) / sum.opacity : 0;
}
