#include "test.h"

#include "support_terms.h"

#include "random.h"

static int32_t random_value(random_state *r, int small)
{
    const int32_t value = small || random_below(r, 400)
                              ? (int32_t)random_below(r, 9) - 4
                              : (int32_t)random_below(r, 200000001) - 100000000;
    return value ? value : 1;
}

cvol_array *support_terms_make(cvol_context *context, const support_terms *how)
{
    const cvol_grid grid = cvol_grid_make(how->dims[0], how->dims[1], how->dims[2], CVOL_FLOAT32);
    random_state r = {how->seed};
    cvol_array *array;
    assert_int_equal(cvol_array_create(context, &array, &grid, how->block), CVOL_OK);
    const uint32_t places = (uint32_t)cvol_array_block_terms(array), side = (uint32_t)how->block;
    uint32_t *words = malloc(8 * 600 * array->block_count + 8), *to = words;
    assert_non_null(words);
    for (size_t b = 0; b < array->block_count; b++) {
        cvol_block *cell = &array->block_table[b];
        const uint16_t bits = (uint16_t)random_below(&r, 512);
        cell->terms = to;
        cell->split = how->split && bits & 1 ? bits : 0;
        const uint32_t density = random_below(&r, 4) ? 400 : 0;
        const ptrdiff_t start = to - words;
        for (uint32_t p = 0; p < places && to - words < start + 1000; p++) {
            const uint32_t high = p % side + p / side % side + p / side / side;
            if (random_below(&r, 40 + high * high * 8) >= density / 16)
                continue;
            to += cvol_term_pack(to, p, random_value(&r, how->small_values),
                                 cvol_place_bits(array->block_log2));
            array->coefficients++;
        }
        cell->words = (uint32_t)(to - cell->terms);
        cvol_block_find_low(cell, array->block_log2);
    }
    assert_int_equal(cvol_array_adopt_pool(context, array, words, (size_t)(to - words)), CVOL_OK);
    array->step = 0.125;
    array->offset = -3;
    array->lapped = how->lapped;
    array->error_bound = (cvol_error_bound){
        .l2_error = 0.5, .max_abs = 1e9, .value_min = -1e9, .value_max = 1e9};
    array->threshold = 0.25;
    cvol_array_derive_figures(array);
    return array;
}

void support_terms_expect_same(const cvol_array *a, const cvol_array *b)
{
    assert_int_equal(a->block_count, b->block_count);
    assert_int_equal(a->lapped, b->lapped);
    assert_int_equal(a->coefficients, b->coefficients);
    for (size_t i = 0; i < a->block_count; i++) {
        const cvol_block *x = &a->block_table[i], *y = &b->block_table[i];
        assert_int_equal(x->words, y->words);
        assert_int_equal(x->split, y->split);
        assert_memory_equal(x->low, y->low, 3);
        if (x->words)
            assert_memory_equal(x->terms, y->terms, 4 * x->words);
    }
}
