/* Planes: coefficients beyond the coder's range or beyond float32, and more planes than a file can
 * hold, are refused. Round trips are those of pictures and baked volumes. */
#include "test.h"

#include "base/context.h"
#include "codec/container/plane_code.h"
#include "codec/container/plane_file.h"
#include "cvol/array.h"
#include "support_context.h"

enum { NX = 20, NY = 9 };

/* A plane of waves; its coefficients are multiples of `step` in blocks. */
static cvol_array *make_plane(int block, double step)
{
    const cvol_grid grid = cvol_grid_make(NX, NY, 1, CVOL_FLOAT32);
    const cvol_keep keep = block ? cvol_keep_step(step) : cvol_keep_threshold(step);
    float samples[NX * NY];
    cvol_array *array;
    for (int i = 0; i < NX * NY; i++)
        samples[i] = (float)(1000 * sin(i * 0.1));
    check_ok(cvol_array_compress(context, &array, samples, &grid, 2, CVOL_DCT, block, &keep));
    return array;
}

static void expect_message(int code, int wanted, const char *sentence)
{
    if (code != wanted || !strstr(cvol_context_message(context), sentence))
        fail_msg("%d, must be %d with '%s': '%s'", code, wanted, sentence,
                 cvol_context_message(context));
}

static void values_have_a_limit(void **state)
{
    (void)state;
    cvol_array *whole = make_plane(0, 0.5), *out;
    int32_t *values;
    check_ok(cvol_plane_values(context, &values, whole, 1e-3));
    free(values);
    expect_message(cvol_plane_values(context, &values, whole, 1e-8), CVOL_ERROR_DATA,
                   "coefficients are too large for its step");
    assert_null(values);
    expect_message(cvol_plane_quantise(context, &out, whole, 1e-8), CVOL_ERROR_DATA,
                   "coefficients are too large for its step");
    assert_null(out);
    cvol_array_free(whole);
    /* Terms of blocks are below 2^30; planes of files, up to 2^29. */
    cvol_array *blocks = make_plane(8, 9e-6);
    expect_message(cvol_plane_values(context, &values, blocks, blocks->step), CVOL_ERROR_DATA,
                   "coefficients are too large for its step");
    assert_null(values);
    cvol_array_free(blocks);
}

static void samples_fit_floats(void **state)
{
    (void)state;
    const cvol_plane_shape shape = {{NX, NY}, CVOL_DCT, 0};
    int32_t values[NX * NY] = {1000, -7, 3};
    cvol_array *out;
    check_ok(cvol_plane_array(context, &out, values, &shape, 1e30, "f"));
    cvol_array_free(out);
    expect_message(cvol_plane_array(context, &out, values, &shape, 1e36, "f"), CVOL_ERROR_CORRUPT,
                   "f: terms are too large for float32");
    assert_null(out);
}

static void bytes_limit_planes(void **state)
{
    (void)state;
    const cvol_plane_shape shape = {{NX, NY}, CVOL_DCT, 8}; /* six tiles */
    check_ok(cvol_plane_file_check(context, &shape, 1000, 0, "f"));
    expect_message(cvol_plane_file_check(context, &shape, 100000, 60, "f"), CVOL_ERROR_CORRUPT,
                   "f: 100000 planes of 20 x 9 are more than 60 bytes can hold");
    check_ok(cvol_plane_file_check(context, &shape, 100000, 100, "f"));
    cvol_context_set_limit_bytes(context, 1000);
    expect_message(cvol_plane_file_check(context, &shape, 1, 100, "f"), CVOL_ERROR_LIMIT,
                   "f: has planes of 20 x 9 places");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_have_a_limit),
        cmocka_unit_test(samples_fit_floats),
        cmocka_unit_test(bytes_limit_planes),
    };
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
