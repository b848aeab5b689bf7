/* Samples around any place, from a small cache of evaluated blocks. */
#include "array/block/halo.h"

#include <math.h>
#include <string.h>

#include "array/block/block_transform.h"
#include "array/block/lapped.h"
#include "transform/block.h"

/* Blocks are stored by the last two bits of their number along each axis, so neighbours never
 * collide. */
enum { KEPT = 64 };

/* Lapped volumes: a box of at most three blocks, and two more samples on either side. */
enum { REGION_SIDE = 3 * 16 + 4, REGION = REGION_SIDE * REGION_SIDE * REGION_SIDE };

typedef struct halo {
    uint64_t owner[KEPT]; /* 1 + the block's index; 0: none */
} halo;

static size_t slots_of(const cvol_array *array)
{
    return (size_t)1 << 2 * array->rank;
}

static size_t floats_kept(const cvol_array *array)
{
    return slots_of(array) * ((cvol_array_block_terms(array) + 15) & ~(size_t)15);
}

size_t cvol_halo_bytes(const cvol_array *array)
{
    return sizeof(halo) + (floats_kept(array) + (array->lapped ? REGION : 0)) * sizeof(float);
}

/* The value of background samples, without the offset. */
static float background_of(const cvol_array *array)
{
    return (float)(cvol_array_background(array) - array->offset);
}

/* Sets the background samples of an evaluated block to their value. */
static void fill_block(float *samples, const cvol_array *array, size_t index)
{
    uint8_t which[CVOL_BLOCK_MAX * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX];
    size_t begin[3], end[3], size[3];
    cvol_block_origin(begin, array, index);
    for (int a = 0; a < 3; a++) {
        const size_t side = cvol_block_side(array, a), left = array->grid.dims[a] - begin[a];
        size[a] = left < side ? left : side;
        end[a] = begin[a] + size[a];
    }
    if (!cvol_mask_get(which, array->mask, begin, end))
        return;
    const float value = background_of(array);
    const size_t B = (size_t)array->block;
    for (size_t z = 0; z < size[2]; z++)
        for (size_t y = 0; y < size[1]; y++)
            for (size_t x = 0; x < size[0]; x++)
                if (which[x + size[0] * (y + size[1] * z)])
                    samples[x + B * (y + B * z)] = value;
}

/* The block's samples from the cache. With `fill`, those of its background have their value (plain
 * blocks only: the filter of lapped volumes comes first). */
static const float *block_samples(halo *h, const cvol_array *array, const size_t place[3], int fill)
{
    const size_t index = place[0] + array->blocks[0] * (place[1] + array->blocks[1] * place[2]);
    const size_t slot = (place[0] & 3) | (place[1] & 3) << 2 | (place[2] & 3) << 4;
    float *samples = (float *)(h + 1) + slot * ((cvol_array_block_terms(array) + 15) & ~(size_t)15);
    if (h->owner[slot] != index + 1) {
        cvol_block_evaluate(samples, array, index);
        if (fill)
            fill_block(samples, array, index);
        h->owner[slot] = index + 1;
    }
    return samples;
}

/* The index within 0 .. n - 1 that x is mirrored to. */
static size_t reflect(ptrdiff_t x, size_t n)
{
    const ptrdiff_t length = (ptrdiff_t)n;
    while (x < 0 || x >= length)
        x = x < 0 ? -1 - x : 2 * length - 1 - x;
    return (size_t)x;
}

static void read_plain(float *out, halo *h, const cvol_array *array, const ptrdiff_t begin[3],
                       const size_t size[3])
{
    size_t side[3], block[3][CVOL_HALO_MAX], local[3][CVOL_HALO_MAX];
    for (int a = 0; a < 3; a++) {
        side[a] = cvol_block_side(array, a);
        for (size_t i = 0; i < size[a]; i++) {
            const size_t x = reflect(begin[a] + (ptrdiff_t)i, array->grid.dims[a]);
            block[a][i] = x / side[a];
            local[a][i] = x % side[a];
        }
    }
    const float offset = (float)array->offset;
    const int fill = cvol_mask_is_background(array->mask);
    for (size_t z = 0; z < size[2]; z++)
        for (size_t y = 0; y < size[1]; y++) {
            float *row = out + size[0] * (y + size[1] * z);
            const size_t line = side[0] * (local[1][y] + side[1] * local[2][z]);
            for (size_t x = 0; x < size[0];) {
                const size_t place[3] = {block[0][x], block[1][y], block[2][z]};
                const float *from = block_samples(h, array, place, fill) + line;
                for (; x < size[0] && block[0][x] == place[0]; x++)
                    row[x] = from[local[0][x]] + offset;
            }
        }
}

/* ---- lapped volumes -------------------------------------------------------------------------- */

/* Copies a block's share of the region begin .. begin + size - 1. */
static void copy_block(float *region, halo *h, const cvol_array *array, const size_t place[3],
                       const size_t begin[3], const size_t size[3])
{
    const size_t B = (size_t)array->block;
    const float *from = block_samples(h, array, place, 0);
    size_t lo[3], hi[3];
    for (int a = 0; a < 3; a++) {
        const size_t first = place[a] * B, end = begin[a] + size[a];
        lo[a] = first > begin[a] ? first : begin[a];
        hi[a] = first + B < end ? first + B : end;
    }
    for (size_t z = lo[2]; z < hi[2]; z++)
        for (size_t y = lo[1]; y < hi[1]; y++)
            memcpy(region + lo[0] - begin[0] + size[0] * (y - begin[1] + size[1] * (z - begin[2])),
                   from + lo[0] % B + B * (y % B + B * (z % B)), (hi[0] - lo[0]) * sizeof *region);
}

