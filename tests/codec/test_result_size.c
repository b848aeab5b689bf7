/* Results of operations are about as small as their operands, and their bounds grow by a fifth at
 * most: blocks are lapped and split where that costs fewer bits. The limits lie between the sizes
 * of plain, whole blocks and the present ones. */
#include "test.h"

#include "array/core/array.h"
#include "codec/container/array_file.h"
#include "cvol/algebra.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

enum { SIDE = 80, COUNT = SIDE * SIDE * SIDE };

/* A textured body with a bright core, in an empty background. */
static cvol_volume make_samples(void)
{
    random_state r = {1};
    cvol_volume volume = support_volume(SIDE, SIDE, SIDE, CVOL_UINT8);
    uint8_t *samples = volume.data;
    for (size_t i = 0; i < COUNT; i++) {
        const double x = (double)(i % SIDE), y = (double)(i / SIDE % SIDE),
                     z = (double)(i / SIDE / SIDE);
        const double u = x / SIDE - 0.5, v = y / SIDE - 0.45, w = z / SIDE - 0.55;
        const double from_middle = u * u + 1.2 * v * v + w * w;
        const double value = 110 + 30 * sin(x / 5) * cos(y / 6) + 20 * sin(z / 4) +
                             3 * random_signed(&r) + (from_middle < 0.03 ? 50 : 0);
        samples[i] = (uint8_t)(from_middle > 0.15 ? 0 : value);
    }
    return volume;
}

static cvol_array *compress(const cvol_volume *volume, double ratio)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array;
    options.target_value = ratio;
    if (cvol_compress(context, &array, NULL, volume->data, &volume->grid, &options))
        fail_msg("%s", cvol_context_message(context));
    return array;
}

static double bytes_of(const cvol_array *array)
{
    uint64_t bytes;
    assert_int_equal(cvol_array_file_bytes(context, array, &bytes), CVOL_OK);
    return (double)bytes;
}

/* The bytes of the result over those of the operand, and its bound over the carried one. */
static cvol_array *expect_small(int code, cvol_array *result, const cvol_array *operand,
                                double carried, double most, const char *what)
{
    if (code)
        fail_msg("%s", cvol_context_message(context));
    const double size = bytes_of(result) / bytes_of(operand);
    const double grown = result->error_bound.l2_error / carried;
    if (test_verbose())
        print_message("%s: %.3f of the operand, bound %.3f of the carried one\n", what, size,
                      grown);
    if (!(size <= most && grown <= 1.2))
        fail_msg("%s: %g times the operand, the bound %g times", what, size, grown);
    return result;
}

/* How many blocks of a sum are split where the splits of the operands differ. */
static size_t splits_anew(const cvol_array *sum, const cvol_array *a, const cvol_array *b)
{
    size_t count = 0;
    for (size_t i = 0; i < sum->block_count; i++) {
        const cvol_block *x = &a->block_table[i], *y = &b->block_table[i];
        count += x->words && y->words && x->split != y->split && sum->block_table[i].split;
    }
    return count;
}

static void test_sizes(void **state)
{
    (void)state;
    cvol_volume volume = make_samples();
    cvol_array *a = compress(&volume, 30), *b = compress(&volume, 20), *result = NULL;
    const double of_a = a->error_bound.l2_error, of_b = b->error_bound.l2_error;
    const double product = cvol_error_bound_multiply(&a->error_bound, &b->error_bound).l2_error;
    cvol_kernel kernel;
    int code = cvol_array_add(context, &result, 1, a, 1, b, NULL);
    result = expect_small(code, result, b, of_a + of_b, 1.55, "a + b");
    assert_true(splits_anew(result, a, b) > 0);
    cvol_array_free(result);
    code = cvol_array_add(context, &result, 1, a, -1, b, NULL);
    cvol_array_free(expect_small(code, result, b, of_a + of_b, 0.8, "a - b"));
    code = cvol_array_add(context, &result, 1, a, 1, a, NULL);
    cvol_array_free(expect_small(code, result, a, 2 * of_a, 1.05, "a + a"));
    code = cvol_array_multiply(context, &result, a, b, NULL, CVOL_PLAN_AUTO, NULL);
    cvol_array_free(expect_small(code, result, b, product, 1.2, "a b"));
    code = cvol_array_gradient(context, &result, a, NULL);
    result = expect_small(code, result, a, sqrt(3) * of_a, 3, "gradient");
    assert_true(cvol_array_has_splits(result));
    cvol_array_free(result);
    assert_int_equal(cvol_kernel_gaussian(context, &kernel, 3, 1.5), CVOL_OK);
    code = cvol_array_convolve_kernel(context, &result, a, &kernel, NULL);
    result = expect_small(code, result, a, of_a, 0.5, "gaussian:1.5");
    assert_true(result->lapped);
    cvol_array_free(result);
    cvol_array_free(a);
    cvol_array_free(b);
    free(volume.data);
}

/* A file keeps what default truncation has lost, so that a chain of operations through files loses
 * no more than one in memory. */
static void test_loss_through_a_file(void **state)
{
    (void)state;
    cvol_volume volume = make_samples();
    cvol_array *a = compress(&volume, 20), *result, *back, *again[2];
    void *data;
    size_t size;
    assert_int_equal(cvol_array_gradient(context, &result, a, NULL), CVOL_OK);
    assert_true(result->error_bound.default_loss > 0);
    assert_int_equal(cvol_array_write_memory(context, result, &data, &size), CVOL_OK);
    assert_int_equal(cvol_array_read_memory(context, &back, data, size, "result"), CVOL_OK);
    assert_true(back->error_bound.default_loss == result->error_bound.default_loss);
    assert_true(back->error_bound.l2_error == result->error_bound.l2_error);
    assert_int_equal(cvol_array_gradient(context, &again[0], result, NULL), CVOL_OK);
    assert_int_equal(cvol_array_gradient(context, &again[1], back, NULL), CVOL_OK);
    assert_true(fabs(again[1]->error_bound.l2_error / again[0]->error_bound.l2_error - 1) < 1e-3);
    free(data);
    cvol_array_free(again[0]);
    cvol_array_free(again[1]);
    cvol_array_free(back);
    cvol_array_free(result);
    cvol_array_free(a);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_sizes), TEST(test_loss_through_a_file)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
