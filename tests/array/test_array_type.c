/* The type of the samples that an array evaluates to. */
#include "test.h"

#include "array/core/array.h"

static cvol_array *make_array(cvol_context *context, double lo, double hi)
{
    cvol_grid grid = cvol_grid_make(9, 9, 9, CVOL_FLOAT32);
    cvol_array *array;
    assert_int_equal(cvol_array_create(context, &array, &grid, 8), CVOL_OK);
    array->error_bound = (cvol_error_bound){
        .l2_error = 1, .max_abs = 10, .value_min = lo, .value_max = hi};
    cvol_array_derive_figures(array);
    return array;
}

static void refuse(cvol_context *context, double lo, double hi, cvol_type type,
                   const char *sentence)
{
    cvol_array *array = make_array(context, lo, hi);
    assert_int_equal(cvol_array_set_type(context, array, type), CVOL_ERROR_DATA);
    assert_string_equal(cvol_context_message(context), sentence);
    assert_int_equal(cvol_array_grid(array)->type, CVOL_FLOAT32);
    cvol_array_free(array);
}

static void types_clamp_to_their_ranges(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    for (cvol_type type = CVOL_UINT8; type <= CVOL_FLOAT64; type++) {
        double least, largest;
        cvol_type_get_range(&least, &largest, type);
        if (type == CVOL_FLOAT64)
            break; /* 1e308 has no samples in single precision */
        cvol_array *array = make_array(context, least, largest);
        assert_int_equal(cvol_array_set_type(context, array, type), CVOL_OK);
        assert_int_equal(cvol_array_grid(array)->type, type);
        cvol_array_free(array);
    }
    refuse(context, 0, 510, CVOL_UINT8,
           "values may reach 0 .. 510, uint8 holds 0 .. 255; use "
           "--type uint16");
    refuse(context, -0.5, 10, CVOL_UINT8,
           "values may reach -1 .. 10, uint8 holds 0 .. 255; use --type int8");
    refuse(context, 0, 65025.5, CVOL_INT16,
           "values may reach 0 .. 65026, int16 holds -32768 .. 32767; use --type uint16");
    refuse(context, 0, 1e12, CVOL_UINT32,
           "values may reach 0 .. 1e+12, uint32 holds 0 .. 4294967295; use --type float32");
    cvol_context_free(context);
}

static void integers_round(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_array *array = make_array(context, 0.25, 99.5);
    cvol_array_info before, after;
    cvol_array_get_info(&before, array);
    assert_true(before.max_error == 1);
    assert_int_equal(cvol_array_set_type(context, array, CVOL_INT16), CVOL_OK);
    cvol_array_get_info(&after, array);
    assert_true(after.l2_error == 1 && after.max_error == 1.5 && after.psnr_db < before.psnr_db);
    assert_true(after.value_min == 0 && after.value_max == 100 && !after.measured);
    assert_int_equal(cvol_array_set_type(context, array, (cvol_type)0), CVOL_ERROR_ARGUMENT);
    cvol_array_free(array);
    cvol_context_free(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(types_clamp_to_their_ranges),
        cmocka_unit_test(integers_round),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
