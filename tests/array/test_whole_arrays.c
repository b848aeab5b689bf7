/* Whole arrays: compressing, evaluating, linear operations and statistics against dense samples,
 * and every certified bound against the measured error. */
#include "test.h"

#include "array/core/array.h"
#include "cvol/algebra.h"
#include "random.h"
#include "support_context.h"
#include "transform/whole.h"

#define MAX_SAMPLES 8000

#define CHECK(condition)                                                  \
    do {                                                                  \
        if (!(condition)) {                                               \
            print_error("seed %u: %s (%s)\n", (unsigned)seed, #condition, \
                        cvol_context_message(context));                   \
            fail();                                                       \
        }                                                                 \
    } while (0)

/* An array and its samples. */
typedef struct pair {
    cvol_array *array;
    double exact[MAX_SAMPLES];
} pair;

static pair first, second, result;
static float evaluated[MAX_SAMPLES], original[MAX_SAMPLES];

static size_t count_of(const cvol_array *array)
{
    return cvol_grid_samples(cvol_array_grid(array));
}

static cvol_grid random_grid(int *rank, random_state *r)
{
    static const size_t lengths[] = {1, 2, 3, 4, 5, 7, 8, 12, 13, 16, 17, 18};
    size_t dims[3];
    *rank = 1 + (int)random_below(r, 3);
    for (int a = 0; a < 3; a++)
        dims[a] = a < *rank ? lengths[random_below(r, 12)] : 1;
    if (*rank == 1 && random_below(r, 3) == 0)
        dims[0] = 1 + random_below(r, 2000);
    return cvol_grid_make(dims[0], dims[1], dims[2], CVOL_FLOAT32);
}

/* Smooth, rough, constant or zero samples. */
static void random_samples(const cvol_grid *grid, random_state *r)
{
    const uint32_t kind = random_below(r, 8);
    const double scale = pow(10, 4 * random_signed(r)), mean = 3 * random_signed(r);
    const double wave = 0.3 * fabs(random_signed(r));
    for (size_t i = 0; i < cvol_grid_samples(grid); i++) {
        const double x = (double)(i % grid->dims[0]), y = (double)(i / grid->dims[0]);
        const double rough = random_signed(r);
        const double value = kind == 0   ? 0
                             : kind == 1 ? mean
                             : kind < 5  ? mean + sin(wave * x) * cos(0.2 * y) + 0.05 * rough
                                         : mean + rough;
        original[i] = (float)(scale * value);
    }
}

static cvol_keep random_keep(const cvol_grid *grid, int rank, random_state *r)
{
    const uint32_t n = (uint32_t)cvol_grid_samples(grid);
    cvol_keep keep = cvol_keep_all();
    switch (random_below(r, 6)) {
    case 0:
        return keep;
    case 1:
        keep = cvol_keep_terms(0, random_below(r, n + 1));
        break;
    case 2:
        keep = cvol_keep_terms(0, 0);
        break;
    case 3:
        return cvol_keep_rho(fabs(random_signed(r)));
    case 4:
        return cvol_keep_psnr(60 * fabs(random_signed(r)));
    default:
        keep = cvol_keep_threshold(fabs(random_signed(r)));
    }
    if (random_below(r, 3))
        for (int a = 0; a < rank; a++)
            keep.low[a] = 1 + random_below(r, (uint32_t)grid->dims[a]);
    return keep;
}

static int random_pair(pair *out, const cvol_grid *grid, int rank, cvol_transform transform,
                       random_state *r)
{
    cvol_keep keep = random_keep(grid, rank, r);
    random_samples(grid, r);
    for (size_t i = 0; i < cvol_grid_samples(grid); i++)
        out->exact[i] = (double)original[i];
    int code = cvol_array_compress(context, &out->array, original, grid, rank, transform, 0, &keep);
    /* A PSNR of nearly constant samples can be beyond single precision. */
    if (code == CVOL_ERROR_TARGET && keep.rule == CVOL_KEEP_PSNR) {
        keep = cvol_keep_all();
        code = cvol_array_compress(context, &out->array, original, grid, rank, transform, 0, &keep);
    }
    return code;
}

