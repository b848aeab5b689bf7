/* The plan `low`: products of arrays of low and scattered terms, against products in double
 * precision of the samples that the operands evaluate to, and of the original samples. */
#include "test.h"

#include "array/core/array.h"
#include "array/core/spectrum.h"
#include "base/context.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "transform/whole.h"

static const cvol_transform transforms[] = {CVOL_DCT, CVOL_DHT, CVOL_DFT};
static const size_t shapes[][3] = {{400, 1, 1}, {331, 1, 1}, {20, 24, 1},
                                   {17, 32, 1}, {7, 8, 10},  {9, 6, 11}};
#define SHAPES (sizeof shapes / sizeof shapes[0])

static uint64_t seed; /* of the case at hand, for messages */

static size_t count_of(const size_t dims[3])
{
    return dims[0] * dims[1] * dims[2];
}

static int rank_of(const size_t dims[3])
{
    return dims[2] > 1 ? 3 : dims[1] > 1 ? 2 : 1;
}

/* Boxes of random values, whose faces need scattered terms, and some noise. */
static float *make_samples(const size_t dims[3], random_state *r)
{
    const size_t n = count_of(dims);
    float *out = calloc(n, sizeof *out);
    assert_non_null(out);
    for (int box = 0; box < 4; box++) {
        size_t begin[3], end[3];
        for (int i = 0; i < 3; i++) {
            begin[i] = random_below(r, (uint32_t)dims[i]);
            end[i] = begin[i] + 1 + random_below(r, (uint32_t)(dims[i] - begin[i]));
        }
        const float value = (float)random_signed(r);
        for (size_t z = begin[2]; z < end[2]; z++)
            for (size_t y = begin[1]; y < end[1]; y++)
                for (size_t x = begin[0]; x < end[0]; x++)
                    out[x + dims[0] * (y + dims[1] * z)] += value;
    }
    for (size_t i = 0; i < n; i++)
        out[i] += 0.02F * (float)random_signed(r);
    return out;
}

/* Averages of neighbours along x and y, so that high frequencies are weak. */
static void smooth(float *samples, const size_t dims[3])
{
    const size_t n = dims[0] * dims[1], strides[2] = {1, dims[0]};
    for (int pass = 0; pass < 6; pass++)
        for (size_t i = 0; i + strides[pass % 2] < n; i++)
            samples[i] = 0.5F * (samples[i] + samples[i + strides[pass % 2]]);
}

static cvol_array *compress(const float *samples, const size_t dims[3], cvol_transform transform,
                            const cvol_keep *keep)
{
    const cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_FLOAT32);
    cvol_array *array;
    assert_int_equal(
        cvol_array_compress(context, &array, samples, &grid, rank_of(dims), transform, 0, keep),
        CVOL_OK);
    return array;
}

/* The samples that an array evaluates to, in double precision. */
static double *samples_of(const cvol_array *array)
{
    const size_t *dims = array->grid.dims, count = count_of(dims);
    float *slots = malloc(count * sizeof *slots);
    double *wide = malloc(count * sizeof *wide), *samples = malloc(count * sizeof *samples);
    assert_true(slots && wide && samples);
    cvol_spectrum_scatter(slots, &array->whole, dims);
    for (size_t i = 0; i < count; i++)
        wide[i] = (double)slots[i];
    cvol_whole_inverse_reference(array->transform, samples, wide, dims);
    free(slots);
    free(wide);
    return samples;
}

/* The L2 norm of out - x y. */
static double error_of(const cvol_array *out, const double *x, const double *y)
{
    double *z = samples_of(out), sum = 0, largest = 0;
    for (size_t i = 0; i < count_of(out->grid.dims); i++) {
        sum += (z[i] - x[i] * y[i]) * (z[i] - x[i] * y[i]);
        largest = fmax(largest, fabs(z[i]));
    }
    assert_true(largest <= out->error_bound.max_abs);
    free(z);
    return sqrt(sum);
}

static double *doubles_of(const float *samples, size_t n)
{
    double *out = malloc(n * sizeof *out);
    assert_non_null(out);
    for (size_t i = 0; i < n; i++)
        out[i] = (double)samples[i];
    return out;
}

/* The L2 norm of out - a b, by transforms in single precision: for large arrays. */
static double error_by_floats(const cvol_array *out, const cvol_array *a, const cvol_array *b)
{
    static const size_t begin[3] = {0, 0, 0};
    const cvol_array *arrays[3] = {out, a, b};
    const size_t n = count_of(out->grid.dims);
    float *values[3];
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        values[i] = malloc(n * sizeof *values[i]);
        assert_non_null(values[i]);
        assert_int_equal(
            cvol_array_evaluate_real(context, values[i], arrays[i], begin, out->grid.dims),
            CVOL_OK);
    }
    for (size_t i = 0; i < n; i++) {
        const double difference = (double)values[0][i] -
                                  (double)values[1][i] * (double)values[2][i];
        sum += difference * difference;
    }
    for (int i = 0; i < 3; i++)
        free(values[i]);
    return sqrt(sum);
}

static cvol_array *multiply(const cvol_array *a, const cvol_array *b, const cvol_keep *keep,
                            cvol_plan plan, cvol_multiply_report *report)
{
    cvol_array *out;
    const int code = cvol_array_multiply(context, &out, a, b, keep, plan, report);
    if (code)
        print_error("%s, seed %llu: %s\n", cvol_plan_name(plan), (unsigned long long)seed,
                    cvol_context_message(context));
    assert_int_equal(code, CVOL_OK);
    return out;
}

