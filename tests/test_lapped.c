/* Lapped volumes evaluate, to the bit, to what filtering the whole volume gives, whatever is asked
 * for and by how many threads; and operations give what they give of the same samples. */
#define _DEFAULT_SOURCE /* M_PI */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "codec/survey.h"
#include "cvol/cvol.h"
#include "random.h"
#include "support_lapped.h"

static float *random_samples(random_state *r, const size_t dims[3])
{
    const size_t count = dims[0] * dims[1] * dims[2];
    float *samples = malloc(count * sizeof *samples);
    assert_non_null(samples);
    for (size_t i = 0; i < count; i++)
        samples[i] = (float)(2 + 0.3 * random_signed(r) + sin(0.3 * (double)(i % dims[0])));
    return samples;
}

static cvol_array *random_lapped(cvol_context *context, random_state *r, const size_t dims[3],
                                 double step)
{
    float *samples = random_samples(r, dims);
    cvol_array *array = support_lapped(context, samples, dims, random_below(r, 2) ? 1.5 : 0, step,
                                       random_below(r, 2) != 0, random_u64(r));
    free(samples);
    return array;
}

static void random_dims(size_t dims[3], random_state *r)
{
    for (int a = 0; a < 3; a++)
        dims[a] = 1 + random_below(r, random_below(r, 4) ? 40 : 100);
}

static void random_box(size_t begin[3], size_t end[3], random_state *r, const size_t dims[3])
{
    for (int a = 0; a < 3; a++) {
        begin[a] = random_below(r, (uint32_t)dims[a]);
        end[a] = begin[a] + 1 + random_below(r, (uint32_t)(dims[a] - begin[a]));
        if (random_below(r, 4) == 0) {
            begin[a] = 0;
            end[a] = dims[a];
        }
    }
}

/* ---- evaluating --------------------------------------------------------------------------------
 */

static void expect_box(cvol_context *context, const cvol_array *array, const float *all,
                       const size_t begin[3], const size_t end[3], uint64_t seed)
{
    const size_t size[3] = {end[0] - begin[0], end[1] - begin[1], end[2] - begin[2]};
    const size_t count = size[0] * size[1] * size[2], *dims = array->grid.dims;
    float *real = malloc(count * sizeof *real), *stored = malloc(count * sizeof *stored);
    assert_true(real && stored);
    assert_int_equal(cvol_array_evaluate_real(context, real, array, begin, end), 0);
    assert_int_equal(cvol_array_evaluate_box(context, stored, array, begin, end), 0);
    for (size_t i = 0; i < count; i++) {
        const size_t x = begin[0] + i % size[0], y = begin[1] + i / size[0] % size[1],
                     z = begin[2] + i / size[0] / size[1];
        const float from = all[x + dims[0] * (y + dims[1] * z)];
        const float wanted = from + (float)array->offset;
        float as_stored;
        cvol_samples_store(&as_stored, &from, 1, array);
        if (memcmp(&real[i], &wanted, sizeof wanted) ||
            memcmp(&stored[i], &as_stored, sizeof as_stored)) {
            print_message("seed %llu: (%zu, %zu, %zu) of %zux%zux%zu, box from (%zu, %zu, %zu) of "
                          "%zux%zux%zu: %.9g, not %.9g\n",
                          (unsigned long long)seed, x, y, z, dims[0], dims[1], dims[2], begin[0],
                          begin[1], begin[2], size[0], size[1], size[2], (double)real[i],
                          (double)wanted);
            fail();
        }
    }
    free(real);
    free(stored);
}

static void boxes_have_the_bits_of_the_whole(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    for (uint64_t seed = 1; seed <= 60; seed++) {
        random_state r = {seed};
        size_t dims[3], begin[3], end[3];
        random_dims(dims, &r);
        cvol_array *array = random_lapped(context, &r, dims, 0.1);
        float *all = malloc(dims[0] * dims[1] * dims[2] * sizeof *all);
        assert_non_null(all);
        support_lapped_samples(all, array);
        cvol_context_set_threads(context, 1 + (int)random_below(&r, 5));
        for (int trial = 0; trial < 5; trial++) {
            random_box(begin, end, &r, dims);
            expect_box(context, array, all, begin, end, seed);
        }
        free(all);
        cvol_array_free(array);
    }
    cvol_context_destroy(context);
}