/* Assembles the region that the read needs, filters it, and reads from it: with the offset and the
 * value of background samples, or of the terms alone. */
static void read_lapped(float *out, halo *h, const cvol_array *array, int only_terms,
                        const ptrdiff_t from[3], const size_t wanted[3])
{
    const float offset = only_terms ? 0 : (float)array->offset;
    const size_t B = (size_t)array->block;
    float *region = (float *)(h + 1) + floats_kept(array);
    size_t begin[3], end[3], size[3], place[3], at[3][REGION_SIDE];
    for (int a = 0; a < 3; a++) {
        begin[a] = end[a] = reflect(from[a], array->grid.dims[a]);
        for (size_t i = 0; i < wanted[a]; i++) {
            at[a][i] = reflect(from[a] + (ptrdiff_t)i, array->grid.dims[a]);
            begin[a] = at[a][i] < begin[a] ? at[a][i] : begin[a];
            end[a] = at[a][i] > end[a] ? at[a][i] : end[a];
        }
        end[a]++;
    }
    cvol_lapped_widen(begin, end, array);
    for (int a = 0; a < 3; a++)
        size[a] = end[a] - begin[a];
    for (place[2] = begin[2] / B; place[2] * B < end[2]; place[2]++)
        for (place[1] = begin[1] / B; place[1] * B < end[1]; place[1]++)
            for (place[0] = begin[0] / B; place[0] * B < end[0]; place[0]++)
                copy_block(region, h, array, place, begin, size);
    const size_t stride[3] = {1, size[0], size[0] * size[1]};
    cvol_lapped_filter(region, array, begin, size, stride);
    if (!only_terms && cvol_mask_is_background(array->mask)) {
        const float value = background_of(array);
        uint32_t bits;
        memcpy(&bits, &value, sizeof bits);
        const uint64_t patterns[CVOL_FILLS_MAX] = {bits};
        cvol_mask_write(region, sizeof value, patterns, array->mask, begin, end);
    }
    for (size_t z = 0; z < wanted[2]; z++)
        for (size_t y = 0; y < wanted[1]; y++) {
            const float *line = region + stride[1] * (at[1][y] - begin[1]) +
                                stride[2] * (at[2][z] - begin[2]);
            float *row = out + wanted[0] * (y + wanted[1] * z);
            for (size_t x = 0; x < wanted[0]; x++)
                row[x] = line[at[0][x] - begin[0]] + offset;
        }
}

/* ---- public ---------------------------------------------------------------------------------- */

void cvol_halo_read(float *out, void *memory, const cvol_array *array, const ptrdiff_t begin[3],
                    const size_t size[3])
{
    if (array->lapped)
        read_lapped(out, memory, array, 0, begin, size);
    else
        read_plain(out, memory, array, begin, size);
}

void cvol_halo_read_terms(float *out, void *memory, const cvol_array *array,
                          const ptrdiff_t begin[3], const size_t size[3])
{
    read_lapped(out, memory, array, 1, begin, size);
}

void cvol_halo_evaluate(float *out, void *memory, const cvol_array *array, size_t index)
{
    const size_t side[3] = {cvol_block_side(array, 0), cvol_block_side(array, 1),
                            cvol_block_side(array, 2)};
    size_t at[3];
    if (!array->lapped) {
        cvol_block_evaluate(out, array, index);
        return;
    }
    cvol_block_origin(at, array, index);
    const ptrdiff_t begin[3] = {(ptrdiff_t)at[0], (ptrdiff_t)at[1], (ptrdiff_t)at[2]};
    read_lapped(out, memory, array, 1, begin, side);
}

float cvol_halo_finish(float *slots, float *samples, const cvol_array *shape, size_t index)
{
    size_t at[3], side[3], inside[3];
    float most = 0;
    cvol_block_origin(at, shape, index);
    for (int a = 0; a < 3; a++) {
        const size_t left = shape->grid.dims[a] - at[a];
        side[a] = cvol_block_side(shape, a);
        inside[a] = left < side[a] ? left : side[a];
    }
    for (size_t z = 0; z < side[2]; z++)
        for (size_t y = 0; y < side[1]; y++) {
            float *row = samples + side[0] * (y + side[1] * z);
            const size_t from_y = y < inside[1] ? y : inside[1] - 1;
            const size_t from_z = z < inside[2] ? z : inside[2] - 1;
            if (from_y != y || from_z != z)
                memcpy(row, samples + side[0] * (from_y + side[1] * from_z), side[0] * sizeof *row);
            for (size_t x = 0; x < side[0]; x++) {
                row[x] = x < inside[0] ? row[x] : row[inside[0] - 1];
                most = fabsf(row[x]) > most ? fabsf(row[x]) : most;
            }
        }
    cvol_block_to_slots(slots, samples, shape);
    return most;
}
