/* From the samples of a result to its blocks: result_block.h. */
#include "array/truncate/result_block.h"

#include <math.h>
#include <string.h>

#include "array/block/block_transform.h"
#include "array/block/cell_weight.h"
#include "transform/cell.h"
#include "transform/lap.h"

/* Samples on either side of a block that the pre-filter mixes with it. */
enum { REACH = 2, AROUND = CVOL_CELL + 2 * REACH, AROUND_SAMPLES = AROUND * AROUND * AROUND };

/* A split is chosen if its weight is below this share of the weight of the coarser split. */
#define CELL_SHARE 0.87f
#define OCTANT_SHARE 0.9f

static size_t round_up(size_t floats)
{
    return (floats + 15) & ~(size_t)15;
}

size_t cvol_result_box(ptrdiff_t begin[3], size_t size[3], const cvol_array *shape, size_t index)
{
    const size_t margin = shape->lapped ? REACH : 0;
    size_t at[3];
    cvol_block_origin(at, shape, index);
    for (int a = 0; a < 3; a++) {
        begin[a] = (ptrdiff_t)at[a] - (ptrdiff_t)margin;
        size[a] = cvol_block_side(shape, a) + 2 * margin;
    }
    return size[0] * size[1] * size[2];
}

size_t cvol_result_box_room(const cvol_array *shape)
{
    return round_up(shape->lapped ? AROUND_SAMPLES : cvol_array_block_terms(shape));
}

static int may_split(const cvol_array *shape)
{
    return cvol_array_is_volume(shape) && shape->block == CVOL_CELL;
}

/* The samples of a block, and the transforms of its two uniform splits. */
size_t cvol_result_scratch(const cvol_array *shape)
{
    return round_up(cvol_array_block_terms(shape)) + (may_split(shape) ? 2 * CVOL_CELL_SAMPLES : 0);
}

/* A step over the loss of a sample that it causes: sqrt(12) if all coefficients are larger than the
 * step, more if most are smaller. */
#define TYPICAL_STEP 7

double cvol_result_expected_step(const cvol_array *shape, double loss)
{
    const double hidden = shape->mask ? (double)cvol_mask_samples(shape->mask) : 0;
    return TYPICAL_STEP * loss / sqrt(fmax((double)cvol_grid_samples(&shape->grid) - hidden, 1));
}

/* ---- samples --------------------------------------------------------------------------------- */

/* Pre-filters the samples around a block. */
static void filter_around(float *around, const cvol_array *shape, const ptrdiff_t begin[3])
{
    cvol_lap_box box = {.grid = CVOL_CELL};
    for (int a = 0; a < 3; a++) {
        box.shape[a] = (int64_t)shape->grid.dims[a];
        box.begin[a] = begin[a];
        box.size[a] = AROUND;
        box.stride[a] = a == 0 ? 1 : a == 1 ? AROUND : AROUND * AROUND;
    }
    for (int a = 0; a < 3; a++)
        cvol_lap_pre(around, &box, a);
}

/* The largest magnitude of the block's samples within the volume. */
static float largest(const float *samples, const size_t size[3], size_t margin,
                     const size_t inside[3])
{
    float most = 0;
    for (size_t z = 0; z < inside[2]; z++)
        for (size_t y = 0; y < inside[1]; y++) {
            const float *row = samples + margin + size[0] * (y + margin + size[1] * (z + margin));
            for (size_t x = 0; x < inside[0]; x++)
                most = fabsf(row[x]) > most ? fabsf(row[x]) : most;
        }
    return most;
}

/* Copies the block; beyond the volume the last sample repeats. */
static void pad(float *block, const float *samples, const size_t size[3], size_t margin,
                const cvol_array *shape, const size_t inside[3])
{
    for (size_t z = 0; z < cvol_block_side(shape, 2); z++)
        for (size_t y = 0; y < cvol_block_side(shape, 1); y++) {
            const size_t from_y = y < inside[1] ? y : inside[1] - 1;
            const size_t from_z = z < inside[2] ? z : inside[2] - 1;
            const float *from = samples + margin +
                                size[0] * (from_y + margin + size[1] * (from_z + margin));
            for (size_t x = 0; x < cvol_block_side(shape, 0); x++)
                *block++ = from[x < inside[0] ? x : inside[0] - 1];
        }
}

/* ---- splits ---------------------------------------------------------------------------------- */

/* The split by the weights of each octant (split_fast.h). `whole` is transformed already. */
static uint16_t choose_split(const float *whole, float *eights, float *fours, const float *samples,
                             float inverse)
{
    float weights[8], octants[8], quarters[8];
    float coarser = CVOL_SUB_BLOCK_COST, finer = CVOL_CELL_COST;
    uint16_t split = CVOL_CELL_OCTANTS;
    cvol_cell_weigh(weights, whole, inverse, 1);
    for (int i = 0; i < 8; i++)
        coarser += weights[i];
    if (coarser < CVOL_SUB_BLOCK_COST + CVOL_LAMBDA * CVOL_SPLIT_BITS_MIN)
        return CVOL_CELL_WHOLE;
    cvol_cell_forward(eights, samples, CVOL_CELL_OCTANTS);
    cvol_cell_forward(fours, samples, CVOL_CELL_FOURS);
    cvol_cell_weigh(octants, eights, inverse, 2);
    cvol_cell_weigh(quarters, fours, inverse, 4);
    for (int i = 0; i < 8; i++) {
        finer += quarters[i] < octants[i] ? quarters[i] : octants[i];
        if (quarters[i] + CVOL_OCTANT_COST <= OCTANT_SHARE * (octants[i] + CVOL_SUB_BLOCK_COST))
            split |= (uint16_t)(2u << i);
    }
    return finer <= CELL_SHARE * coarser ? split : CVOL_CELL_WHOLE;
}

/* Split octants come from the fours, others from the eights. */
static void mix(float *out, const float *eights, const float *fours, uint16_t split)
{
    for (int place = 0; place < CVOL_CELL_SAMPLES; place++) {
        const int octant = (place & 1) | (place >> 3 & 2) | (place >> 6 & 4);
        out[place] = split >> (1 + octant) & 1 ? fours[place] : eights[place];
    }
}

void cvol_result_transform(cvol_dense_block *out, const float *samples, float *scratch,
                           const cvol_array *shape)
{
    out->split = CVOL_CELL_WHOLE;
    cvol_block_to_slots(out->coefficients, samples, shape);
    if (!may_split(shape) || !(out->expected_step > 0))
        return;
    float *eights = scratch, *fours = scratch + CVOL_CELL_SAMPLES;
    out->split = choose_split(out->coefficients, eights, fours, samples, 1 / out->expected_step);
    if (out->split)
        mix(out->coefficients, eights, fours, out->split);
}

void cvol_result_put(cvol_dense_block *out, float *samples, float *scratch, const cvol_array *shape,
                     size_t index)
{
    const size_t margin = shape->lapped ? REACH : 0;
    size_t at[3], size[3], inside[3];
    ptrdiff_t begin[3];
    (void)cvol_result_box(begin, size, shape, index);
    cvol_block_origin(at, shape, index);
    for (int a = 0; a < 3; a++) {
        const size_t left = shape->grid.dims[a] - at[a], side = cvol_block_side(shape, a);
        inside[a] = left < side ? left : side;
    }
    out->max_abs = largest(samples, size, margin, inside);
    if (margin)
        filter_around(samples, shape, begin);
    pad(scratch, samples, size, margin, shape, inside);
    cvol_result_transform(out, scratch, scratch + round_up(cvol_array_block_terms(shape)), shape);
}
