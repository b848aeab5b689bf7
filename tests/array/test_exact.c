/* Exact evaluation: matrices that do not depend on the last bit of any cosine, kernels that equal
 * the integer arithmetic of the definition, and results close to evaluation in floats. */
#include "test.h"

#include "array/block/exact.h"
#include "base/memory.h"
#include "random.h"
#include "support_lapped.h"
#include "transform/cell.h"

static void test_no_entry_is_near_a_tie(void **state)
{
    (void)state;
    for (int log2 = 2; log2 <= 5; log2++) {
        const int M = 1 << log2;
        const int32_t *C = cvol_exact_matrix(log2);
        for (int f = 0; f < M; f++)
            for (int x = 0; x < M; x++) {
                const double exact = ldexp(sqrt((f ? 2.0 : 1.0) / M) *
                                               cos(3.14159265358979323846 * f * (x + 0.5) / M),
                                           CVOL_EXACT_MATRIX_BITS);
                if (!(fabs(exact - C[f * M + x]) < 0.49))
                    fail_msg("M %d: C[%d][%d] is %d, and not %.3f", M, f, x, C[f * M + x], exact);
                assert_int_equal(C[f * M + M - 1 - x], f & 1 ? -C[f * M + x] : C[f * M + x]);
            }
    }
    static const double h[4] = {-0.07768840068963345, -0.2309698831278217, 0.09567085809127243,
                                -0.1337310918356290};
    for (int i = 0; i < 4; i++)
        assert_true(fabs(ldexp(h[i], CVOL_EXACT_MATRIX_BITS) - cvol_exact_filter[i]) < 0.49);
}

static void test_fraction_bits(void **state)
{
    (void)state;
    assert_int_equal(cvol_exact_fraction(0), CVOL_EXACT_FRACTION_MAX);
    assert_int_equal(cvol_exact_fraction(UINT64_C(1) << 21), 10);
    assert_int_equal(cvol_exact_fraction((UINT64_C(1) << 21) + 1), 9);
    assert_int_equal(cvol_exact_fraction(UINT64_C(1) << 31), 0);
    assert_int_equal(cvol_exact_fraction((UINT64_C(1) << 31) + 1), -1);
}

/* Random terms: few or many, so large that the sums reach their limit. */
static cvol_array *random_array(cvol_context *context, random_state *r, int block, int lapped)
{
    const size_t dims[3] = {1 + random_below(r, 70), 1 + random_below(r, 45),
                            1 + random_below(r, 45)};
    const cvol_type type = (cvol_type)(1 + random_below(r, 8));
    const cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], type);
    const uint32_t terms = UINT32_C(1) << 3 * (block == 8 ? 3 : block == 16 ? 4 : 5);
    cvol_array *array;
    assert_int_equal(cvol_array_create(context, &array, &grid, block), CVOL_OK);
    uint32_t *pool = malloc(2 * sizeof *pool * terms * array->block_count), *at = pool;
    assert_non_null(pool);
    array->lapped = lapped;
    array->step = 0.37;
    array->offset = 3.25;
    array->error_bound.value_min = cvol_type_is_integer(type) ? 0 : -1e6;
    array->error_bound.value_max = cvol_type_is_integer(type) ? 100 : 1e6;
    for (size_t i = 0; i < array->block_count; i++) {
        cvol_block *b = &array->block_table[i];
        const uint32_t below = UINT32_C(1) << random_below(r, 10), most = 1 + random_below(r, 500);
        const uint16_t split = (uint16_t)random_below(r, 512);
        b->split = block == 16 && split & 1 ? split : 0;
        b->terms = at;
        for (uint32_t place = 0; place < terms; place++)
            if (random_below(r, 512) < below) {
                const int32_t value = (int32_t)random_below(r, 2 * most + 1) - (int32_t)most;
                if (value)
                    at += cvol_term_pack(at, place, value, cvol_place_bits(array->block_log2));
            }
        b->words = (uint32_t)(at - b->terms);
        cvol_block_find_low(b, array->block_log2);
    }
    assert_int_equal(cvol_array_adopt_pool(context, array, pool, (size_t)(at - pool)), CVOL_OK);
    return array;
}

static void check_box(const cvol_array *array, int fraction, const size_t begin[3],
                      const size_t end[3], uint64_t seed)
{
    const size_t count = (end[0] - begin[0]) * (end[1] - begin[1]) * (end[2] - begin[2]);
    double *fast = malloc(count * sizeof *fast), *slow = malloc(count * sizeof *slow);
    double *scratch = cvol_allocate(cvol_exact_scratch(array, begin, end), sizeof *scratch);
    assert_true(fast && slow && scratch);
    cvol_exact_box(fast, scratch, array, fraction, begin, end);
    assert_true(cvol_exact_box_reference(slow, array, fraction, begin, end));
    if (memcmp(fast, slow, count * sizeof *fast))
        fail_msg("seed %llu: other samples", (unsigned long long)seed);
    free(fast);
    free(slow);
    free(scratch);
}

