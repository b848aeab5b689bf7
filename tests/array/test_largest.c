/* max_abs bounds the evaluated samples, for any offset and terms. */
#include "test.h"

#include "cvol/cvol.h"
#include "random.h"
#include "support.h"
#include "support_context.h"

static double largest_of(const cvol_array *array)
{
    const size_t zero[3] = {0, 0, 0}, *dims = cvol_array_grid(array)->dims;
    const size_t count = dims[0] * dims[1] * dims[2];
    float *real = malloc(count * sizeof *real);
    double largest = 0;
    assert_non_null(real);
    assert_int_equal(cvol_array_evaluate_real(context, real, array, zero, dims), CVOL_OK);
    for (size_t i = 0; i < count; i++)
        largest = fmax(largest, fabs((double)real[i]));
    free(real);
    return largest;
}

static void check(const cvol_array *array, int seed)
{
    cvol_array_info info;
    cvol_array_get_info(&info, array);
    const double largest = largest_of(array);
    if (!(largest <= info.max_abs))
        print_message("seed %d: %.12g, at most %.12g\n", seed, largest, info.max_abs);
    assert_true(largest <= info.max_abs);
}

/* Noise in lossless files whose terms are almost zero: the least sample and a mean of the same size
 * cancel. */
static void lossless_noise(void **state)
{
    (void)state;
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvol");
    for (int seed = 8; seed < 18; seed++) {
        random_state r = {(uint64_t)seed};
        const cvol_grid grid = cvol_grid_make(1 + random_below(&r, 20), 1 + random_below(&r, 20),
                                              1 + random_below(&r, 10),
                                              seed % 3 ? CVOL_FLOAT64 : CVOL_FLOAT32);
        const size_t count = cvol_grid_samples(&grid);
        double *samples = malloc(count * sizeof *samples);
        cvol_compress_options options = cvol_compress_options_defaults();
        cvol_array *array;
        assert_non_null(samples);
        for (size_t i = 0; i < count; i++) {
            samples[i] = 2e19 * random_signed(&r);
            if (grid.type == CVOL_FLOAT32)
                ((float *)samples)[i] = (float)samples[i];
        }
        options.lossless = 1;
        options.effort = seed % 2 ? CVOL_EFFORT_FAST : CVOL_EFFORT_DEFAULT;
        assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options), CVOL_OK);
        check(array, seed);
        assert_int_equal(cvol_array_write(context, array, path, NULL), CVOL_OK);
        cvol_array_free(array);
        assert_int_equal(cvol_array_read(context, &array, path, NULL), CVOL_OK);
        check(array, seed);
        cvol_array_free(array);
        free(samples);
    }
    free(path);
    support_folder_remove(folder);
}

/* An array that evaluates to zero has the error of all dropped terms, also after resampling to
 * twice as many samples. */
static void resampling_of_nothing(void **state)
{
    (void)state;
    for (int rank = 1; rank <= 3; rank++)
        for (int factor = -2; factor <= 2; factor += 4) {
            const cvol_grid grid = cvol_grid_make(32, rank > 1 ? 20 : 1, rank > 2 ? 9 : 1,
                                                  CVOL_FLOAT32);
            const size_t count = cvol_grid_samples(&grid);
            const cvol_keep none = cvol_keep_terms(0, 0);
            float *samples = malloc(count * sizeof *samples);
            cvol_array *a, *b;
            cvol_array_info info;
            assert_non_null(samples);
            for (size_t i = 0; i < count; i++)
                samples[i] = 3;
            assert_int_equal(
                cvol_array_compress(context, &a, samples, &grid, rank, CVOL_DCT, 16, &none),
                CVOL_OK);
            assert_int_equal(cvol_array_measure(context, a, samples), CVOL_OK); /* max_abs 0 */
            assert_int_equal(cvol_array_resample(context, &b, a, factor, NULL), CVOL_OK);
            cvol_array_get_info(&info, b);
            assert_true(largest_of(b) <= 0);
            assert_true(info.l2_error >= 3 * sqrt((double)cvol_grid_samples(cvol_array_grid(b))));
            assert_true(info.value_min <= 3 && info.value_max >= 3);
            cvol_array_free(a);
            cvol_array_free(b);
            free(samples);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lossless_noise),
                                       cmocka_unit_test(resampling_of_nothing)};
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