static void evaluate(unsigned seed, const cvol_array *array)
{
    const size_t begin[3] = {0};
    CHECK(cvol_array_evaluate_real(context, evaluated, array, begin,
                                   cvol_array_grid(array)->dims) == CVOL_OK);
}

/* Checks all members of p->array's error bound. */
static void check_bounds(unsigned seed, const pair *p)
{
    cvol_array_info info;
    double error = 0;
    cvol_array_get_info(&info, p->array);
    evaluate(seed, p->array);
    for (size_t i = 0; i < count_of(p->array); i++) {
        const double difference = (double)evaluated[i] - p->exact[i];
        const double slack = 1e-12 * (info.value_max - info.value_min + fabs(p->exact[i]));
        error += difference * difference;
        CHECK(fabs((double)evaluated[i]) <= info.max_abs);
        CHECK(p->exact[i] >= info.value_min - slack && p->exact[i] <= info.value_max + slack);
    }
    CHECK(sqrt(error) <= info.l2_error);
    CHECK(!info.measured && info.max_error >= sqrt(error));
}

static void test_bounds_of_compressing(void **state)
{
    (void)state;
    for (unsigned seed = 0; seed < 1500; seed++) {
        random_state r = {.state = seed};
        int rank;
        const cvol_grid grid = random_grid(&rank, &r);
        const cvol_transform transform = (cvol_transform)(1 + seed % 3);
        cvol_context_set_threads(context, seed % 8 == 0 ? 2 : 1);
        CHECK(random_pair(&first, &grid, rank, transform, &r) == CVOL_OK);
        check_bounds(seed, &first);
        cvol_array_free(first.array);
    }
    cvol_context_set_threads(context, 1);
}

/* Boxes, by sums and by transform, against the direct sums. */
static void test_boxes(void **state)
{
    (void)state;
    static double slots[MAX_SAMPLES], samples[MAX_SAMPLES];
    static float dense[MAX_SAMPLES];
    for (unsigned seed = 0; seed < 600; seed++) {
        random_state r = {.state = seed};
        int rank;
        cvol_grid grid = random_grid(&rank, &r);
        if (cvol_grid_samples(&grid) > 900)
            continue;
        const cvol_transform transform = (cvol_transform)(1 + seed % 3);
        CHECK(random_pair(&first, &grid, rank, transform, &r) == CVOL_OK);
        const size_t n = cvol_grid_samples(&grid), *dims = grid.dims;
        double norm = 0;
        cvol_spectrum_scatter(dense, &first.array->whole, dims);
        for (size_t i = 0; i < n; i++) {
            slots[i] = (double)dense[i];
            norm += slots[i] * slots[i];
        }
        cvol_whole_inverse_reference(transform, samples, slots, dims);
        for (int box = 0; box < 6; box++) {
            size_t begin[3], end[3];
            for (int a = 0; a < 3; a++) {
                begin[a] = random_below(&r, (uint32_t)dims[a]);
                end[a] = begin[a] + 1;
                if (box > 1)
                    end[a] += random_below(&r, (uint32_t)(dims[a] - begin[a]));
            }
            CHECK(cvol_array_evaluate_real(context, evaluated, first.array, begin, end) == CVOL_OK);
            size_t i = 0;
            for (size_t z = begin[2]; z < end[2]; z++)
                for (size_t y = begin[1]; y < end[1]; y++)
                    for (size_t x = begin[0]; x < end[0]; x++, i++)
                        CHECK(fabs((double)evaluated[i] -
                                   samples[x + dims[0] * (y + dims[1] * z)]) <= 1e-6 * sqrt(norm));
        }
        cvol_array_free(first.array);
    }
}