static void test_kernels_equal_integer_arithmetic(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    for (uint64_t seed = 1; seed <= 60; seed++) {
        random_state r = {seed};
        const int block = seed % 10 == 8 ? 8 : seed % 10 == 9 ? 32 : 16;
        cvol_array *array = random_array(context, &r, block, block == 16 && seed % 3);
        const size_t *dims = array->grid.dims, zero[3] = {0, 0, 0};
        const int fraction = cvol_exact_fraction(cvol_exact_largest_sum(array));
        assert_true(fraction >= 0);
        check_box(array, fraction, zero, dims, seed);
        for (int i = 0; i < 4; i++) {
            size_t begin[3], end[3];
            for (int a = 0; a < 3; a++) {
                begin[a] = random_below(&r, (uint32_t)dims[a]);
                end[a] = begin[a] + 1 + random_below(&r, (uint32_t)(dims[a] - begin[a]));
            }
            check_box(array, fraction, begin, end, seed);
        }
        cvol_array_free(array);
    }
    cvol_context_free(context);
}

/* One coefficient of the largest magnitude, and as many as fill the limit. */
static void test_the_largest_sums_are_exact(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    for (uint64_t seed = 1; seed <= 12; seed++) {
        random_state r = {seed};
        const cvol_grid grid = cvol_grid_make(32, 32, 32, CVOL_FLOAT64);
        const size_t zero[3] = {0, 0, 0};
        cvol_array *array;
        assert_int_equal(cvol_array_create(context, &array, &grid, 16), CVOL_OK);
        uint32_t *pool = malloc(2 * sizeof *pool * 4096 * 8), *at = pool;
        assert_non_null(pool);
        array->lapped = 1;
        array->error_bound.value_min = -1e300;
        array->error_bound.value_max = 1e300;
        const int count = seed % 2 ? 2 : 4096;
        for (size_t i = 0; i < 8; i++) {
            cvol_block *b = &array->block_table[i];
            b->split = seed % 3 == 0 ? 0 : seed % 3 == 1 ? CVOL_CELL_OCTANTS : CVOL_CELL_FOURS;
            b->terms = at;
            for (uint32_t place = 0; place < (uint32_t)count; place++) {
                const int32_t value = (INT32_C(1) << 30) / (count / 2);
                at += cvol_term_pack(at, place, random_below(&r, 2) ? value : -value, 12);
            }
            b->words = (uint32_t)(at - b->terms);
            cvol_block_find_low(b, 4);
        }
        assert_int_equal(cvol_array_adopt_pool(context, array, pool, (size_t)(at - pool)), CVOL_OK);
        assert_int_equal(cvol_exact_fraction(cvol_exact_largest_sum(array)), 0);
        check_box(array, 0, zero, grid.dims, seed);
        cvol_array_free(array);
    }
    cvol_context_free(context);
}

static void test_close_to_float_evaluation(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    for (uint64_t seed = 1; seed <= 4; seed++) {
        random_state r = {seed};
        const size_t dims[3] = {53, 40, 35}, zero[3] = {0, 0, 0};
        const size_t count = dims[0] * dims[1] * dims[2];
        float *samples = malloc(count * sizeof *samples);
        double *exact = malloc(count * sizeof *exact);
        assert_true(samples && exact);
        for (size_t i = 0; i < count; i++)
            samples[i] = (float)(1000 * sin((double)i * 0.013) + 20 * random_signed(&r));
        cvol_array *array = support_lapped(context, samples, dims, 12.5, 0.5, seed & 1, seed);
        array->error_bound.value_min = -1e30;
        array->error_bound.value_max = 1e30;
        const int fraction = cvol_exact_fraction(cvol_exact_largest_sum(array));
        double *scratch = cvol_allocate(cvol_exact_scratch(array, zero, dims), sizeof *scratch);
        assert_true(scratch && fraction > 5);
        cvol_exact_box(exact, scratch, array, fraction, zero, dims);
        support_lapped_samples(samples, array);
        for (size_t i = 0; i < count; i++)
            if (!(fabs(exact[i] - 12.5 - (double)samples[i]) < 0.03))
                fail_msg("seed %llu, sample %zu: %g, not %g", (unsigned long long)seed, i, exact[i],
                         (double)samples[i] + 12.5);
        cvol_array_free(array);
        free(samples);
        free(exact);
        free(scratch);
    }
    cvol_context_free(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_entry_is_near_a_tie),
        cmocka_unit_test(test_fraction_bits),
        cmocka_unit_test(test_kernels_equal_integer_arithmetic),
        cmocka_unit_test(test_the_largest_sums_are_exact),
        cmocka_unit_test(test_close_to_float_evaluation),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
