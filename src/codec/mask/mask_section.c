/* Converts masks of arrays to bricks and back. */
#include "codec/mask/mask_section.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/brick/brick_stream.h"
#include "codec/mask/mask_code.h"

/* The cells of a brick. */
typedef struct brick_cells {
    size_t first[3], count[3];
} brick_cells;

static brick_cells cells_of(const cvol_box *box)
{
    brick_cells cells;
    for (int a = 0; a < 3; a++) {
        cells.first[a] = box->begin[a] / CVOL_MASK_CELL;
        cells.count[a] = (box->end[a] - box->begin[a] - 1) / CVOL_MASK_CELL + 1;
    }
    return cells;
}

static void take_shape(cvol_mask_brick *brick, const cvol_box *box, const cvol_mask *mask)
{
    for (int a = 0; a < 3; a++)
        brick->size[a] = box->end[a] - box->begin[a];
    brick->fills = cvol_mask_fills(mask)->count;
}

static void gather(cvol_mask_brick *brick, const cvol_mask *mask, const cvol_box *box)
{
    const brick_cells cells = cells_of(box);
    size_t planes = 0;
    take_shape(brick, box, mask);
    while (brick->fills >> planes)
        planes++;
    for (size_t l = 0; l < cells.count[2]; l++)
        for (size_t j = 0; j < cells.count[1]; j++)
            for (size_t i = 0; i < cells.count[0]; i++) {
                const size_t place[3] = {cells.first[0] + i, cells.first[1] + j,
                                         cells.first[2] + l};
                const cvol_mask_rows *rows;
                brick->states[l][j][i] = cvol_mask_cell_get(mask, place, &rows);
                if (brick->states[l][j][i] == CVOL_MASK_MIXED)
                    memcpy(brick->rows[l][j][i], rows, planes * sizeof *rows);
            }
}

/* Returns 0 when memory is short. */
static int scatter(cvol_mask *mask, const cvol_mask_brick *brick, const cvol_box *box)
{
    const brick_cells cells = cells_of(box);
    int done = 1;
    for (size_t l = 0; l < cells.count[2]; l++)
        for (size_t j = 0; j < cells.count[1]; j++)
            for (size_t i = 0; i < cells.count[0]; i++) {
                const size_t place[3] = {cells.first[0] + i, cells.first[1] + j,
                                         cells.first[2] + l};
                done &= cvol_mask_cell_put(mask, place, brick->states[l][j][i],
                                           brick->rows[l][j][i]);
            }
    return done;
}

static int code_brick(cvol_range_encoder *coder, cvol_bytes *out, cvol_mask_brick *brick,
                      const cvol_array *array, size_t number)
{
    const cvol_box box = cvol_brick_samples_of(array, number);
    gather(brick, array->mask, &box);
    return cvol_mask_encode(coder, out, brick);
}

int cvol_mask_put_brick(cvol_range_encoder *coder, cvol_bytes *out, const cvol_array *array,
                        size_t brick)
{
    cvol_mask_brick *cells = cvol_allocate(1, sizeof *cells);
    const int done = cells && code_brick(coder, out, cells, array, brick);
    free(cells);
    return done;
}

int cvol_mask_measure(cvol_context *context, uint64_t *bytes, const cvol_array *array)
{
    const size_t bricks = array->mask ? cvol_brick_count(array) : 0;
    uint64_t sum = 0;
    int failed = 0;
#pragma omp parallel num_threads(cvol_context_threads(context)) reduction(+ : sum)
    {
        cvol_mask_brick *cells = cvol_allocate(1, sizeof *cells);
        cvol_range_encoder coder = {0};
        cvol_bytes brick = {0};
#pragma omp for schedule(dynamic)
        for (size_t b = 0; b < bricks; b++) {
            if (!cells || !code_brick(&coder, &brick, cells, array, b)) {
#pragma omp atomic write
                failed = 1;
            }
            sum += brick.size;
        }
        free(cells);
        cvol_bytes_free(&brick);
        cvol_range_encoder_free(&coder);
    }
    *bytes = sum;
    return failed ? cvol_fail_memory(context, sizeof(cvol_mask_brick), "a mask") : CVOL_OK;
}

static int take_brick(const cvol_array *array, cvol_mask_brick *cells, cvol_span bytes,
                      size_t brick)
{
    const cvol_box box = cvol_brick_samples_of(array, brick);
    if (!bytes.size)
        return CVOL_OK;
    take_shape(cells, &box, array->mask);
    if (!cvol_mask_decode(cells, bytes))
        return CVOL_ERROR_CORRUPT;
    return scatter(array->mask, cells, &box) ? CVOL_OK : CVOL_ERROR_MEMORY;
}

int cvol_mask_take(cvol_context *context, cvol_array *array, const cvol_fills *fills,
                   const cvol_brick_index *index, const cvol_section *section, const cvol_box *box,
                   const char *name)
{
    int code = cvol_brick_stream_check(context, array, index, CVOL_STREAM_MASK, section, box, name);
    if (!code)
        code = cvol_mask_create(context, &array->mask, array->grid.dims, fills);
    if (code)
        return code;
    int failed = CVOL_OK;
    size_t where = SIZE_MAX;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        cvol_mask_brick *cells = cvol_allocate(1, sizeof *cells);
#pragma omp for schedule(dynamic)
        for (size_t b = 0; b < index->bricks; b++) {
            if (!cvol_brick_intersects(array, b, box))
                continue;
            const cvol_span bytes = cvol_brick_index_brick(index, CVOL_STREAM_MASK, b,
                                                           section->content);
            const int result = cells ? take_brick(array, cells, bytes, b) : CVOL_ERROR_MEMORY;
            if (result) {
#pragma omp critical
                if (b < where) {
                    where = b;
                    failed = result;
                }
            }
        }
        free(cells);
    }
    if (failed == CVOL_ERROR_CORRUPT)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section MASK: brick %zu of %zu is damaged", name, where,
                         index->bricks);
    return failed ? cvol_fail_memory(context, sizeof(cvol_mask_brick), "a mask") : CVOL_OK;
}
