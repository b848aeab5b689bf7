/* Compressed arrays: making, owning and describing them. */
#include "array/array.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "transform/block.h"

static int block_log2_of(int block)
{
    return block == 8 ? 3 : block == 16 ? 4 : block == 32 ? 5 : 0;
}

int cvol_array_create(cvol_context *context, cvol_array **out, const cvol_grid *grid, int block)
{
    *out = NULL;
    if (!block_log2_of(block))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "block is %d, must be 8, 16 or 32", block);
    int code = cvol_grid_check(context, grid, "array");
    if (code)
        return code;
    cvol_array *array = calloc(1, sizeof *array);
    if (!array)
        return cvol_fail_memory(context, sizeof *array, "an array");
    array->grid = *grid;
    array->transform = CVOL_DCT;
    array->block = block;
    array->block_log2 = block_log2_of(block);
    array->step = 1;
    array->psnr_db = (double)INFINITY;
    array->block_count = 1;
    for (int a = 0; a < 3; a++) {
        array->blocks[a] = (grid->dims[a] - 1) / (size_t)block + 1;
        array->block_count *= array->blocks[a];
    }
    array->block_table = cvol_allocate_zero(array->block_count, sizeof *array->block_table);
    if (!array->block_table) {
        code = cvol_fail_memory(context, array->block_count * sizeof *array->block_table,
                                "the block table");
        cvol_array_free(array);
        return code;
    }
    *out = array;
    return CVOL_OK;
}

void cvol_array_free(cvol_array *array)
{
    if (!array)
        return;
    for (size_t i = 0; i < array->pool_count; i++)
        free(array->pools[i]);
    free(array->pools);
    free(array->block_table);
    free(array);
}

int cvol_array_adopt_pool(cvol_context *context, cvol_array *array, uint32_t *terms, size_t words)
{
    if (array->pool_count == array->pool_capacity) {
        size_t capacity = 2 * array->pool_capacity + 16;
        uint32_t **pools = realloc(array->pools, capacity * sizeof *pools);
        if (!pools)
            return cvol_fail_memory(context, capacity * sizeof *pools, "the coefficients");
        array->pools = pools;
        array->pool_capacity = capacity;
    }
    array->pools[array->pool_count++] = terms;
    array->pool_words += words;
    return CVOL_OK;
}

const cvol_grid *cvol_array_grid(const cvol_array *array)
{
    return &array->grid;
}

void cvol_array_get_info(const cvol_array *array, cvol_array_info *out)
{
    memset(out, 0, sizeof *out);
    out->transform = array->transform;
    out->block = array->block;
    memcpy(out->blocks, array->blocks, sizeof out->blocks);
    out->step = array->step;
    out->coefficients = array->coefficients;
    out->rho = (double)array->coefficients / (double)cvol_grid_samples(&array->grid);
    out->resident_bytes = sizeof *array + array->block_count * sizeof *array->block_table +
                          array->pool_capacity * sizeof *array->pools +
                          array->pool_words * sizeof(uint32_t);
    out->value_min = array->value_min;
    out->value_max = array->value_max;
    out->psnr_db = array->psnr_db;
    out->max_error = array->max_error;
    out->l2_error = array->l2_error;
}

void cvol_block_find_low(cvol_block *block, int block_log2)
{
    const uint32_t mask = (UINT32_C(1) << block_log2) - 1;
    memset(block->low, 0, sizeof block->low);
    const uint32_t *words = block->terms, *end = words + block->words;
    while (words < end) {
        uint32_t place;
        (void)cvol_term_unpack(&words, &place, cvol_place_bits(block_log2));
        for (int a = 0; a < 3; a++) {
            uint32_t frequency = place >> a * block_log2 & mask;
            if (block->low[a] <= frequency)
                block->low[a] = (uint8_t)(frequency + 1);
        }
    }
}
