#include "test.h"

#include "support_split.h"

#include "random.h"
#include "transform/cell.h"

uint32_t *support_cell_code(cvol_array *array, size_t i, uint32_t *at, const float *samples)
{
    cvol_block *block = &array->block_table[i];
    float *terms = aligned_alloc(64, CVOL_CELL_SAMPLES * sizeof *terms);
    assert_non_null(terms);
    cvol_cell_forward(terms, samples, block->split);
    block->terms = at;
    for (uint32_t place = 0; place < CVOL_CELL_SAMPLES; place++) {
        const int32_t value = (int32_t)lrint((double)terms[place] / array->step);
        array->coefficients += value != 0;
        if (value)
            at += cvol_term_pack(at, place, value, cvol_place_bits(4));
    }
    free(terms);
    block->words = (uint32_t)(at - block->terms);
    cvol_block_find_low(block, 4);
    return at;
}

void support_split_cells(cvol_context *context, cvol_array *array, uint64_t seed)
{
    float *samples = aligned_alloc(64, CVOL_CELL_SAMPLES * sizeof *samples);
    uint32_t *pool = malloc(2 * CVOL_CELL_SAMPLES * array->block_count * sizeof *pool), *at = pool;
    random_state r = {seed};
    assert_true(samples && pool);
    array->coefficients = 0;
    for (size_t i = 0; i < array->block_count; i++) {
        cvol_block *block = &array->block_table[i];
        const uint16_t split = (uint16_t)random_below(&r, 512);
        cvol_block_evaluate(samples, array, i);
        block->split = split & 1 ? split : 0;
        at = support_cell_code(array, i, at, samples);
    }
    assert_int_equal(cvol_array_adopt_pool(context, array, pool, (size_t)(at - pool)), CVOL_OK);
    free(samples);
}