static void test_linear_operations(void **state)
{
    (void)state;
    for (unsigned seed = 0; seed < 1500; seed++) {
        random_state r = {.state = 77 + seed};
        int rank;
        const cvol_grid grid = random_grid(&rank, &r);
        const cvol_transform transform = (cvol_transform)(1 + seed % 3);
        const double alpha = random_below(&r, 5) ? 5 * random_signed(&r) : 0;
        const double beta = random_below(&r, 5) ? 5 * random_signed(&r) : 0;
        cvol_keep keep = random_keep(&grid, rank, &r);
        const cvol_keep *kept = random_below(&r, 2) ? &keep : NULL;
        const size_t n = cvol_grid_samples(&grid);
        CHECK(random_pair(&first, &grid, rank, transform, &r) == CVOL_OK);
        CHECK(random_pair(&second, &grid, rank, transform, &r) == CVOL_OK);

        int code = cvol_array_add(context, &result.array, alpha, first.array, beta, second.array,
                                  kept);
        CHECK(code == CVOL_OK || (code == CVOL_ERROR_TARGET && kept));
        for (size_t i = 0; i < n; i++)
            result.exact[i] = alpha * first.exact[i] + beta * second.exact[i];
        if (!code)
            check_bounds(seed, &result);
        cvol_array_free(result.array);

        CHECK(cvol_array_scale(context, &result.array, alpha, first.array, beta) == CVOL_OK);
        for (size_t i = 0; i < n; i++)
            result.exact[i] = alpha * first.exact[i] + beta;
        check_bounds(seed, &result);
        cvol_array_free(result.array);

        CHECK(cvol_array_one_minus(context, &result.array, first.array) == CVOL_OK);
        for (size_t i = 0; i < n; i++)
            result.exact[i] = 1 - first.exact[i];
        check_bounds(seed, &result);
        cvol_array_free(result.array);

        CHECK(cvol_array_negate(context, &result.array, first.array) == CVOL_OK);
        for (size_t i = 0; i < n; i++)
            result.exact[i] = -first.exact[i];
        check_bounds(seed, &result);
        cvol_array_free(result.array);

        code = cvol_array_truncate(context, &result.array, first.array, kept);
        CHECK(code == CVOL_OK || (code == CVOL_ERROR_TARGET && kept));
        memcpy(result.exact, first.exact, sizeof result.exact);
        if (!code)
            check_bounds(seed, &result);
        cvol_array_free(result.array);
        cvol_array_free(first.array);
        cvol_array_free(second.array);
    }
}

/* The union of the terms, exactly: nothing is dropped, and a - a is 0. */
static void test_add_is_exact(void **state)
{
    (void)state;
    for (unsigned seed = 0; seed < 400; seed++) {
        random_state r = {.state = 5000 + seed};
        int rank;
        const cvol_grid grid = random_grid(&rank, &r);
        const cvol_transform transform = (cvol_transform)(1 + seed % 3);
        static float a[MAX_SAMPLES], b[MAX_SAMPLES], c[MAX_SAMPLES];
        CHECK(random_pair(&first, &grid, rank, transform, &r) == CVOL_OK);
        CHECK(random_pair(&second, &grid, rank, transform, &r) == CVOL_OK);
        CHECK(cvol_array_add(context, &result.array, 2, first.array, -3, second.array, NULL) ==
              CVOL_OK);
        cvol_spectrum_scatter(a, &first.array->whole, grid.dims);
        cvol_spectrum_scatter(b, &second.array->whole, grid.dims);
        cvol_spectrum_scatter(c, &result.array->whole, grid.dims);
        for (size_t i = 0; i < cvol_grid_samples(&grid); i++)
            CHECK(fabs((double)c[i] - (2 * (double)a[i] - 3 * (double)b[i])) <=
                  2e-7 * (2 * fabs((double)a[i]) + 3 * fabs((double)b[i])));
        const cvol_spectrum *s = &result.array->whole;
        for (size_t i = 1; i < s->sparse_count; i++)
            CHECK(s->places[i - 1] < s->places[i]);
        CHECK(s->sparse_count == s->sparse_capacity);
        cvol_array_free(result.array);
        CHECK(cvol_array_add(context, &result.array, 1, first.array, -1, first.array, NULL) ==
              CVOL_OK);
        CHECK(cvol_spectrum_energy(&result.array->whole) <= 0);
        cvol_array_free(result.array);
        cvol_array_free(first.array);
        cvol_array_free(second.array);
    }
}

