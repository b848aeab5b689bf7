/* Lapped volumes evaluate, to the bit, to the samples that filtering the whole volume gives, for
 * any request and any number of threads; operations give the same as on the samples. */
#include "test.h"

#include "codec/rate/measure.h"
#include "cvol/cvol.h"
#include "random.h"
#include "support_cells.h"
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

/* ---- evaluating ------------------------------------------------------------------------------ */

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

static void boxes_equal_the_whole(void **state)
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
        for (int attempt = 0; attempt < 5; attempt++) {
            random_box(begin, end, &r, dims);
            expect_box(context, array, all, begin, end, seed);
        }
        free(all);
        cvol_array_free(array);
    }
    cvol_context_free(context);
}

static void only_quantization_loses(void **state)
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
    cvol_context_free(context);
}

static void distance_is_the_same_for_any_threads(void **state)
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
    cvol_context_free(context);
}

static void ranges_equal_those_of_samples(void **state)
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
    cvol_context_free(context);
}

/* ---- the algebra ----------------------------------------------------------------------------- */

static const size_t shape[3] = {40, 35, 50};
enum { SAMPLES = 40 * 35 * 50 };

/* The same samples in blocks that are not lapped. */
static cvol_array *plain_twin(cvol_context *context, const cvol_array *lapped)
{
    static float samples[SAMPLES];
    const cvol_grid grid = cvol_grid_make(shape[0], shape[1], shape[2], CVOL_FLOAT32);
    const cvol_keep all = cvol_keep_all();
    cvol_array *array;
    support_lapped_samples(samples, lapped);
    for (int i = 0; i < SAMPLES; i++)
        samples[i] = (float)((double)samples[i] + lapped->offset);
    assert_int_equal(cvol_array_compress(context, &array, samples, &grid, 3, CVOL_DCT, 16, &all),
                     0);
    return array;
}

static void expect_near(cvol_context *context, const cvol_array *got, const cvol_array *expected)
{
    const size_t begin[3] = {0, 0, 0}, *dims = got->grid.dims,
                 count = cvol_grid_samples(&got->grid);
    float *x = malloc(count * sizeof *x), *y = malloc(count * sizeof *y);
    assert_true(x && y && count == cvol_grid_samples(&expected->grid));
    assert_int_equal(cvol_array_evaluate_real(context, x, got, begin, dims), 0);
    assert_int_equal(cvol_array_evaluate_real(context, y, expected, begin, dims), 0);
    double apart = 0, size = 0;
    for (size_t i = 0; i < count; i++) {
        apart = fmax(apart, fabs((double)x[i] - (double)y[i]));
        size = fmax(size, fabs((double)y[i]));
    }
    assert_true(apart <= 1e-5 * size);
    free(x);
    free(y);
}

/* The largest reach of a kernel. */
static int filter_widely(cvol_context *context, cvol_array **result, const cvol_array *a,
                         const cvol_array *b)
{
    const cvol_keep all = cvol_keep_all();
    cvol_kernel kernel;
    (void)b;
    int code = cvol_kernel_box(context, &kernel, 3, 33);
    return code ? code : cvol_array_convolve_kernel(context, result, a, &kernel, &all);
}

static int halve(cvol_context *context, cvol_array **result, const cvol_array *a,
                 const cvol_array *b)
{
    const cvol_keep all = cvol_keep_all();
    (void)b;
    return cvol_array_resample(context, result, a, -2, &all);
}

static int twice(cvol_context *context, cvol_array **result, const cvol_array *a,
                 const cvol_array *b)
{
    const cvol_keep all = cvol_keep_all();
    (void)b;
    return cvol_array_resample(context, result, a, 2, &all);
}

static void expect_same_figures(cvol_context *context, cvol_array *const got[2],
                                cvol_array *const wanted[2])
{
    cvol_array_statistics one, other;
    assert_int_equal(cvol_array_compute_statistics(context, &one, got[0]), 0);
    assert_int_equal(cvol_array_compute_statistics(context, &other, wanted[0]), 0);
    assert_true(fabs(one.sum - other.sum) <= 1e-5 * fabs(other.sum));
    assert_true(fabs(one.l2_norm - other.l2_norm) <= 1e-5 * other.l2_norm);
    assert_true(fabs(one.standard_deviation - other.standard_deviation) <=
                1e-4 * other.standard_deviation);
    cvol_array_comparison near, expected;
    assert_int_equal(cvol_array_compare(context, &near, got[0], got[1]), 0);
    assert_int_equal(cvol_array_compare(context, &expected, wanted[0], wanted[1]), 0);
    assert_true(fabs(near.inner_product - expected.inner_product) <=
                1e-5 * fabs(expected.inner_product));
    assert_true(fabs(near.distance - expected.distance) <= 1e-4 * expected.distance);
}