static void quantisation_is_the_only_loss(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    const size_t dims[3] = {50, 37, 49}, begin[3] = {0, 0, 0}, count = 50 * 37 * 49;
    random_state r = {7};
    float *samples = random_samples(&r, dims), *real = malloc(count * sizeof *real);
    assert_non_null(real);
    cvol_array *array = support_lapped(context, samples, dims, 1, 1e-4, 1, 3);
    assert_int_equal(cvol_array_evaluate_real(context, real, array, begin, dims), 0);
    for (size_t i = 0; i < count; i++)
        assert_true(fabs((double)samples[i] - (double)real[i]) < 1e-3);
    cvol_distance distance;
    assert_int_equal(cvol_measure_distance(context, &distance, array, samples), 0);
    double squares = 0, most = 0;
    for (size_t i = 0; i < count; i++) {
        const double apart = (double)samples[i] - (double)real[i];
        squares += apart * apart;
        most = fmax(most, fabs((double)real[i]));
    }
    assert_true(fabs(distance.real_l2_error - sqrt(squares)) < 1e-3 * sqrt(squares));
    assert_true(fabs(distance.real_max_abs - most) < 1e-6 * most);
    assert_true(distance.max_error > 0 && distance.max_error < 1e-3);
    free(samples);
    free(real);
    cvol_array_free(array);
    cvol_context_destroy(context);
}

static void the_distance_does_not_depend_on_threads(void **state)
{
    (void)state;
    const size_t dims[3] = {70, 90, 60};
    random_state r = {11};
    float *samples = random_samples(&r, dims);
    cvol_context *context = cvol_context_create();
    cvol_array *array = support_lapped(context, samples, dims, 1, 0.5, 1, 3);
    cvol_distance one, other;
    cvol_context_set_threads(context, 1);
    assert_int_equal(cvol_measure_distance(context, &one, array, samples), 0);
    cvol_context_set_threads(context, 5);
    assert_int_equal(cvol_measure_distance(context, &other, array, samples), 0);
    assert_memory_equal(&one, &other, sizeof one);
    free(samples);
    cvol_array_free(array);
    cvol_context_destroy(context);
}

static void ranges_are_those_of_the_samples(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    for (uint64_t seed = 1; seed <= 20; seed++) {
        random_state r = {seed};
        size_t dims[3];
        random_dims(dims, &r);
        cvol_array *array = random_lapped(context, &r, dims, 0.1);
        float *all = malloc(dims[0] * dims[1] * dims[2] * sizeof *all);
        assert_non_null(all);
        support_lapped_samples(all, array);
        assert_int_equal(cvol_array_find_ranges(context, array), 0);
        const double unit = (array->range_max - array->range_min) / 255;
        for (size_t i = 0; i < array->block_count; i++) {
            size_t at[3];
            double least = (double)INFINITY, most = -(double)INFINITY, lo, hi;
            cvol_block_origin(at, array, i);
            for (size_t z = at[2]; z < at[2] + 16 && z < dims[2]; z++)
                for (size_t y = at[1]; y < at[1] + 16 && y < dims[1]; y++)
                    for (size_t x = at[0]; x < at[0] + 16 && x < dims[0]; x++) {
                        const double value = array->offset +
                                             (double)all[x + dims[0] * (y + dims[1] * z)];
                        least = fmin(least, value);
                        most = fmax(most, value);
                    }
            cvol_array_range(array, i, &lo, &hi);
            if (!(lo <= least && least - lo <= 1.01 * unit && hi >= most &&
                  hi - most <= 1.01 * unit)) {
                print_message("seed %llu: block %zu: %g .. %g, coded %g .. %g\n",
                              (unsigned long long)seed, i, least, most, lo, hi);
                fail();
            }
        }
        free(all);
        cvol_array_free(array);
    }
    cvol_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_have_the_bits_of_the_whole),
        cmocka_unit_test(quantisation_is_the_only_loss),
        cmocka_unit_test(the_distance_does_not_depend_on_threads),
        cmocka_unit_test(ranges_are_those_of_the_samples),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
