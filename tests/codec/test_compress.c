/* cvol_compress: targets are kept and measured truly, for all types and odd shapes. */
#include "test.h"

#include "array/core/array.h"
#include "base/context.h"
#include "base/memory.h"
#include "codec/container/array_file.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_samples.h"

/* ---- synthetic volumes ------------------------------------------------------------------ */

/* A few balls and waves with noise, within -1 .. 1. */
static void *make_volume(const cvol_grid *grid, uint64_t seed)
{
    void *samples = calloc(cvol_grid_samples(grid), cvol_type_size(grid->type));
    random_state r = {seed};
    size_t i = 0;
    assert_non_null(samples);
    for (size_t z = 0; z < grid->dims[2]; z++)
        for (size_t y = 0; y < grid->dims[1]; y++)
            for (size_t x = 0; x < grid->dims[0]; x++, i++) {
                double wave = sin(0.2 * (double)x) * cos(0.13 * (double)y + 0.07 * (double)z);
                double ball = hypot((double)x - 12, (double)y - 14) < 9 ? 0.4 : 0;
                support_store(samples, grid->type, i, 0.4 * wave + ball + 0.05 * random_signed(&r));
            }
    return samples;
}

/* The error bound is for evaluated values before rounding and clamping. */
static void check_error_bound(const cvol_array *array, const cvol_array_info *info,
                              const void *samples)
{
    const size_t *dims = array->grid.dims, begin[3] = {0, 0, 0};
    const size_t count = dims[0] * dims[1] * dims[2];
    float *real = cvol_allocate(count, sizeof *real);
    double squares = 0, norm = 0, largest = 0;
    assert_non_null(real);
    assert_int_equal(cvol_array_evaluate_real(context, real, array, begin, dims), CVOL_OK);
    for (size_t i = 0; i < count; i++) {
        const double value = (double)real[i],
                     error = support_load(samples, array->grid.type, i) - value;
        squares += error * error;
        norm += value * value;
        largest = fmax(largest, fabs(value));
    }
    free(real);
    assert_true(info->measured);
    assert_true(info->l2_error >= sqrt(squares));
    if (!array->residual) /* real values have a residual, the bound is that of the terms */
        assert_true(info->l2_error <= sqrt(squares) + 2e-6 * sqrt(norm));
    assert_true(info->max_abs >= largest);
}

/* Compares the report with the decoded samples. */
static void check_report(const cvol_array *array, const cvol_compress_report *report,
                         const void *samples)
{
    const cvol_grid *grid = cvol_array_grid(array);
    const size_t count = cvol_grid_samples(grid), zero[3] = {0, 0, 0};
    void *decoded = malloc(cvol_grid_bytes(grid));
    double most = 0, squares = 0;
    assert_non_null(decoded);
    assert_int_equal(cvol_array_evaluate_box(context, decoded, array, zero, grid->dims), CVOL_OK);
    for (size_t i = 0; i < count; i++) {
        double error = support_load(samples, grid->type, i) - support_load(decoded, grid->type, i);
        most = fmax(most, fabs(error));
        squares += error * error;
    }
    cvol_array_info info;
    cvol_array_get_info(&info, array);
    assert_true(report->max_error == most && info.max_error == most);
    check_error_bound(array, &info, samples);
    assert_int_equal(report->lossless, most == 0);
    if (most > 0) {
        double psnr = 10 * log10(pow(info.value_max - info.value_min, 2) * (double)count / squares);
        assert_true(fabs(psnr - report->psnr_db) < 1e-6);
    } else {
        assert_true(isinf(report->psnr_db));
    }
    free(decoded);
}

static int compress(cvol_array **array, cvol_compress_report *report, const void *samples,
                    const cvol_grid *grid, int block, cvol_target target, double value)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    options.block = block;
    options.target = target;
    options.target_value = value;
    return cvol_compress(context, array, report, samples, grid, &options);
}