/* Two operands may each be lapped or not: all four combinations give the result of plain ones. */
static void operations_accept_lapped_volumes(void **state)
{
    (void)state;
    cell_operation *const operations[] = {
        cell_add,    cell_multiply, cell_scale,    cell_one_minus, cell_truncate_all,
        cell_filter, filter_widely, cell_gradient, halve,          twice};
    cvol_context *context = cvol_context_create();
    for (uint64_t seed = 1; seed <= 3; seed++) {
        random_state r = {seed};
        cvol_array *lapped[2], *plain[2];
        for (int i = 0; i < 2; i++) {
            lapped[i] = random_lapped(context, &r, shape, 0.05);
            plain[i] = plain_twin(context, lapped[i]);
        }
        for (int way = 1; way < 4; way++) {
            cvol_array *const of[2] = {way & 1 ? lapped[0] : plain[0],
                                       way & 2 ? lapped[1] : plain[1]};
            for (size_t k = 0; k < sizeof operations / sizeof *operations; k++) {
                cvol_array *got, *expected;
                if (k > 1 && way != 1) /* one operand */
                    continue;
                assert_int_equal(operations[k](context, &got, of[0], of[1]), 0);
                assert_int_equal(operations[k](context, &expected, plain[0], plain[1]), 0);
                expect_near(context, got, expected);
                cvol_array_free(got);
                cvol_array_free(expected);
            }
            expect_same_figures(context, of, plain);
        }
        for (int i = 0; i < 2; i++) {
            cvol_array_free(lapped[i]);
            cvol_array_free(plain[i]);
        }
    }
    cvol_context_free(context);
}

static void points_are_interpolated_from_samples(void **state)
{
    (void)state;
    enum { POINTS = 600 };
    static double points[3 * POINTS];
    static float got[POINTS], expected[POINTS];
    cvol_context *context = cvol_context_create();
    random_state r = {5};
    cvol_array *lapped = random_lapped(context, &r, shape, 0.05);
    cvol_array *plain = plain_twin(context, lapped);
    for (int i = 0; i < 3 * POINTS; i++) {
        points[i] = random_signed(&r) * 0.5 * (double)(shape[i % 3] + 2) +
                    0.5 * (double)shape[i % 3];
        if (i % 2)
            points[i] = rint(points[i]);
    }
    assert_int_equal(cvol_array_evaluate_points(context, got, lapped, points, POINTS), 0);
    assert_int_equal(cvol_array_evaluate_points(context, expected, plain, points, POINTS), 0);
    for (int i = 0; i < POINTS; i++)
        assert_true(fabs((double)got[i] - (double)expected[i]) < 1e-4);
    cvol_array_free(lapped);
    cvol_array_free(plain);
    cvol_context_free(context);
}

static void split_cells_are_interpolated_too(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    random_state r = {6};
    float *samples = random_samples(&r, shape), *all = malloc(SAMPLES * sizeof *all);
    assert_non_null(all);
    cvol_array *array = support_lapped(context, samples, shape, 0, 0.05, 1, 9);
    array->lapped = 0; /* other samples, with split cells */
    support_lapped_samples(all, array);
    for (int i = 0; i < 300; i++) {
        const size_t at[3] = {random_below(&r, 40), random_below(&r, 35), random_below(&r, 50)};
        const double point[3] = {(double)at[0], (double)at[1], (double)at[2]};
        const float wanted = all[at[0] + shape[0] * (at[1] + shape[1] * at[2])];
        float got;
        assert_int_equal(cvol_array_evaluate_points(context, &got, array, point, 1), 0);
        assert_true(fabs((double)got - (double)wanted) < 1e-4);
    }
    free(samples);
    free(all);
    cvol_array_free(array);
    cvol_context_free(context);
}

static void results_do_not_depend_on_threads(void **state)
{
    (void)state;
    static float x[SAMPLES], y[SAMPLES];
    const size_t begin[3] = {0, 0, 0};
    cvol_context *context = cvol_context_create();
    random_state r = {8};
    cvol_array *a = random_lapped(context, &r, shape, 0.05), *result;
    for (int threads = 1; threads <= 4; threads += 3) {
        cvol_context_set_threads(context, threads);
        assert_int_equal(cvol_array_multiply(context, &result, a, a, NULL, CVOL_PLAN_AUTO, NULL),
                         0);
        assert_int_equal(
            cvol_array_evaluate_real(context, threads == 1 ? x : y, result, begin, shape), 0);
        cvol_array_free(result);
    }
    assert_memory_equal(x, y, sizeof x);
    double sums[2];
    for (int i = 0; i < 2; i++) {
        cvol_context_set_threads(context, 1 + 3 * i);
        assert_int_equal(cvol_array_compute_inner_product(context, &sums[i], a, a), 0);
    }
    assert_memory_equal(&sums[0], &sums[1], sizeof sums[0]);
    cvol_array_free(a);
    cvol_context_free(context);
}

static void files_round_trip(void **state)
{
    (void)state;
    static float x[SAMPLES], y[SAMPLES];
    const size_t begin[3] = {0, 0, 0};
    cvol_context *context = cvol_context_create();
    random_state r = {1};
    cvol_array *array = random_lapped(context, &r, shape, 0.05), *read;
    assert_int_equal(cvol_array_write(context, array, "lapped.cvol", NULL), CVOL_OK);
    assert_int_equal(cvol_array_read(context, &read, "lapped.cvol", NULL), CVOL_OK);
    assert_int_equal(read->lapped, 1);
    assert_int_equal(cvol_array_evaluate_real(context, x, array, begin, shape), 0);
    assert_int_equal(cvol_array_evaluate_real(context, y, read, begin, shape), 0);
    assert_memory_equal(x, y, sizeof x);
    remove("lapped.cvol");
    cvol_array_free(read);
    cvol_array_free(array);
    cvol_context_free(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_equal_the_whole),
        cmocka_unit_test(only_quantization_loses),
        cmocka_unit_test(distance_is_the_same_for_any_threads),
        cmocka_unit_test(ranges_equal_those_of_samples),
        cmocka_unit_test(operations_accept_lapped_volumes),
        cmocka_unit_test(points_are_interpolated_from_samples),
        cmocka_unit_test(split_cells_are_interpolated_too),
        cmocka_unit_test(results_do_not_depend_on_threads),
        cmocka_unit_test(files_round_trip),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
