/* Chains of operations under the default truncation: steps of the heat equation on a compressed
 * volume. The certified bound holds after every step, and all steps together add no more to it than
 * the file carried. */
#include "test.h"

#include "cvol/algebra.h"
#include "cvol/array.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

enum { NX = 40, NY = SUPPORT_SIDE(48), NZ = SUPPORT_SIDE(56), COUNT = NX * NY * NZ };
enum { STEPS = 40 / SUPPORT_STRIDE };

#define RATE 0.1

/* One step along an axis, in place; samples beyond a face repeat those before it. */
static void diffuse_axis(double *samples, size_t stride, size_t length)
{
    double *line = malloc(length * sizeof *line);
    assert_non_null(line);
    for (size_t first = 0; first < COUNT; first++) {
        if (first / stride % length)
            continue;
        for (size_t i = 0; i < length; i++)
            line[i] = samples[first + i * stride];
        for (size_t i = 0; i < length; i++) {
            const double before = line[i ? i - 1 : 0], after = line[i + 1 < length ? i + 1 : i];
            samples[first + i * stride] = (1 - 2 * RATE) * line[i] + RATE * (before + after);
        }
    }
    free(line);
}

static double l2_distance(const cvol_array *array, const double *samples)
{
    const size_t zero[3] = {0, 0, 0}, dims[3] = {NX, NY, NZ};
    float *own = malloc(COUNT * sizeof *own);
    double squares = 0;
    assert_non_null(own);
    assert_int_equal(cvol_array_evaluate_box(context, own, array, zero, dims), CVOL_OK);
    for (size_t i = 0; i < COUNT; i++)
        squares += pow((double)own[i] - samples[i], 2);
    free(own);
    return sqrt(squares);
}

static double bound_of(const cvol_array *array)
{
    cvol_array_info info;
    cvol_array_get_info(&info, array);
    return info.l2_error;
}

static void check_chain(const cvol_volume *volume, const cvol_compress_options *options)
{
    const double taps[3] = {RATE, 1 - 2 * RATE, RATE};
    cvol_kernel kernel;
    cvol_array *array;
    double *exact = malloc(COUNT * sizeof *exact);
    assert_non_null(exact);
    for (size_t i = 0; i < COUNT; i++)
        exact[i] = support_sample(volume, i);
    assert_int_equal(cvol_kernel_taps(context, &kernel, 3, taps, 1), CVOL_OK);
    assert_int_equal(cvol_compress(context, &array, NULL, volume->data, &volume->grid, options),
                     CVOL_OK);
    const double first = bound_of(array);
    for (int step = 1; step <= STEPS; step++) {
        cvol_array *next;
        assert_int_equal(cvol_array_convolve_kernel(context, &next, array, &kernel, NULL), CVOL_OK);
        cvol_array_free(array);
        array = next;
        diffuse_axis(exact, 1, NX);
        diffuse_axis(exact, NX, NY);
        diffuse_axis(exact, (size_t)NX * NY, NZ);
        const double error = l2_distance(array, exact), bound = bound_of(array);
        if (!(error <= bound))
            fail_msg("step %d: the error is %g, the bound %g", step, error, bound);
        if (!(bound <= 2.1 * first)) /* a tenth for the rounding of steps, and for filters */
            fail_msg("step %d: the bound grew from %g to %g", step, first, bound);
        if (step == STEPS && test_verbose())
            print_message("bound %g to %g, error %g\n", first, bound, error);
    }
    cvol_array_free(array);
    free(exact);
}

static void test_bounds_of_chains_stay_small(void **state)
{
    (void)state;
    random_state r = {3};
    cvol_volume volume = support_volume(NX, NY, NZ, CVOL_UINT8);
    for (size_t i = 0; i < COUNT; i++) {
        const double x = (double)(i % NX), y = (double)(i / NX % NY), z = (double)(i / NX / NY);
        const double wave = sin(x / 3) * cos(y / 5) + sin(z / 2);
        ((uint8_t *)volume.data)[i] = (uint8_t)(120 + 40 * wave + 20 * random_signed(&r));
    }
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target = CVOL_TARGET_PSNR;
    options.target_value = 35;
    options.effort = CVOL_EFFORT_FAST;
    check_chain(&volume, &options);
    options.lapped = 0;
    check_chain(&volume, &options);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_bounds_of_chains_stay_small)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