/* Compresses, checks the report and the file's size; the caller checks the target. */
static cvol_compress_report run(const void *samples, const cvol_grid *grid, int block,
                                cvol_target target, double value)
{
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvol");
    cvol_array *array, *back;
    cvol_compress_report report;
    uint64_t written;
    int code = compress(&array, &report, samples, grid, block, target, value);
    if (code)
        print_message("%s\n", cvol_context_message(context));
    assert_int_equal(code, CVOL_OK);
    check_report(array, &report, samples);
    assert_int_equal(cvol_array_write(context, array, path, &written), CVOL_OK);
    assert_int_equal(written, report.file_bytes);
    assert_true(fabs(report.ratio * (double)written / (double)cvol_grid_bytes(grid) - 1) < 1e-12);
    assert_int_equal(cvol_array_read(context, &back, path, NULL), CVOL_OK);
    check_report(back, &report, samples);
    cvol_array_free(array);
    cvol_array_free(back);
    free(path);
    support_folder_remove(folder);
    return report;
}

/* ---- targets ---------------------------------------------------------------------------- */

/* Each ratio with each block, and all types. */
static void ratios_are_within_two_percent(void **state)
{
    (void)state;
    static const double ratios[] = {3, 10, 30};
    for (int k = 0; k < 9; k += SUPPORT_STRIDE) {
        const cvol_type type = (cvol_type)(CVOL_UINT8 + k % 8);
        const double ratio = ratios[(k + k / 3) % 3];
        const cvol_grid grid = cvol_grid_make(70, 41, 36, type);
        void *samples = make_volume(&grid, (uint64_t)k);
        cvol_compress_report report = run(samples, &grid, 8 << k / 3, CVOL_TARGET_RATIO, ratio);
        print_message("%s ratio %g: %.4f, %.2f dB, %d trials\n", cvol_type_name(type), ratio,
                      report.ratio, report.psnr_db, report.trials);
        assert_true(report.ratio >= ratio && report.ratio <= 1.02 * ratio);
        assert_true(report.target_met);
        free(samples);
    }
}

static void bits_are_not_exceeded(void **state)
{
    (void)state;
    static const double bits[] = {0.3, 1, 2.5};
    static const cvol_type types[] = {CVOL_UINT8, CVOL_INT16, CVOL_FLOAT64};
    for (int t = 0; t < 3; t++) {
        cvol_grid grid = cvol_grid_make(50, 45, 40, types[t]);
        void *samples = make_volume(&grid, (uint64_t)t + 40);
        for (int i = t % SUPPORT_STRIDE; i < 3; i += SUPPORT_STRIDE) {
            cvol_compress_report report = run(samples, &grid, 16, CVOL_TARGET_BITS, bits[i]);
            const double got = 8 * (double)report.file_bytes / (double)cvol_grid_samples(&grid);
            assert_true(got <= bits[i] && got >= bits[i] / 1.0201);
            assert_true(report.target_met);
        }
        free(samples);
    }
}

/* A size counts attributes, in small files and in large ones. */
static void a_size_counts_attributes(void **state)
{
    static const size_t lengths[] = {20, 900, 3000, 60000,
                                     4290}; /* the last repeat, so they are compressed */
    const cvol_grid grid = cvol_grid_make(40, 41, 42, CVOL_UINT8);
    const double samples_count = (double)cvol_grid_samples(&grid);
    void *samples = make_volume(&grid, 11);
    random_state r = {12};
    (void)state;
    for (size_t l = 0; l < 5; l++)
        for (int by_ratio = 0; by_ratio < 2; by_ratio++) {
            cvol_compress_options options = cvol_compress_options_defaults();
            cvol_compress_report report;
            cvol_array *array;
            uint64_t bytes;
            char *text = malloc(lengths[l] + 1);
            assert_non_null(text);
            for (size_t i = 0; i < lengths[l]; i++)
                text[i] = (char)(l == 4 ? 'a' : 'a' + (int)random_below(&r, 26));
            text[0] = text[lengths[l] - 1] = '"';
            text[lengths[l]] = '\0';
            options.attributes = text;
            options.target = by_ratio ? CVOL_TARGET_RATIO : CVOL_TARGET_BITS;
            options.target_value = by_ratio ? 16 : 0.5;
            assert_int_equal(cvol_compress(context, &array, &report, samples, &grid, &options),
                             CVOL_OK);
            assert_int_equal(cvol_array_file_bytes(context, array, &bytes), CVOL_OK);
            assert_string_equal(cvol_array_attributes(array), text);
            assert_int_equal(bytes, report.file_bytes);
            assert_true(fabs(report.ratio * (double)bytes / samples_count - 1) < 1e-12);
            assert_int_equal(report.target_met, lengths[l] < 5000);
            if (report.target_met)
                assert_true(report.ratio >= 16 && report.ratio <= 1.02 * 16);
            cvol_array_free(array);
            free(text);
        }
    cvol_compress_options wrong = cvol_compress_options_defaults();
    cvol_array *none;
    wrong.attributes = "{";
    assert_int_equal(cvol_compress(context, &none, NULL, samples, &grid, &wrong),
                     CVOL_ERROR_ARGUMENT);
    assert_null(none);
    free(samples);
}

