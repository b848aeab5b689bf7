/* Floats of all magnitudes, outliers and NaN: lossless is exact to the bit, a maximum error holds,
 * a PSNR that terms cannot reach gives a lossless file, and an outlier costs a few bytes. */
#include "test.h"

#include <float.h>

#include "array/core/array.h"
#include "cvol/algebra.h"
#include "cvol/codec.h"
#include "cvol/transfer.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

enum { NX = 37, NY = 30, NZ = 33, COUNT = NX * NY * NZ };

static double smooth(size_t i)
{
    const double x = (double)(i % NX), y = (double)(i / NX % NY), z = (double)(i / NX / NY);
    return sin(0.15 * x + 0.1 * y) * cos(0.12 * z) + 0.02 * y;
}

static void set(void *samples, cvol_type type, size_t i, double value)
{
    if (type == CVOL_FLOAT32)
        ((float *)samples)[i] = (float)value;
    else
        ((double *)samples)[i] = value;
}

static double get(const void *samples, cvol_type type, size_t i)
{
    return type == CVOL_FLOAT32 ? (double)((const float *)samples)[i]
                                : ((const double *)samples)[i];
}

/* Compresses, writes, reads and decodes. The caller frees. */
static void *round_trip(uint64_t *bytes, cvol_compress_report *report, const void *samples,
                        const cvol_grid *grid, const cvol_compress_options *options,
                        const char *name)
{
    const size_t zero[3] = {0, 0, 0};
    cvol_array *array, *read;
    void *file, *back = malloc(cvol_grid_bytes(grid));
    size_t size;
    if (cvol_compress(context, &array, report, samples, grid, options) ||
        cvol_array_write_memory(context, array, &file, &size) ||
        cvol_array_read_memory(context, &read, file, size, name) ||
        cvol_array_evaluate_box(context, back, read, zero, grid->dims))
        fail_msg("%s: %s", name, cvol_context_message(context));
    *bytes = size;
    free(file);
    cvol_array_free(array);
    cvol_array_free(read);
    return back;
}

/* ---- lossless -------------------------------------------------------------------------------- */

/* A unit, the spread over the samples (in decades), and one different sample. */
typedef struct magnitude {
    cvol_type type;
    double unit, decades, other;
    const char *name;
} magnitude;

static const magnitude magnitudes[] = {
    {CVOL_FLOAT32, 1, 0, 9.97e36, "a fill of netCDF"},
    {CVOL_FLOAT32, 1, 0, FLT_MAX, "the largest float"},
    {CVOL_FLOAT32, 1, 0, -FLT_MAX, "the least float"},
    {CVOL_FLOAT32, 1e37, 0, 0, "large floats"},
    {CVOL_FLOAT32, 1e-38, 0, 0, "small floats"},
    {CVOL_FLOAT32, 1e-44, 0, 0, "denormal floats"},
    {CVOL_FLOAT32, 1, 70, 0, "floats of all magnitudes"},
    {CVOL_FLOAT64, 1e50, 0, 0, "large doubles"},
    {CVOL_FLOAT64, 1e-60, 0, 0, "small doubles"},
    {CVOL_FLOAT64, 1, 0, DBL_MAX, "the largest double"},
    {CVOL_FLOAT64, 1, 600, -DBL_MAX, "doubles of all magnitudes"},
    {CVOL_FLOAT64, 5e-324, 0, 1, "denormal doubles"},
};

static void *make(cvol_grid *grid, const magnitude *of)
{
    random_state r = {11};
    *grid = cvol_grid_make(NX, NY, NZ, of->type);
    void *samples = malloc(cvol_grid_bytes(grid));
    for (size_t i = 0; i < COUNT; i++)
        set(samples, of->type, i,
            of->unit * smooth(i) * pow(10, of->decades / 2 * random_signed(&r)));
    if (of->other != 0)
        set(samples, of->type, 1234, of->other);
    return samples;
}

static void test_lossless_is_to_the_bit(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof magnitudes / sizeof *magnitudes; k++) {
        const magnitude *of = &magnitudes[k];
        cvol_grid grid;
        cvol_compress_report report;
        uint64_t bytes;
        void *samples = make(&grid, of);
        cvol_compress_options options = cvol_compress_options_defaults();
        options.lossless = 1;
        void *back = round_trip(&bytes, &report, samples, &grid, &options, of->name);
        if (memcmp(samples, back, cvol_grid_bytes(&grid)) || !report.lossless)
            fail_msg("%s: not lossless", of->name);
        free(back);
        free(samples);
    }
}