/* Close to the evaluated samples, and within the bounds of the exact ones. */
static void test_statistics(void **state)
{
    (void)state;
    static double a[MAX_SAMPLES], b[MAX_SAMPLES];
    for (unsigned seed = 0; seed < 800; seed++) {
        random_state r = {.state = 9000 + seed};
        int rank;
        const cvol_grid grid = random_grid(&rank, &r);
        const cvol_transform transform = (cvol_transform)(1 + seed % 3);
        const size_t n = cvol_grid_samples(&grid);
        CHECK(random_pair(&first, &grid, rank, transform, &r) == CVOL_OK);
        CHECK(random_pair(&second, &grid, rank, transform, &r) == CVOL_OK);
        evaluate(seed, first.array);
        for (size_t i = 0; i < n; i++)
            a[i] = (double)evaluated[i];
        evaluate(seed, second.array);
        for (size_t i = 0; i < n; i++)
            b[i] = (double)evaluated[i];
        cvol_array_statistics s;
        cvol_array_comparison c;
        CHECK(cvol_array_compute_statistics(context, &s, first.array) == CVOL_OK);
        CHECK(cvol_array_compare(context, &c, first.array, second.array) == CVOL_OK);
        double inner;
        CHECK(cvol_array_compute_inner_product(context, &inner, first.array, second.array) ==
              CVOL_OK);
        CHECK(inner == c.inner_product);
        for (int exact = 0; exact < 2; exact++) {
            const double *x = exact ? first.exact : a, *y = exact ? second.exact : b;
            double sum = 0, xx = 0, yy = 0, xy = 0, distance = 0, variance = 0;
            for (size_t i = 0; i < n; i++) {
                sum += x[i];
                xx += x[i] * x[i];
                yy += y[i] * y[i];
                xy += x[i] * y[i];
                distance += (x[i] - y[i]) * (x[i] - y[i]);
            }
            for (size_t i = 0; i < n; i++)
                variance += (x[i] - sum / (double)n) * (x[i] - sum / (double)n) / (double)n;
            const double norm = sqrt(xx), other = sqrt(yy), root = sqrt((double)n);
            const double near = exact ? 1e-12 : 1e-6;
            CHECK(fabs(s.sum - sum) <= near * norm * root + exact * s.sum_error);
            CHECK(fabs(s.mean - sum / (double)n) <= near * norm / root + exact * s.mean_error);
            CHECK(fabs(s.standard_deviation - sqrt(variance)) <=
                  near * norm / root + exact * s.standard_deviation_error);
            CHECK(fabs(s.l2_norm - norm) <= near * norm + exact * s.l2_norm_error);
            CHECK(fabs(c.inner_product - xy) <=
                  near * norm * other + exact * c.inner_product_error);
            CHECK(fabs(c.distance - sqrt(distance)) <=
                  near * (norm + other) + exact * c.distance_error);
            if (!exact && norm > 0 && other > 0)
                CHECK(fabs(c.cosine_similarity - xy / norm / other) <= 1e-5);
        }
        CHECK(cvol_array_compare(context, &c, first.array, first.array) == CVOL_OK);
        CHECK(c.distance <= 0);
        cvol_array_free(first.array);
        cvol_array_free(second.array);
    }
}

/* A variance far below the mean's square. */
static void test_variance_does_not_cancel(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(1000, 1, 1, CVOL_FLOAT32);
    for (size_t i = 0; i < 1000; i++)
        original[i] = i % 2 ? 1 : -1;
    cvol_keep keep = cvol_keep_all();
    cvol_array_statistics s;
    assert_int_equal(
        cvol_array_compress(context, &first.array, original, &grid, 1, CVOL_DFT, 0, &keep), 0);
    assert_int_equal(cvol_array_scale(context, &second.array, 1, first.array, 1e9), CVOL_OK);
    assert_int_equal(cvol_array_compute_statistics(context, &s, second.array), CVOL_OK);
    assert_true(fabs(s.standard_deviation - 1) < 1e-5);
    cvol_array_free(first.array);
    cvol_array_free(second.array);
}