static void psnr_is_reached(void **state)
{
    (void)state;
    for (int t = CVOL_UINT8; t <= CVOL_FLOAT64; t++) {
        const int wanted = 30 + 10 * (t % 3);
        cvol_grid grid = cvol_grid_make(40, 33, 30, (cvol_type)t);
        void *samples = make_volume(&grid, 7);
        cvol_compress_report report = run(samples, &grid, 16, CVOL_TARGET_PSNR, wanted);
        assert_true(report.psnr_db >= wanted && report.psnr_db < wanted + 0.15);
        assert_true(report.target_met);
        free(samples);
    }
}

static void max_error_is_kept(void **state)
{
    (void)state;
    static const double bounds[] = {
        [CVOL_UINT8] = 3,     [CVOL_INT8] = 2.5,  [CVOL_UINT16] = 30,    [CVOL_INT16] = 1,
        [CVOL_UINT32] = 1000, [CVOL_INT32] = 500, [CVOL_FLOAT32] = 1e-5, [CVOL_FLOAT64] = 0.01};
    for (int t = CVOL_UINT8; t <= CVOL_FLOAT64; t += SUPPORT_STRIDE) {
        cvol_grid grid = cvol_grid_make(45, 33, 31, (cvol_type)t);
        void *samples = make_volume(&grid, 8);
        cvol_compress_report report = run(samples, &grid, 8, CVOL_TARGET_MAX_ERROR, bounds[t]);
        assert_true(report.max_error <= bounds[t] && report.max_error > 0.6 * bounds[t] - 1);
        assert_true(report.target_met);
        free(samples);
    }
}

static void integers_can_be_exact(void **state)
{
    (void)state;
    for (int t = CVOL_UINT8; t <= CVOL_INT32; t += SUPPORT_STRIDE) {
        cvol_grid grid = cvol_grid_make(48, 32, 32, (cvol_type)t);
        void *samples = make_volume(&grid, 9);
        cvol_compress_report exact = run(samples, &grid, 16, CVOL_TARGET_MAX_ERROR, 0);
        print_message("%s exact: ratio %.3f, %d trials\n", cvol_type_name(grid.type), exact.ratio,
                      exact.trials);
        assert_true(exact.lossless && exact.target_met && exact.ratio > 1);
        /* A ratio below that of lossless: the exact samples, in fewer bytes than requested. */
        cvol_compress_report low = run(samples, &grid, 16, CVOL_TARGET_RATIO,
                                       1 + 0.5 * (exact.ratio - 1));
        assert_true(low.lossless && low.ratio >= 0.97 * exact.ratio && low.target_met);
        free(samples);
    }
}

/* Single outliers in an even field: each coefficient is far below a step. */
static void isolated_samples_can_be_exact(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(64, 64, 64, CVOL_UINT8);
    uint8_t *samples = calloc(cvol_grid_samples(&grid), 1);
    random_state r = {4};
    assert_non_null(samples);
    for (int i = 0; i < 100; i++)
        samples[random_below(&r, 64 * 64 * 64)] = 1;
    for (int k = 0; k < 3; k += SUPPORT_STRIDE)
        assert_true(run(samples, &grid, 8 << k, CVOL_TARGET_MAX_ERROR, 0).lossless);
    free(samples);
}

