/* Samples around any place, from a small cache of evaluated blocks. */
#include "array/halo.h"

#include <math.h>
#include <string.h>

#include "array/block_transform.h"

/* Blocks are kept by the last two bits of their number along each axis: neighbours never collide.
 */
enum { KEPT = 64 };

typedef struct halo {
    uint64_t owner[KEPT]; /* 1 + the block's index; 0: none */
} halo;

static size_t slots_of(const cvol_array *array)
{
    return (size_t)1 << 2 * array->rank;
}

size_t cvol_halo_bytes(const cvol_array *array)
{
    return sizeof(halo) +
           slots_of(array) * ((cvol_array_block_terms(array) + 15) & ~(size_t)15) * sizeof(float);
}

static const float *block_samples(halo *h, const cvol_array *array, const size_t place[3])
{
    const size_t index = place[0] + array->blocks[0] * (place[1] + array->blocks[1] * place[2]);
    const size_t slot = (place[0] & 3) | (place[1] & 3) << 2 | (place[2] & 3) << 4;
    float *samples = (float *)(h + 1) + slot * ((cvol_array_block_terms(array) + 15) & ~(size_t)15);
    if (h->owner[slot] != index + 1) {
        cvol_block_evaluate(samples, array, index);
        h->owner[slot] = index + 1;
    }
    return samples;
}

/* The sample within 0 .. n - 1 that stands at x. */
static size_t reflect(long x, size_t n)
{
    const long length = (long)n;
    while (x < 0 || x >= length)
        x = x < 0 ? -1 - x : 2 * length - 1 - x;
    return (size_t)x;
}

void cvol_halo_read(float *out, void *memory, const cvol_array *array, const long begin[3],
                    const size_t size[3])
{
    halo *h = memory;
    size_t side[3], block[3][CVOL_HALO_MOST], local[3][CVOL_HALO_MOST];
    for (int a = 0; a < 3; a++) {
        side[a] = cvol_block_side(array, a);
        for (size_t i = 0; i < size[a]; i++) {
            const size_t x = reflect(begin[a] + (long)i, array->grid.dims[a]);
            block[a][i] = x / side[a];
            local[a][i] = x % side[a];
        }
    }
    const float offset = (float)array->offset;
    for (size_t z = 0; z < size[2]; z++)
        for (size_t y = 0; y < size[1]; y++) {
            float *row = out + size[0] * (y + size[1] * z);
            const size_t line = side[0] * (local[1][y] + side[1] * local[2][z]);
            for (size_t x = 0; x < size[0];) {
                const size_t place[3] = {block[0][x], block[1][y], block[2][z]};
                const float *from = block_samples(h, array, place) + line;
                for (; x < size[0] && block[0][x] == place[0]; x++)
                    row[x] = from[local[0][x]] + offset;
            }
        }
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