/* Round trip of every sample type: ALL gives integers of up to 16 bits exactly. */
static void test_types(void **state)
{
    (void)state;
    for (int type = CVOL_UINT8; type <= CVOL_FLOAT64; type++)
        for (int t = CVOL_DCT; t <= CVOL_DFT; t++) {
            unsigned seed = (unsigned)type;
            random_state r = {.state = seed};
            cvol_grid grid = cvol_grid_make(13, 7, 5, (cvol_type)type);
            const size_t bytes = cvol_grid_bytes(&grid), begin[3] = {0};
            uint8_t *samples = malloc(bytes), *back = malloc(bytes);
            for (size_t i = 0; i < bytes; i++)
                samples[i] = (uint8_t)random_u64(&r);
            for (size_t i = 0; i < cvol_grid_samples(&grid) && type >= CVOL_FLOAT32; i++) {
                const double value = random_signed(&r);
                const float rounded = (float)value;
                if (type == CVOL_FLOAT32)
                    memcpy(samples + 4 * i, &rounded, 4);
                else
                    memcpy(samples + 8 * i, &value, 8);
            }
            cvol_keep keep = cvol_keep_all();
            CHECK(cvol_array_compress(context, &first.array, samples, &grid, 3, (cvol_transform)t,
                                      0, &keep) == CVOL_OK);
            CHECK(cvol_array_grid(first.array)->type == (cvol_type)type);
            CHECK(cvol_array_evaluate_box(context, back, first.array, begin, grid.dims) == CVOL_OK);
            if (type <= CVOL_INT16)
                assert_memory_equal(samples, back, bytes);
            free(samples);
            free(back);
            cvol_array_free(first.array);
        }
}

static void test_padded(void **state)
{
    (void)state;
    for (unsigned seed = 0; seed < 60; seed++) {
        random_state r = {.state = seed};
        int rank;
        cvol_grid grid = random_grid(&rank, &r);
        for (int a = 0; a < 3; a++)
            grid.dims[a] = grid.dims[a] > 9 ? 9 : grid.dims[a];
        random_samples(&grid, &r);
        cvol_keep keep = cvol_keep_rho(0.5);
        CHECK(cvol_array_compress_padded(context, &result.array, original, &grid, rank,
                                         (cvol_transform)(1 + seed % 3), &keep) == CVOL_OK);
        const size_t *dims = cvol_array_grid(result.array)->dims;
        memset(result.exact, 0, sizeof result.exact);
        for (int a = 0; a < 3; a++)
            CHECK(dims[a] == (a < rank ? 2 : 1) * grid.dims[a]);
        for (size_t i = 0; i < cvol_grid_samples(&grid); i++)
            result
                .exact[i % grid.dims[0] + dims[0] * (i / grid.dims[0] % grid.dims[1] +
                                                     dims[1] * (i / grid.dims[0] / grid.dims[1]))] =
                (double)original[i];
        check_bounds(seed, &result);
        cvol_array_free(result.array);
    }
}

static void refuse(int code, int expected, const char *words)
{
    if (code != expected || !strstr(cvol_context_message(context), words)) {
        print_error("%d: '%s' does not say '%s'\n", code, cvol_context_message(context), words);
        fail();
    }
}