static void odd_shapes_work(void **state)
{
    (void)state;
    static const size_t shapes[][3] = {{1, 1, 1},    {1, 1, 100}, {100, 1, 1}, {17, 33, 5},
                                       {16, 16, 16}, {129, 3, 2}, {2, 130, 1}, {31, 8, 257}};
    for (size_t s = 0; s < sizeof shapes / sizeof shapes[0]; s += SUPPORT_STRIDE)
        for (int t = CVOL_UINT8 + (int)s % 4; t <= CVOL_FLOAT64; t += 4) {
            cvol_grid grid = cvol_grid_make(shapes[s][0], shapes[s][1], shapes[s][2], (cvol_type)t);
            void *samples = make_volume(&grid, s);
            cvol_compress_report report = run(samples, &grid, 8 << t % 3, CVOL_TARGET_RATIO, 4);
            assert_true(!report.target_met || report.ratio >= 4);
            (void)run(samples, &grid, 8 << s % 3, CVOL_TARGET_PSNR, 35);
            free(samples);
        }
}

static void constant_volumes_are_exact(void **state)
{
    (void)state;
    for (int t = CVOL_UINT8; t <= CVOL_FLOAT64; t += SUPPORT_STRIDE) {
        cvol_grid grid = cvol_grid_make(50, 40, 30, (cvol_type)t);
        void *samples = calloc(cvol_grid_samples(&grid), cvol_type_size(grid.type));
        assert_non_null(samples);
        for (size_t i = 0; i < cvol_grid_samples(&grid); i++)
            support_store(samples, grid.type, i, 0.123);
        assert_true(run(samples, &grid, 16, CVOL_TARGET_RATIO, 30).lossless);
        assert_true(run(samples, &grid, 16, CVOL_TARGET_PSNR, 60).target_met);
        assert_true(run(samples, &grid, 16, CVOL_TARGET_MAX_ERROR, 0).target_met);
        free(samples);
    }
}

static void unreachable_targets_are_reported(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(40, 33, 50, CVOL_FLOAT32);
    void *samples = make_volume(&grid, 7);
    cvol_compress_report report = run(samples, &grid, 16, CVOL_TARGET_PSNR, 190);
    assert_true(report.lossless);
    report = run(samples, &grid, 16, CVOL_TARGET_RATIO, 1e6);
    assert_true(!report.target_met && report.ratio < 1e6 && report.ratio > 100);
    report = run(samples, &grid, 16, CVOL_TARGET_RATIO, 1.01);
    assert_true(report.target_met && report.ratio > 1.01 && report.lossless);
    free(samples);
}

static void options_are_checked(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(4, 4, 4, CVOL_UINT8);
    uint8_t samples[64] = {0};
    cvol_array *array;
    static const struct {
        cvol_target target;
        double value;
    } bad[] = {
        {CVOL_TARGET_RATIO, 1},
        {CVOL_TARGET_RATIO, (double)INFINITY},
        {CVOL_TARGET_RATIO, -3},
        {CVOL_TARGET_RATIO, (double)NAN},
        {CVOL_TARGET_BITS, 0},
        {CVOL_TARGET_BITS, -1},
        {CVOL_TARGET_BITS, 8}, /* those of the samples */
        {CVOL_TARGET_BITS, (double)NAN},
        {CVOL_TARGET_BITS, 1e-320},
        {CVOL_TARGET_PSNR, 0},
        {CVOL_TARGET_PSNR, 201},
        {CVOL_TARGET_PSNR, (double)NAN},
        {CVOL_TARGET_MAX_ERROR, -1},
        {CVOL_TARGET_MAX_ERROR, (double)NAN},
        {(cvol_target)9, 3},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_int_equal(compress(&array, NULL, samples, &grid, 16, bad[i].target, bad[i].value),
                         CVOL_ERROR_ARGUMENT);
    assert_int_equal(compress(&array, NULL, samples, &grid, 12, CVOL_TARGET_RATIO, 3),
                     CVOL_ERROR_ARGUMENT);
    cvol_compress_options options = cvol_compress_options_defaults();
    options.transform = CVOL_DFT;
    assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options),
                     CVOL_ERROR_UNSUPPORTED);
}