/* Every target is kept, or the file is lossless. */
static void test_targets_at_all_magnitudes(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof magnitudes / sizeof *magnitudes; k++) {
        const magnitude *of = &magnitudes[k];
        cvol_grid grid;
        cvol_compress_report report;
        uint64_t bytes;
        void *samples = make(&grid, of);
        for (int t = 0; t < 2; t++) {
            cvol_compress_options options = cvol_compress_options_defaults();
            const double bound = 0.01 * of->unit;
            options.target = t ? CVOL_TARGET_MAX_ERROR : CVOL_TARGET_PSNR;
            options.target_value = t ? bound : 60;
            if (t && bound <= 0)
                continue;
            void *back = round_trip(&bytes, &report, samples, &grid, &options, of->name);
            double most = 0, squares = 0, lo = INFINITY, hi = -INFINITY;
            for (size_t i = 0; i < COUNT; i++) {
                const double value = get(samples, of->type, i);
                const double off = fabs(value - get(back, of->type, i));
                most = fmax(most, off);
                lo = fmin(lo, value);
                hi = fmax(hi, value);
                squares += off > 0 ? pow(off / 1e150, 2) : 0;
            }
            if (t && !(most <= bound))
                fail_msg("%s: error %g, %g was requested", of->name, most, bound);
            if (!t && !(sqrt(squares / COUNT) * 1e150 <= 1e-3 * (hi - lo)) && isfinite(hi - lo) &&
                hi - lo > 1e-140)
                fail_msg("%s: less than 60 dB", of->name);
            free(back);
        }
        free(samples);
    }
}

/* ---- outliers -------------------------------------------------------------------------------- */

static void test_outliers_cost_little(void **state)
{
    (void)state;
    static const double outliers[] = {0, 1e4, -1e6, 1e9};
    uint64_t bytes[4];
    for (int k = 0; k < 4; k++) {
        const magnitude of = {CVOL_FLOAT32, 1, 0, outliers[k], "outlier"};
        cvol_grid grid;
        cvol_compress_report report;
        void *samples = make(&grid, &of);
        cvol_compress_options options = cvol_compress_options_defaults();
        options.target = CVOL_TARGET_MAX_ERROR;
        options.target_value = 0.01;
        void *back = round_trip(&bytes[k], &report, samples, &grid, &options, of.name);
        for (size_t i = 0; i < COUNT; i++)
            if (!(fabs(get(back, CVOL_FLOAT32, i) - get(samples, CVOL_FLOAT32, i)) <= 0.01))
                fail_msg("outlier %g: sample %zu is %g instead of %g", outliers[k], i,
                         get(back, CVOL_FLOAT32, i), get(samples, CVOL_FLOAT32, i));
        if (test_verbose())
            print_message("outlier %g: %llu bytes\n", outliers[k], (unsigned long long)bytes[k]);
        free(back);
        free(samples);
    }
    for (int k = 1; k < 4; k++)
        if (bytes[k] > 2 * bytes[0] + 1000)
            fail_msg("outlier %g: %llu bytes, without %llu", outliers[k],
                     (unsigned long long)bytes[k], (unsigned long long)bytes[0]);
}

/* Mean and standard deviation are within their bounds. Sums of the original samples are scaled,
 * because their squares may underflow. */
static void check_statistics(const cvol_array *array, const void *samples, const cvol_grid *grid,
                             const char *name)
{
    cvol_array_statistics got;
    double sum = 0, squares = 0, largest = 0;
    for (size_t i = 0; i < COUNT; i++)
        largest = fmax(largest, fabs(get(samples, grid->type, i)));
    for (size_t i = 0; i < COUNT; i++)
        sum += get(samples, grid->type, i) / largest;
    const double mean = sum / COUNT;
    for (size_t i = 0; i < COUNT; i++)
        squares += pow(get(samples, grid->type, i) / largest - mean, 2);
    const double deviation = sqrt(squares / COUNT);
    check_ok(cvol_array_compute_statistics(context, &got, array));
    if (!(fabs(got.mean / largest - mean) <= got.mean_error / largest * (1 + 1e-9)))
        fail_msg("%s: mean %g +- %g, the samples have %g", name, got.mean, got.mean_error,
                 mean * largest);
    if (!(fabs(got.standard_deviation / largest - deviation) <=
          got.standard_deviation_error / largest * (1 + 1e-9)))
        fail_msg("%s: standard deviation %g +- %g, the samples have %g", name,
                 got.standard_deviation, got.standard_deviation_error, deviation * largest);
}

/* The histogram in a file is that of the samples, of outliers and of small objects, too. */
static void test_histogram_has_outliers(void **state)
{
    (void)state;
    cvol_volume volume = support_volume(NX, NY, NZ, CVOL_FLOAT32);
    float *samples = volume.data;
    for (int k = 0; k < 6; k++) {
        cvol_compress_options options = cvol_compress_options_defaults();
        cvol_compress_report report;
        cvol_histogram wanted, found;
        cvol_array *array, *read;
        void *file;
        size_t size;
        for (size_t i = 0; i < COUNT; i++)
            samples[i] = (float)(k < 3 ? 0 : smooth(i));
        for (size_t i = 0; i < 6; i++)
            samples[5000 + i] = (float)(0.5 * (double)(i + 1) * (k < 3 ? 1 : 100));
        samples[9] = k % 3 == 2 ? NAN : samples[9];
        options.lossless = k % 3 != 1;
        if (!options.lossless) {
            options.target = CVOL_TARGET_MAX_ERROR;
            options.target_value = 0.01;
        }
        if (cvol_volume_compute_histogram(context, &wanted, &volume) ||
            cvol_compress(context, &array, &report, samples, &volume.grid, &options) ||
            cvol_array_write_memory(context, array, &file, &size) ||
            cvol_array_read_memory(context, &read, file, size, "outliers") ||
            cvol_array_compute_histogram(context, &found, read))
            fail_msg("%d: %s", k, cvol_context_message(context));
        if (wanted.min != found.min || wanted.max != found.max || wanted.distinct != found.distinct)
            fail_msg("%d: %g to %g, %d values, not %g to %g, %d values", k, found.min, found.max,
                     found.distinct, wanted.min, wanted.max, wanted.distinct);
        assert_memory_equal(wanted.bins, found.bins, sizeof wanted.bins);
        free(file);
        cvol_array_free(array);
        cvol_array_free(read);
    }
    free(volume.data);
}

