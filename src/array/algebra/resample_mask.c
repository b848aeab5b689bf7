/* The mask of half or twice the samples: a sample has a value if all samples that it is made of
 * have one. See blocks_resample.c for those samples. */
#include <stdlib.h>

#include "array/algebra/mask_cells.h"
#include "array/algebra/result_mask.h"
#include "base/context.h"

enum { CELL = CVOL_MASK_CELL, MOST = 2 * CELL, ROOM = MOST * MOST * MOST };

/* The two samples of an axis of n samples that sample x of the result is made of, the lower one
 * first. */
static void sources(size_t out[2], size_t x, size_t n, int twice)
{
    out[0] = twice ? (x + 1) / 2 - (x > 0) : 2 * x;
    out[1] = twice ? (x + 1) / 2 : 2 * x + 1;
    out[1] = out[1] < n ? out[1] : n - 1;
}

/* One cell. in: room for ROOM samples. Returns 0 if memory is short. */
static int resample_cell(cvol_mask *out, const cvol_mask *mask, const cvol_mask_place *cell,
                         const size_t dims[3], int twice, uint8_t *in)
{
    size_t from[3][CELL][2], begin[3], end[3];
    for (int a = 0; a < 3; a++) {
        const size_t side = cell->end[a] - cell->begin[a];
        for (size_t i = 0; i < side; i++)
            sources(from[a][i], cell->begin[a] + i, dims[a], twice);
        begin[a] = from[a][0][0];
        end[a] = from[a][side - 1][1] + 1;
    }
    if (!cvol_mask_get(in, mask, begin, end))
        return 1;
    const size_t row = end[0] - begin[0], slice = row * (end[1] - begin[1]);
    uint8_t which[CVOL_MASK_CELL_SAMPLES], *to = which;
    for (size_t z = 0; z < cell->end[2] - cell->begin[2]; z++)
        for (size_t y = 0; y < cell->end[1] - cell->begin[1]; y++)
            for (size_t x = 0; x < cell->end[0] - cell->begin[0]; x++) {
                uint8_t fill = 0;
                for (int k = 0; k < 8 && !fill; k++)
                    fill = in[from[0][x][k & 1] - begin[0] +
                              row * (from[1][y][k >> 1 & 1] - begin[1]) +
                              slice * (from[2][z][k >> 2] - begin[2])];
                *to++ = fill;
            }
    return cvol_mask_set(out, which, cell->begin, cell->end);
}

int cvol_result_mask_resample(cvol_context *context, cvol_array *out, const cvol_array *a)
{
    if (!cvol_mask_is_void(a->mask))
        return CVOL_OK;
    int twice = 0, failed = 0;
    for (int axis = 0; axis < a->rank; axis++)
        twice = twice || out->grid.dims[axis] > a->grid.dims[axis];
    const cvol_fills fills = cvol_mask_result_fills(a);
    const size_t *dims = out->grid.dims;
    int code = cvol_mask_create(context, &out->mask, dims, &fills);
    if (code)
        return code;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        uint8_t *in = malloc(ROOM);
#pragma omp for schedule(dynamic, 64)
        for (size_t i = 0; i < cvol_mask_place_count(dims); i++) {
            const cvol_mask_place cell = cvol_mask_place_at(dims, i);
            if (!in || !resample_cell(out->mask, a->mask, &cell, a->grid.dims, twice, in)) {
#pragma omp atomic write
                failed = 1;
            }
        }
        free(in);
    }
    return failed ? cvol_mask_fail_memory(context)
                  : cvol_mask_set_fills(context, &out->mask, &fills);
}