/* Returns 1 if the plan left out terms. */
static int check_case(const size_t dims[3], cvol_transform transform, random_state *r)
{
    const size_t n = count_of(dims);
    float *x = make_samples(dims, r), *y = make_samples(dims, r);
    const cvol_keep kept = cvol_keep_terms(1 + random_below(r, (uint32_t)(dims[0] / 4)) % 5,
                                           n / 40 + random_below(r, (uint32_t)(n / 8)));
    cvol_array *a = compress(x, dims, transform, &kept), *b = compress(y, dims, transform, &kept);
    const double carried = cvol_error_bound_multiply(&a->error_bound, &b->error_bound).l2_error;
    const double limit = carried * (0.02 + 0.2 * fabs(random_signed(r)));
    const cvol_keep keeps[] = {cvol_keep_like_inputs(), cvol_keep_l2(limit), cvol_keep_psnr(30)};
    double *kept_x = samples_of(a), *kept_y = samples_of(b);
    double *all_x = doubles_of(x, n), *all_y = doubles_of(y, n);
    int some = 0;
    for (int k = 0; k < 3; k++) {
        cvol_multiply_report report;
        cvol_array *out = multiply(a, b, &keeps[k], CVOL_PLAN_LOW, &report);
        const double own = error_of(out, kept_x, kept_y), all = error_of(out, all_x, all_y);
        const double bound = out->error_bound.l2_error;
        some |= report.left_out > 0;
        const int good = own <= bound - carried && all <= bound && (k != 1 || own <= limit) &&
                         report.left_out <= (k ? INFINITY : 0.2 * carried) * (1 + 1e-9) &&
                         report.plan == CVOL_PLAN_LOW;
        if (!good)
            print_error("%s %zux%zux%zu keep %d, seed %llu: error %g, bound %g, carried %g, limit "
                        "%g, error of originals %g, left out %g\n",
                        cvol_transform_name(transform), dims[0], dims[1], dims[2], k,
                        (unsigned long long)seed, own, bound, carried, limit, all, report.left_out);
        assert_true(good);
        cvol_array_free(out);
    }
    cvol_array_free(a);
    cvol_array_free(b);
    free(kept_x);
    free(kept_y);
    free(all_x);
    free(all_y);
    free(x);
    free(y);
    return some;
}

static void test_bounds(void **state)
{
    (void)state;
    int cases = 0, some = 0;
    for (size_t s = 0; s < SHAPES; s++)
        for (size_t t = 0; t < 3; t++)
            for (int round = 0; round < 4; round += SUPPORT_STRIDE) {
                random_state r = {.state = seed = 1000 * s + 100 * t + (unsigned)round};
                some += check_case(shapes[s], transforms[t], &r);
                cases++;
            }
    if (test_verbose())
        print_message("%d of %d cases left out terms; seeds 1000 shape + 100 transform + round\n",
                      some, cases);
    assert_true(some > cases / 2);
}

/* The plan is chosen where it saves points; chains of products lose no more than twice what `full`
 * loses, although their bounds grow. */
static void test_choice(void **state)
{
    (void)state;
    static const size_t dims[3] = {512, 384, 1};
    random_state r = {.state = seed = 7};
    float *x = make_samples(dims, &r);
    smooth(x, dims);
    const cvol_keep kept = cvol_keep_rho(1 / 30.0);
    for (size_t t = 0; t < 3; t++) {
        cvol_array *a = compress(x, dims, transforms[t], &kept), *p = a, *q = a;
        cvol_multiply_report report;
        for (int step = 0; step < 3; step++) {
            cvol_array *low = multiply(p, a, NULL, CVOL_PLAN_AUTO, &report);
            cvol_array *full = multiply(q, a, NULL, CVOL_PLAN_FULL, NULL);
            const double ours = error_by_floats(low, p, a), best = error_by_floats(full, q, a);
            if (test_verbose())
                print_message("%s step %d: plan %s, error %g, full %g, left out %g\n",
                              cvol_transform_name(transforms[t]), step, cvol_plan_name(report.plan),
                              ours, best, report.left_out);
            assert_true(ours <= 2 * best);
            if (step == 0) {
                assert_int_equal(report.plan, CVOL_PLAN_LOW);
                assert_true(report.points[0] * report.points[1] < count_of(dims));
            }
            if (p != a) {
                cvol_array_free(p);
                cvol_array_free(q);
            }
            p = low;
            q = full;
        }
        cvol_array_free(p);
        cvol_array_free(q);
        cvol_array_free(a);
    }
    free(x);
}

/* Exact operands lose nothing, and rules without a limit refuse the plan. */
static void test_nothing_allowed(void **state)
{
    (void)state;
    static const size_t dims[3] = {30, 20, 1};
    random_state r = {.state = seed = 11};
    float *x = make_samples(dims, &r);
    const cvol_keep all = cvol_keep_all(), rho = cvol_keep_rho(0.1);
    cvol_array *a = compress(x, dims, CVOL_DCT, &all), *out;
    a->error_bound.l2_error = 0;
    cvol_multiply_report report;
    out = multiply(a, a, NULL, CVOL_PLAN_LOW, &report);
    assert_true(!(report.left_out > 0));
    assert_true(error_by_floats(out, a, a) <= 2 * out->error_bound.l2_error);
    cvol_array_free(out);
    assert_int_equal(cvol_array_multiply(context, &out, a, a, &rho, CVOL_PLAN_LOW, NULL),
                     CVOL_ERROR_UNSUPPORTED);
    assert_non_null(strstr(cvol_context_message(context), "like_inputs, l2 and psnr"));
    cvol_array_free(a);
    free(x);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bounds),
        cmocka_unit_test(test_choice),
        cmocka_unit_test(test_nothing_allowed),
    };
    return cmocka_run_group_tests(tests, context_setup_one, context_teardown);
}