/* The L2 bound holds for the samples of every level: level 0 restores outliers, others do not. */
static void check_bounds(const char *path, const void *samples, const cvol_grid *grid,
                         const char *name)
{
    const size_t zero[3] = {0, 0, 0};
    float *real = malloc(COUNT * sizeof *real);
    for (int level = 0; level < 4; level++) {
        const cvol_file_part part = {.size = sizeof(cvol_file_part), .level = level};
        cvol_array *array;
        cvol_array_info info;
        double error = 0;
        assert_int_equal(cvol_array_read_part(context, &array, NULL, path, &part), CVOL_OK);
        assert_int_equal(cvol_array_evaluate_real(context, real, array, zero, grid->dims), CVOL_OK);
        cvol_array_get_info(&info, array);
        check_statistics(array, samples, grid, name);
        for (size_t i = 0; i < COUNT; i++)
            error = hypot(error, (double)real[i] - get(samples, grid->type, i));
        if (!(error <= info.l2_error))
            fail_msg("%s, level %d: error %g, bound %g", name, level, error, info.l2_error);
        cvol_array_free(array);
    }
    free(real);
}

static void test_bounds_cover_what_a_residual_restores(void **state)
{
    (void)state;
    static const magnitude kinds[] = {{CVOL_FLOAT32, 1, 0, 1e9, "an outlier"},
                                      {CVOL_FLOAT64, 1, 0, -1e35, "an outlier beyond terms"},
                                      {CVOL_FLOAT32, 1, 0, 0, "a maximum error"},
                                      {CVOL_FLOAT64, 1e7, 3, 0, "floats round doubles"},
                                      {CVOL_FLOAT64, 1e-40, 0, 0, "small doubles"},
                                      {CVOL_FLOAT64, 1e-160, 0, 0, "squares are denormal"},
                                      {CVOL_FLOAT64, 1e-200, 0, 0, "squares are 0"}};
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvol");
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
        for (int exact = 0; exact < 2; exact++) {
            cvol_grid grid;
            cvol_array *array;
            void *samples = make(&grid, &kinds[k]);
            cvol_compress_options options = cvol_compress_options_defaults();
            options.target = CVOL_TARGET_MAX_ERROR;
            options.target_value = exact ? 0 : 0.3 * kinds[k].unit;
            assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options),
                             CVOL_OK);
            assert_int_equal(cvol_array_write(context, array, path, NULL), CVOL_OK);
            check_bounds(path, samples, &grid, kinds[k].name);
            cvol_array_free(array);
            free(samples);
        }
    free(path);
    support_folder_remove(folder);
}

/* ---- NaN ------------------------------------------------------------------------------------- */

/* NaN samples have no value for any target: they are restored to the bit. */
static void test_nan_is_a_mask(void **state)
{
    (void)state;
    for (int t = 0; t < 4; t++) {
        const magnitude of = {t % 2 ? CVOL_FLOAT64 : CVOL_FLOAT32, 100, 0, 0, "NaN"};
        cvol_grid grid;
        cvol_compress_report report;
        uint64_t bytes;
        void *samples = make(&grid, &of);
        for (size_t i = 0; i < COUNT; i++)
            if (i % NX > 20)
                set(samples, of.type, i, NAN);
        cvol_compress_options options = cvol_compress_options_defaults();
        options.target = t < 2 ? CVOL_TARGET_PSNR : CVOL_TARGET_MAX_ERROR;
        options.target_value = t < 2 ? 50 : 0.3;
        void *back = round_trip(&bytes, &report, samples, &grid, &options, of.name);
        for (size_t i = 0; i < COUNT; i++) {
            const double value = get(back, of.type, i), truth = get(samples, of.type, i);
            if (isnan(value) != isnan(truth) || fabs(value - truth) > 10)
                fail_msg("sample %zu is %g instead of %g", i, value, truth);
        }
        assert_true(report.target_met);
        free(back);
        free(samples);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lossless_is_to_the_bit),
        cmocka_unit_test(test_targets_at_all_magnitudes),
        cmocka_unit_test(test_outliers_cost_little),
        cmocka_unit_test(test_histogram_has_outliers),
        cmocka_unit_test(test_bounds_cover_what_a_residual_restores),
        cmocka_unit_test(test_nan_is_a_mask),
    };
    return cmocka_run_group_tests(tests, context_setup_two, context_teardown);
}