/* Options that are invalid, or that exclude each other. */
static void combinations_are_checked(void **state)
{
    static const struct {
        cvol_compress_options options; /* fields other than 0 replace the defaults */
        const char *words;
    } bad[] = {
        {{.effort = (cvol_effort)3}, "effort is 3"},
        {{.effort = (cvol_effort)-1}, "effort is -1"},
        {{.effort = CVOL_EFFORT_MAX, .block = 8}, "needs blocks of 16"},
        {{.effort = CVOL_EFFORT_MAX, .lossless = 1}, "cannot be combined"},
        {{.least_psnr = -1}, "the least PSNR is -1 dB"},
        {{.least_psnr = (double)INFINITY}, "the least PSNR is inf dB"},
        {{.max_error = -1}, "maximum error is -1"},
        {{.max_error = (double)NAN}, "maximum error is nan"},
        {{.max_error = 2}, "only be combined with a PSNR"},
        {{.background = CVOL_BACKGROUND_VALUE, .has_fill = 1}, "a background cannot"},
        {{.background = (cvol_background)3}, "background is 3, must be 0, 1 or 2"},
        {{.background = CVOL_BACKGROUND_VALUE, .lossless = 1}, "a background cannot"},
        {{.background = CVOL_BACKGROUND_VALUE, .background_value = (double)NAN},
         "the background is nan"},
        {{.has_fill = 1, .fill = 0.5}, "uint8 cannot hold the fill value 0.5"},
        {{.has_fill = 1, .fill = 256}, "uint8 cannot hold the fill value 256"},
    };
    (void)state;
    const cvol_grid grid = cvol_grid_make(4, 4, 4, CVOL_UINT8);
    const uint8_t samples[64] = {0};
    cvol_array *array;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        cvol_compress_options options = bad[i].options;
        const cvol_compress_options usual = cvol_compress_options_defaults();
        options.size = sizeof options;
        options.transform = usual.transform;
        options.block = options.block ? options.block : usual.block;
        options.target = usual.target;
        options.target_value = usual.target_value;
        assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options),
                         CVOL_ERROR_ARGUMENT);
        if (!strstr(cvol_context_message(context), bad[i].words))
            fail_msg("'%s' instead of '%s'", cvol_context_message(context), bad[i].words);
        assert_null(array);
    }
}

static void nonfinite_samples_are_reported(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(4, 5, 6, CVOL_FLOAT32);
    float samples[120] = {0};
    cvol_array *array;
    samples[1 + 4 * (2 + 5 * 3)] = (float)NAN;
    samples[119] = (float)-INFINITY;
    assert_int_equal(compress(&array, NULL, samples, &grid, 16, CVOL_TARGET_RATIO, 3),
                     CVOL_ERROR_DATA);
    assert_string_equal(cvol_context_message(context),
                        "2 samples are NaN or infinite, the first at (x, y, z) = (1, 2, 3) (index "
                        "69); --fill VALUE replaces them");
    cvol_grid wide = cvol_grid_make(2, 1, 1, CVOL_FLOAT64);
    /* Samples that terms cannot represent are coded losslessly. */
    const double far[2] = {-1e300, 1e300}, alike[2] = {1e39, 1e39};
    for (int i = 0; i < 2; i++) {
        cvol_compress_report report;
        assert_int_equal(
            compress(&array, &report, i ? alike : far, &wide, 16, CVOL_TARGET_RATIO, 3), CVOL_OK);
        assert_true(report.lossless);
        cvol_array_free(array);
    }
}