static void test_refusals(void **state)
{
    (void)state;
    cvol_array *array = NULL, *other = NULL;
    cvol_grid grid = cvol_grid_make(12, 10, 1, CVOL_FLOAT32);
    cvol_keep keep = cvol_keep_all(), bad = cvol_keep_terms(13, 0);
    for (size_t i = 0; i < 120; i++)
        original[i] = (float)i;
#define COMPRESS(rule) cvol_array_compress(context, &array, original, &grid, 2, CVOL_DHT, 0, rule)
    refuse(COMPRESS(&bad), CVOL_ERROR_ARGUMENT, "k is 13 along x");
    bad = cvol_keep_terms(0, 121);
    refuse(COMPRESS(&bad), CVOL_ERROR_ARGUMENT, "s is 121");
    bad = cvol_keep_like_inputs();
    refuse(COMPRESS(&bad), CVOL_ERROR_ARGUMENT, "no inputs");
    bad = cvol_keep_step(1);
    refuse(COMPRESS(&bad), CVOL_ERROR_ARGUMENT, "a step quantizes blocks");
    bad = cvol_keep_psnr(160);
    refuse(COMPRESS(&bad), CVOL_ERROR_TARGET, "single precision");
    bad = cvol_keep_l2(0);
    refuse(COMPRESS(&bad), CVOL_ERROR_TARGET, "single precision");
    bad = cvol_keep_ratio(1e6);
    refuse(COMPRESS(&bad), CVOL_ERROR_TARGET, "ratio of 1e+06");
    bad = cvol_keep_rho(0.1);
    bad.low[0] = bad.low[1] = 5;
    refuse(COMPRESS(&bad), CVOL_ERROR_TARGET, "the low box 5 x 5");
    original[37] = NAN;
    original[51] = (float)INFINITY;
    refuse(COMPRESS(&keep), CVOL_ERROR_DATA,
           "2 samples are NaN or infinite, the first at (x, y, z) "
           "= (1, 3, 0) (index 37)");
    original[37] = original[51] = 1e19f;
    refuse(COMPRESS(&keep), CVOL_ERROR_DATA, "squares of 120 samples");
    assert_null(array);
    original[37] = original[51] = 1e17f;
    assert_int_equal(COMPRESS(&keep), CVOL_OK);
    refuse(cvol_array_add(context, &other, (double)NAN, array, 1, array, NULL), CVOL_ERROR_ARGUMENT,
           "alpha is");
    refuse(cvol_array_scale(context, &other, 1, array, (double)INFINITY), CVOL_ERROR_ARGUMENT,
           "beta is inf");
    refuse(cvol_array_scale(context, &other, 1e30, array, 0), CVOL_ERROR_DATA, "float32");
    refuse(cvol_array_add(context, &other, 1e30, array, 1e30, array, NULL), CVOL_ERROR_DATA,
           "float32");
    bad = cvol_keep_terms(11, 0);
    refuse(cvol_array_truncate(context, &other, array, &bad), CVOL_ERROR_ARGUMENT,
           "k is 11 along y");
    const size_t begin[3] = {0, 4, 0}, end[3] = {12, 4, 1};
    refuse(cvol_array_evaluate_real(context, evaluated, array, begin, end), CVOL_ERROR_ARGUMENT,
           "box 4 .. 4 on axis y");
    assert_null(other);
    cvol_array_free(array);
#undef COMPRESS
}

static int cancel(void *user, const char *what, double fraction)
{
    (void)what;
    (void)fraction;
    return --*(int *)user < 0;
}

static void test_cancelling(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(30, 20, 10, CVOL_FLOAT32);
    cvol_keep keep = cvol_keep_rho(0.1);
    random_state r = {.state = 3};
    random_samples(&grid, &r);
    int left = 0, code;
    do {
        int calls = left++;
        cvol_context_set_progress(context, cancel, &calls);
        code = cvol_array_compress(context, &first.array, original, &grid, 3, CVOL_DFT, 0, &keep);
        assert_true(code == CVOL_OK || (code == CVOL_ERROR_CANCELLED && !first.array));
    } while (code);
    cvol_context_set_progress(context, NULL, NULL);
    assert_true(left > 1);
    cvol_array_free(first.array);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bounds_of_compressing),
        cmocka_unit_test(test_boxes),
        cmocka_unit_test(test_linear_operations),
        cmocka_unit_test(test_add_is_exact),
        cmocka_unit_test(test_statistics),
        cmocka_unit_test(test_variance_does_not_cancel),
        cmocka_unit_test(test_types),
        cmocka_unit_test(test_padded),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_cancelling),
    };
    return cmocka_run_group_tests(tests, context_setup_one, context_teardown);
}
