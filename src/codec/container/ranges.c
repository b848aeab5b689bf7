/* Block ranges: coarsening, writing and reading. */
#include "codec/container/ranges.h"

#include <math.h>
#include <stdlib.h>
#include <zstd.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/section/packed.h"

enum { CELL_SIDE = 16, ZSTD_LEVEL = 19 };

/* The grid of cells. */
typedef struct cell_grid {
    size_t cells[3], count, blocks_per_cell; /* blocks_per_cell: along each axis */
} cell_grid;

static cell_grid cell_grid_of(const cvol_array *array)
{
    cell_grid grid = {.count = 1};
    grid.blocks_per_cell = array->block < CELL_SIDE ? (size_t)(CELL_SIDE / array->block) : 1;
    for (int a = 0; a < 3; a++) {
        grid.cells[a] = (array->blocks[a] - 1) / grid.blocks_per_cell + 1;
        grid.count *= grid.cells[a];
    }
    return grid;
}

static size_t cell_of(const cell_grid *grid, const cvol_array *array, size_t block)
{
    const size_t i = block % array->blocks[0], j = block / array->blocks[0] % array->blocks[1],
                 l = block / array->blocks[0] / array->blocks[1];
    return i / grid->blocks_per_cell +
           grid->cells[0] *
               (j / grid->blocks_per_cell + grid->cells[1] * (l / grid->blocks_per_cell));
}

/* Takes the minimum of the lower and the maximum of the upper codes of a cell: codes[0 .. count)
 * and the rest. */
static void unite(uint8_t *codes, const cell_grid *grid, const cvol_array *array)
{
    uint8_t *lower = codes, *upper = codes + grid->count;
    for (size_t c = 0; c < grid->count; c++) {
        lower[c] = 255;
        upper[c] = 0;
    }
    for (size_t b = 0; b < array->block_count; b++) {
        const uint8_t *range = array->block_table[b].range;
        size_t c = cell_of(grid, array, b);
        lower[c] = range[0] < lower[c] ? range[0] : lower[c];
        upper[c] = range[1] > upper[c] ? range[1] : upper[c];
    }
}

/* Rounds outwards to multiples of the largest power of two within 1/8 of the width. */
static void coarsen(uint8_t *lower, uint8_t *upper)
{
    int width = *upper - *lower, grain = 1;
    while (grain <= width / 16)
        grain *= 2;
    int up = (*upper + grain - 1) / grain * grain;
    *lower = (uint8_t)(*lower / grain * grain);
    *upper = (uint8_t)(up > 255 ? 255 : up);
}

static void spread(cvol_array *array, const uint8_t *codes, const cell_grid *grid)
{
    for (size_t b = 0; b < array->block_count; b++) {
        size_t c = cell_of(grid, array, b);
        array->block_table[b].range[0] = codes[c];
        array->block_table[b].range[1] = codes[grid->count + c];
    }
}

static int coarsen_all(cvol_context *context, cvol_array *array)
{
    const cell_grid grid = cell_grid_of(array);
    uint8_t *codes = cvol_allocate(2 * grid.count, 1);
    if (!codes)
        return cvol_fail_memory(context, 2 * grid.count, "block ranges");
    unite(codes, &grid, array);
    for (size_t c = 0; c < grid.count; c++)
        coarsen(&codes[c], &codes[grid.count + c]);
    spread(array, codes, &grid);
    free(codes);
    return CVOL_OK;
}

int cvol_ranges_find(cvol_context *context, cvol_array *array)
{
    int code = cvol_array_ensure_ranges(context, array);
    return code ? code : coarsen_all(context, array);
}

int cvol_ranges_put(cvol_context *context, cvol_bytes *out, const cvol_array *array)
{
    const cell_grid grid = cell_grid_of(array);
    const size_t size = 2 * grid.count, bound = ZSTD_compressBound(size);
    uint8_t *codes = cvol_allocate(size, 1);
    cvol_bytes_put_f64(out, array->range_min);
    cvol_bytes_put_f64(out, array->range_max);
    if (!codes || !cvol_bytes_reserve(out, bound)) {
        free(codes);
        return cvol_fail_memory(context, size + bound, "block ranges");
    }
    unite(codes, &grid, array);
    for (size_t c = 0; c < grid.count; c++) /* widths vary less than upper bounds */
        codes[grid.count + c] = (uint8_t)(codes[grid.count + c] - codes[c]);
    size_t packed = cvol_zstd_put(out->data + out->size, bound, codes, size, ZSTD_LEVEL);
    free(codes);
    if (ZSTD_isError(packed))
        return cvol_fail_memory(context, size, "block ranges");
    out->size += packed;
    return CVOL_OK;
}

/* Reads the two ends of the code range. */
static int take_ends(cvol_context *context, cvol_array *array, cvol_cursor *content,
                     const char *name)
{
    const double lo = cvol_cursor_f64(content), hi = cvol_cursor_f64(content);
    /* A NaN must fail. */
    if (content->failed || !isfinite(lo) || !(lo <= hi) || !isfinite(hi - lo))
        return cvol_fail(
            context, CVOL_ERROR_CORRUPT,
            "%s: section RNGE: range_min is %g and range_max %g, must be finite and in "
            "order",
            name, lo, hi);
    array->range_min = lo;
    array->range_max = hi;
    return CVOL_OK;
}

int cvol_ranges_take(cvol_context *context, cvol_array *array, const cvol_section *section,
                     const char *name)
{
    const cell_grid grid = cell_grid_of(array);
    const size_t size = 2 * grid.count;
    cvol_cursor content = cvol_section_cursor(section);
    int code = take_ends(context, array, &content, name);
    if (code)
        return code;
    const size_t left = cvol_cursor_left(&content);
    uint8_t *codes = cvol_allocate(size, 1);
    if (!codes)
        return cvol_fail_memory(context, size, "block ranges");
    code = cvol_zstd_take(codes, size, cvol_cursor_take(&content, left), left);
    int sound = !code;
    for (size_t c = 0; c < grid.count && sound; c++) {
        sound = codes[c] + codes[grid.count + c] <= 255;
        codes[grid.count + c] = (uint8_t)(codes[grid.count + c] + codes[c]);
    }
    if (sound)
        spread(array, codes, &grid);
    array->has_ranges = sound;
    free(codes);
    if (code == CVOL_ERROR_MEMORY)
        return cvol_fail_memory(context, size, "unpacking block ranges");
    if (!sound)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section RNGE does not hold the ranges of %zu cells", name,
                         grid.count);
    return CVOL_OK;
}