/* Not those that replace the background next to an infinite sample. */
static void nonfinite_samples_beside_a_background_are_reported(void **state)
{
    (void)state;
    enum { SIDE = 48 };
    const cvol_grid grid = cvol_grid_make(SIDE, SIDE, SIDE, CVOL_FLOAT32);
    float *samples = calloc((size_t)SIDE * SIDE * SIDE, sizeof *samples);
    cvol_array *array;
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        const double x = i % SIDE - 24, y = i / SIDE % SIDE - 24, z = i / SIDE / SIDE - 24.0;
        samples[i] = x * x + y * y + z * z < 400 ? (float)(100 + x + sin(y)) : 0;
    }
    samples[3 + SIDE * (3 + SIDE * 3)] = INFINITY;
    cvol_compress_options options = cvol_compress_options_defaults();
    options.background = CVOL_BACKGROUND_FIND;
    assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options),
                     CVOL_ERROR_DATA);
    assert_string_equal(cvol_context_message(context),
                        "1 sample is NaN or infinite, the first at (x, y, z) = (3, 3, 3) (index "
                        "7059); --fill VALUE replaces them");
    free(samples);
}

/* ---- determinism and progress ----------------------------------------------------------- */

static void bytes_do_not_depend_on_threads(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(133, SUPPORT_SIDE(70), SUPPORT_SIDE(66), CVOL_UINT8);
    void *samples = make_volume(&grid, 1);
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvol");
    unsigned char *first = NULL;
    size_t first_size = 0;
    for (int threads = 1; threads <= 3; threads++) {
        cvol_array *array;
        size_t size;
        cvol_context_set_threads(context, threads);
        assert_int_equal(compress(&array, NULL, samples, &grid, 16, CVOL_TARGET_RATIO, 20), 0);
        assert_int_equal(cvol_array_write(context, array, path, NULL), CVOL_OK);
        unsigned char *bytes = support_read(path, &size);
        if (threads == 1) {
            first = bytes;
            first_size = size;
        } else {
            assert_int_equal(size, first_size);
            assert_memory_equal(bytes, first, size);
            free(bytes);
        }
        cvol_array_free(array);
    }
    cvol_context_set_threads(context, 2);
    free(first);
    free(path);
    support_folder_remove(folder);
    free(samples);
}

static int cancel_after(void *user, const char *what, double fraction)
{
    int *left = user;
    (void)what;
    assert_true(fraction >= 0 && fraction <= 1);
    return (*left)-- <= 0;
}

static void compressing_can_be_cancelled(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(70, 33, 30, CVOL_UINT8);
    void *samples = make_volume(&grid, 2);
    cvol_array *array;
    int code = CVOL_ERROR_CANCELLED;
    for (int after = 0; after < 100 && code == CVOL_ERROR_CANCELLED;
         after += 2 * SUPPORT_STRIDE - 1) {
        int left = after;
        cvol_context_set_progress(context, cancel_after, &left);
        code = compress(&array, NULL, samples, &grid, 16, CVOL_TARGET_RATIO, 20);
        if (code)
            assert_null(array);
    }
    assert_int_equal(code, CVOL_OK);
    cvol_context_set_progress(context, NULL, NULL);
    cvol_array_free(array);
    free(samples);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ratios_are_within_two_percent),
        cmocka_unit_test(bits_are_not_exceeded),
        cmocka_unit_test(a_size_counts_attributes),
        cmocka_unit_test(psnr_is_reached),
        cmocka_unit_test(max_error_is_kept),
        cmocka_unit_test(integers_can_be_exact),
        cmocka_unit_test(isolated_samples_can_be_exact),
        cmocka_unit_test(odd_shapes_work),
        cmocka_unit_test(constant_volumes_are_exact),
        cmocka_unit_test(unreachable_targets_are_reported),
        cmocka_unit_test(options_are_checked),
        cmocka_unit_test(combinations_are_checked),
        cmocka_unit_test(nonfinite_samples_are_reported),
        cmocka_unit_test(nonfinite_samples_beside_a_background_are_reported),
        cmocka_unit_test(bytes_do_not_depend_on_threads),
        cmocka_unit_test(compressing_can_be_cancelled),
    };
    return cmocka_run_group_tests(tests, context_setup_two, context_teardown);
}
