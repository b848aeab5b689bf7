/* cvol_array_transcode: targets, and bounds that hold against the original samples. */
#include "test.h"

#include "array/core/array.h"
#include "base/context.h"
#include "codec/container/array_file.h"
#include "codec/quantize/coding.h"
#include "cvol/algebra.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_context.h"

static float *make_volume(const cvol_grid *grid, uint64_t seed)
{
    float *samples = malloc(cvol_grid_bytes(grid));
    random_state r = {seed};
    assert_non_null(samples);
    for (size_t z = 0, i = 0; z < grid->dims[2]; z++)
        for (size_t y = 0; y < grid->dims[1]; y++)
            for (size_t x = 0; x < grid->dims[0]; x++, i++)
                samples[i] = (float)(1000 +
                                     100 * sin(0.2 * (double)x) *
                                         cos(0.13 * (double)y + 0.07 * (double)z) +
                                     (hypot((double)x - 30, (double)y - 24) < 19 ? 80 : 0) +
                                     5 * random_signed(&r));
    return samples;
}

static cvol_compress_options options_of(cvol_target target, double value)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target = target;
    options.target_value = value;
    return options;
}

static cvol_array *compress(const void *samples, const cvol_grid *grid, int block, double ratio)
{
    cvol_compress_options options = options_of(CVOL_TARGET_RATIO, ratio);
    cvol_array *array;
    options.block = block;
    check_ok(cvol_compress(context, &array, NULL, samples, grid, &options));
    return array;
}

/* The distance of the array from the samples: the L2 norm, unrounded. */
static double distance(const cvol_array *array, const float *samples)
{
    const size_t zero[3] = {0, 0, 0}, count = cvol_grid_samples(&array->grid);
    float *real = malloc(count * sizeof *real);
    double squares = 0;
    assert_non_null(real);
    check_ok(cvol_array_evaluate_real(context, real, array, zero, array->grid.dims));
    for (size_t i = 0; i < count; i++)
        squares += pow((double)samples[i] - (double)real[i], 2);
    free(real);
    return sqrt(squares);
}

/* The bound holds and is tight, and the file equals the array. */
static void check_result(const cvol_array *array, const cvol_array *from,
                         const cvol_compress_report *report, const float *samples)
{
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvol");
    const double found = distance(array, samples);
    cvol_array *back;
    cvol_array_info info;
    uint64_t bytes;
    cvol_array_get_info(&info, array);
    assert_int_equal(info.measured, 0);
    assert_true(found <= info.l2_error && info.l2_error < 1.6 * found);
    assert_true(info.l2_error > from->error_bound.l2_error && info.step >= from->step);
    assert_int_equal(array->lapped, from->lapped);
    assert_int_equal(cvol_coding_of(array)->trellis, cvol_coding_of(from)->trellis);
    for (size_t i = 0; i < array->block_count; i++)
        assert_int_equal(array->block_table[i].split, from->block_table[i].split);
    check_ok(cvol_array_write(context, array, path, &bytes));
    assert_int_equal(bytes, report->file_bytes);
    check_ok(cvol_file_verify(context, NULL, path));
    check_ok(cvol_array_read(context, &back, path, NULL));
    assert_true(distance(back, samples) == found);
    assert_true(back->error_bound.l2_error == array->error_bound.l2_error && !back->measured);
    assert_string_equal(cvol_array_attributes(back), "[1]");
    cvol_array_free(back);
    free(path);
    support_folder_remove(folder);
}

static void ratios_and_bounds_hold(void **state)
{
    (void)state;
    static const int blocks[] = {16, 8, 32, 16};
    static const size_t shapes[][3] = {{90, 70, 80}, {50, 61, 33}, {65, 40, 70}, {20, 130, 9}};
    for (int s = 0; s < 4; s += SUPPORT_STRIDE) {
        const cvol_grid grid = cvol_grid_make(shapes[s][0], shapes[s][1], shapes[s][2],
                                              CVOL_FLOAT32);
        float *samples = make_volume(&grid, (uint64_t)s);
        cvol_array *from = compress(samples, &grid, blocks[s], 12);
        check_ok(cvol_array_set_attributes(context, from, "[1]"));
        for (double ratio = 15; ratio < 80; ratio *= 1 << SUPPORT_STRIDE) {
            const cvol_compress_options options = options_of(CVOL_TARGET_RATIO, ratio);
            cvol_compress_report report;
            cvol_array *array;
            check_ok(cvol_array_transcode(context, &array, &report, from, &options));
            print_message("%d: 1/%g: 1/%.3f, %.2f dB in %d tries\n", s, ratio, report.ratio,
                          report.psnr_db, report.trials);
            assert_true(report.ratio >= ratio && report.ratio <= 1.03 * ratio);
            assert_true(report.target_met);
            check_result(array, from, &report, samples);
            cvol_array_free(array);
        }
        cvol_array_free(from);
        free(samples);
    }
}

static void psnr_is_reached(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(70, 66, 90, CVOL_FLOAT32);
    float *samples = make_volume(&grid, 5);
    cvol_array *from = compress(samples, &grid, 16, 10), *array;
    cvol_compress_report report;
    check_ok(cvol_array_set_attributes(context, from, "[1]"));
    const double span = from->error_bound.value_max - from->error_bound.value_min;
    for (double wanted = 28; wanted < 36; wanted += 3 * SUPPORT_STRIDE) {
        const cvol_compress_options options = options_of(CVOL_TARGET_PSNR, wanted);
        check_ok(cvol_array_transcode(context, &array, &report, from, &options));
        const double found = 20 * log10(span * sqrt((double)cvol_grid_samples(&grid)) /
                                        distance(array, samples));
        assert_true(report.psnr_db >= wanted && report.psnr_db < wanted + 0.3);
        assert_true(found >= wanted);
        check_result(array, from, &report, samples);
        cvol_array_free(array);
    }
    cvol_array_free(from);
    free(samples);
}

static void any_threads_give_the_same_bytes(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(90, 70, 80, CVOL_FLOAT32);
    float *samples = make_volume(&grid, 6);
    cvol_array *from = compress(samples, &grid, 16, 12);
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvol");
    const cvol_compress_options options = options_of(CVOL_TARGET_BITS, 1);
    unsigned char *bytes[2];
    size_t sizes[2];
    for (int i = 0; i < 2; i++) {
        cvol_array *array;
        cvol_context_set_threads(context, 1 + 2 * i);
        check_ok(cvol_array_transcode(context, &array, NULL, from, &options));
        check_ok(cvol_array_write(context, array, path, NULL));
        bytes[i] = support_read(path, &sizes[i]);
        cvol_array_free(array);
    }
    cvol_context_set_threads(context, 2);
    assert_int_equal(sizes[0], sizes[1]);
    assert_memory_equal(bytes[0], bytes[1], sizes[0]);
    free(bytes[0]);
    free(bytes[1]);
    cvol_array_free(from);
    free(samples);
    free(path);
    support_folder_remove(folder);
}

/* Readers round cells at the volume's end once more, which counts for large steps: bounds of a few
 * decibels hold, for all coders. */
static void coarse_bounds_hold_at_the_ends(void **state)
{
    (void)state;
    static const size_t shapes[][3] = {{49, 32, 9}, {17, 47, 5}, {18, 17, 20}};
    for (int s = 0; s < 3; s++)
        for (int kind = 0; kind < (s >= 1 ? 4 : 3); kind++) { /* --effort max takes long */
            const size_t *n = shapes[s];
            const cvol_grid grid = cvol_grid_make(n[0], n[1], n[2], CVOL_FLOAT32);
            float *samples = malloc(cvol_grid_bytes(&grid));
            cvol_compress_options options = options_of(CVOL_TARGET_PSNR, 55);
            cvol_array *from, *array;
            assert_non_null(samples);
            for (size_t i = 0; i < cvol_grid_samples(&grid); i++)
                samples[i] = (float)round(127 + 120 * sin((double)(i % n[0]) / 3) *
                                                    cos((double)(i / n[0] % n[1]) / 5) *
                                                    cos((double)(i / n[0] / n[1]) / 4));
            options.lapped = kind != 1;
            options.effort = kind == 2   ? CVOL_EFFORT_FAST
                             : kind == 3 ? CVOL_EFFORT_MAX
                                         : CVOL_EFFORT_DEFAULT;
            check_ok(cvol_compress(context, &from, NULL, samples, &grid, &options));
            for (double wanted = 10; wanted < (kind == 3 ? 11 : 20); wanted += 9) {
                options = options_of(CVOL_TARGET_PSNR, wanted);
                check_ok(cvol_array_transcode(context, &array, NULL, from, &options));
                const double found = distance(array, samples);
                if (test_verbose())
                    print_message("%d %d: %g dB: off by %g, at most %g\n", s, kind, wanted, found,
                                  array->error_bound.l2_error);
                assert_true(found <= array->error_bound.l2_error);
                assert_true(array->psnr_db >= wanted);
                cvol_array_free(array);
            }
            cvol_array_free(from);
            free(samples);
        }
}

/* Masked samples are restored to the bit. */
static void masks_are_kept(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(50, 40, 45, CVOL_FLOAT32);
    const size_t count = cvol_grid_samples(&grid), zero[3] = {0, 0, 0};
    float *samples = make_volume(&grid, 7), *out = malloc(count * sizeof *out);
    cvol_compress_options options = options_of(CVOL_TARGET_RATIO, 10);
    cvol_array *from, *array;
    assert_non_null(out);
    for (size_t i = 0; i < count; i++)
        if (i % 50 < 20)
            samples[i] = 1e35f;
    options.has_fill = 1;
    options.fill = 1e35;
    check_ok(cvol_compress(context, &from, NULL, samples, &grid, &options));
    options = options_of(CVOL_TARGET_RATIO, 25);
    check_ok(cvol_array_transcode(context, &array, NULL, from, &options));
    check_ok(cvol_array_evaluate_box(context, out, array, zero, grid.dims));
    for (size_t i = 0; i < count; i++)
        assert_true((out[i] == 1e35f) == (samples[i] == 1e35f));
    cvol_array_free(from);
    cvol_array_free(array);
    free(samples);
    free(out);
}

/* Missing samples have no error, so the PSNR is of the others. Their number is in the bounds that
 * transcoding and operations derive. */
static void psnr_does_not_count_missing_samples(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(66, 50, 40, CVOL_FLOAT32);
    const size_t count = cvol_grid_samples(&grid), zero[3] = {0, 0, 0};
    float *samples = make_volume(&grid, 5), *out = malloc(count * sizeof *out);
    float least = INFINITY, most = -INFINITY;
    size_t valued = 0;
    cvol_compress_options options = options_of(CVOL_TARGET_PSNR, 60);
    cvol_array *from, *results[3];
    assert_non_null(out);
    for (size_t i = 0; i < count; i++) {
        if (hypot((double)(i % 66) - 30, (double)(i / 66 % 50) - 24) > 15) {
            samples[i] = NAN;
            continue;
        }
        valued++;
        least = fminf(least, samples[i]);
        most = fmaxf(most, samples[i]);
    }
    options.has_fill = 1;
    options.fill = NAN;
    check_ok(cvol_compress(context, &from, NULL, samples, &grid, &options));
    options = options_of(CVOL_TARGET_PSNR, 45);
    check_ok(cvol_array_transcode(context, &results[0], NULL, from, &options));
    options = options_of(CVOL_TARGET_RATIO, 40);
    check_ok(cvol_array_transcode(context, &results[1], NULL, from, &options));
    check_ok(cvol_array_scale(context, &results[2], 1, from, 0));
    for (int k = 0; k < 3; k++) {
        cvol_array_info info;
        double squares = 0;
        cvol_array_get_info(&info, results[k]);
        check_ok(cvol_array_evaluate_box(context, out, results[k], zero, grid.dims));
        for (size_t i = 0; i < count; i++)
            squares += isnan(samples[i]) ? 0 : pow((double)samples[i] - (double)out[i], 2);
        const double psnr = 20 * log10((double)(most - least) * sqrt((double)valued / squares));
        print_message("%d: at least %.2f dB, truly %.2f\n", k, info.psnr_db, psnr);
        assert_int_equal(info.missing_samples, count - valued);
        assert_true(info.psnr_db <= psnr && psnr < info.psnr_db + 3);
        assert_true(k > 0 || info.psnr_db >= 45);
        cvol_array_free(results[k]);
    }
    cvol_array_free(from);
    free(samples);
    free(out);
}

/* A lossless file may have several fills: one number, and NaN and infinities. */
static void all_fills_of_a_lossless_array_are_kept(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(50, 40, 45, CVOL_FLOAT32);
    const size_t count = cvol_grid_samples(&grid), zero[3] = {0, 0, 0};
    for (int has_mark = 0; has_mark <= 1; has_mark++) {
        float *samples = make_volume(&grid, 7), *out = malloc(count * sizeof *out);
        cvol_compress_options options = cvol_compress_options_defaults();
        cvol_array *from, *array;
        assert_non_null(out);
        for (size_t i = 0; i < count; i++)
            if (i % 50 < 20)
                samples[i] = i % 5 > 1 && has_mark ? 1e35f : (float)(i % 2 ? NAN : -INFINITY);
        options.lossless = 1;
        options.has_fill = has_mark;
        options.fill = 1e35;
        check_ok(cvol_compress(context, &from, NULL, samples, &grid, &options));
        options = options_of(CVOL_TARGET_PSNR, 40);
        check_ok(cvol_array_transcode(context, &array, NULL, from, &options));
        assert_true(array->psnr_db >= 40 && array->max_error < 1e4);
        check_ok(cvol_array_evaluate_box(context, out, array, zero, grid.dims));
        for (size_t i = 0; i < count; i++)
            if (i % 50 < 20)
                assert_memory_equal(&out[i], &samples[i], sizeof *out);
            else
                assert_true(fabs((double)out[i] - (double)samples[i]) <= array->max_error);
        cvol_array_free(from);
        cvol_array_free(array);
        free(samples);
        free(out);
    }
}

/* An array with a residual is decoded and compressed: masked samples stay, the others are within
 * the error that the result states. */
static void residuals_are_decoded(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(50, 40, 25, CVOL_INT16);
    const size_t count = cvol_grid_samples(&grid), zero[3] = {0, 0, 0};
    int16_t *samples = malloc(2 * count), *out = malloc(2 * count);
    assert_true(samples && out);
    for (int lossless = 0; lossless <= 1; lossless++)
        for (int masked = 0; masked <= 1; masked++) {
            cvol_compress_options options = options_of(CVOL_TARGET_MAX_ERROR, 3);
            cvol_array *from, *array;
            random_state r = {3};
            for (size_t i = 0; i < count; i++)
                samples[i] = i % 50 < 20 && masked
                                 ? -1000
                                 : (int16_t)(300 * sin((double)i / 70) + 9 * random_signed(&r));
            options.lossless = lossless;
            options.has_fill = masked;
            options.fill = -1000;
            check_ok(cvol_compress(context, &from, NULL, samples, &grid, &options));
            check_ok(cvol_array_set_attributes(context, from, "[1]"));
            options = options_of(CVOL_TARGET_PSNR, 30);
            check_ok(cvol_array_transcode(context, &array, NULL, from, &options));
            assert_string_equal(cvol_array_attributes(array), "[1]");
            check_ok(cvol_array_evaluate_box(context, out, array, zero, grid.dims));
            double squares = 0;
            for (size_t i = 0; i < count; i++) {
                const double off = samples[i] - out[i];
                assert_true(!masked || (samples[i] == -1000) == (out[i] == -1000));
                assert_true(fabs(off) <= array->max_error);
                squares += off * off;
            }
            if (!(squares > 0) || array->max_error > 250)
                fail_msg("%d %d: squares %g, at most %g", lossless, masked, squares,
                         array->max_error);
            cvol_array_free(from);
            cvol_array_free(array);
        }
    free(samples);
    free(out);
}

/* The result has the blocks of its source, so that both are operands of one operation, also if
 * decoded samples are compressed. Equal samples have no PSNR, and are not refused for it. */
static void blocks_are_kept(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(40, 30, 20, CVOL_FLOAT32);
    for (int i = 0; i < 12; i++) {
        float *samples = make_volume(&grid, 8);
        for (size_t k = 0; k < cvol_grid_samples(&grid) && i >= 9; k++)
            samples[k] = 7.3F;
        cvol_compress_options options = options_of(CVOL_TARGET_PSNR, 60);
        cvol_array *from, *array, *sum;
        options.block = 8 << i % 3;
        options.lapped = i % 2;
        options.max_error = i < 3 ? 0.5 : 0;
        options.lossless = i >= 3 && i < 6;
        check_ok(cvol_compress(context, &from, NULL, samples, &grid, &options));
        options = options_of(CVOL_TARGET_RATIO, i < 9 ? 30 : 1e6);
        options.least_psnr = i < 9 ? 0 : 25;
        check_ok(cvol_array_transcode(context, &array, NULL, from, &options));
        assert_int_equal(array->block, from->block);
        assert_int_equal(array->lapped, from->lapped);
        check_ok(cvol_array_add(context, &sum, 1, from, -1, array, NULL));
        cvol_array_free(sum);
        cvol_array_free(from);
        cvol_array_free(array);
        free(samples);
    }
}

/* The range that the result states is that of the original samples, although decoded ones are
 * compressed: bounds of products depend on it. */
static void residuals_keep_the_range(void **state)
{
    (void)state;
    const size_t zero[3] = {0, 0, 0};
    random_state r = {6};
    for (int i = 0; i < 24; i++) {
        const cvol_grid grid = cvol_grid_make(10 + (size_t)i, 20, 7,
                                              i % 2 ? CVOL_FLOAT32 : CVOL_INT16);
        const size_t count = cvol_grid_samples(&grid);
        float *reals = malloc(count * sizeof *reals), *out = malloc(count * sizeof *out);
        int16_t *integers = malloc(count * sizeof *integers);
        assert_true(reals && out && integers);
        for (size_t k = 0; k < count; k++) { /* every third: a few samples far from the others */
            integers[k] = (int16_t)(i % 3 ? rint(4 * random_signed(&r)) : 9 * (k % 97 == 5));
            reals[k] = integers[k];
        }
        const void *samples = i % 2 ? (const void *)reals : (const void *)integers;
        cvol_array *from, *array, *product;
        cvol_compress_options options = options_of(CVOL_TARGET_MAX_ERROR, 1 + i % 6);
        check_ok(cvol_compress(context, &from, NULL, samples, &grid, &options));
        options = options_of(CVOL_TARGET_RATIO, 1.5 + i);
        check_ok(cvol_array_transcode(context, &array, NULL, from, &options));
        check_ok(cvol_array_multiply(context, &product, array, array, NULL, 0, NULL));
        check_ok(cvol_array_evaluate_real(context, out, product, zero, grid.dims));
        for (size_t k = 0; k < count; k++) {
            assert_true((double)reals[k] >= array->error_bound.value_min);
            assert_true((double)reals[k] <= array->error_bound.value_max);
            const double off = fabs((double)out[k] - (double)(reals[k] * reals[k]));
            if (off > cvol_error_bound_point(&product->error_bound))
                fail_msg("%d: a product is off by %g, more than %g", i, off,
                         cvol_error_bound_point(&product->error_bound));
        }
        cvol_array_free(from);
        cvol_array_free(array);
        cvol_array_free(product);
        free(reals);
        free(out);
        free(integers);
    }
}

/* The PSNR that the result states, and a target, hold against the original samples; a ratio holds
 * for the file, with its attributes. */
static void residuals_count(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(50, 40, 25, CVOL_INT16);
    const size_t count = cvol_grid_samples(&grid), zero[3] = {0, 0, 0};
    int16_t *samples = malloc(2 * count), *out = malloc(2 * count);
    char attributes[402] = "\"";
    random_state r = {5};
    assert_true(samples && out);
    double least = 0, most = 0;
    for (size_t i = 0; i < count; i++) {
        samples[i] = (int16_t)(300 * sin((double)i / 70) + 9 * random_signed(&r));
        least = fmin(least, samples[i]);
        most = fmax(most, samples[i]);
    }
    for (size_t i = 1; i < 400; i++)
        attributes[i] = (char)('a' + (int)(13 * (random_signed(&r) + 1)) % 26);
    attributes[400] = '"';
    for (int error = 2; error <= 8; error += 2)
        for (int k = 0; k < 2; k++) {
            cvol_compress_options options = options_of(CVOL_TARGET_MAX_ERROR, error);
            cvol_array *from, *array;
            cvol_compress_report report;
            uint64_t bytes;
            check_ok(cvol_compress(context, &from, NULL, samples, &grid, &options));
            check_ok(cvol_array_set_attributes(context, from, attributes));
            options = k ? options_of(CVOL_TARGET_RATIO, 20)
                        : options_of(CVOL_TARGET_PSNR, from->psnr_db - 4);
            check_ok(cvol_array_transcode(context, &array, &report, from, &options));
            check_ok(cvol_array_evaluate_box(context, out, array, zero, grid.dims));
            check_ok(cvol_array_file_bytes(context, array, &bytes));
            double squares = 0;
            for (size_t i = 0; i < count; i++)
                squares += (double)(samples[i] - out[i]) * (samples[i] - out[i]);
            const double psnr = 20 * log10((most - least) / sqrt(squares / (double)count));
            if (psnr < array->psnr_db || (!k && array->psnr_db < options.target_value))
                fail_msg("PSNR %g, stated %g, target %g", psnr, array->psnr_db,
                         options.target_value);
            assert_true(report.psnr_db <= array->psnr_db && report.file_bytes == bytes);
            assert_true(!k || (double)bytes * 20 <= 2 * (double)count);
            cvol_array_free(from);
            cvol_array_free(array);
        }
    free(samples);
    free(out);
}

/* Small files have the ratio, or the report says that they do not. */
static void small_files_keep_ratio(void **state)
{
    (void)state;
    random_state r = {11};
    for (int i = 5; i < 7; i++) {
        const cvol_grid grid = cvol_grid_make(10 + (size_t)i, 38, 46 - (size_t)i, CVOL_UINT16);
        const size_t count = cvol_grid_samples(&grid);
        uint16_t *samples = malloc(2 * count);
        assert_non_null(samples);
        for (size_t k = 0; k < count; k++) {
            const double x = (double)(k % grid.dims[0]), y = (double)(k / grid.dims[0] % 38),
                         z = (double)(k / grid.dims[0] / 38);
            samples[k] = (uint16_t)(32000 + 12000 * sin(x / (3 + i) + y / 9) +
                                    12000 * cos(z / 7 - y / (5 + i)) + 1500 * random_signed(&r));
        }
        cvol_compress_options options = options_of(CVOL_TARGET_PSNR, 50);
        cvol_array *from;
        options.lapped = 0;
        check_ok(cvol_compress(context, &from, NULL, samples, &grid, &options));
        for (int ratio = 40; ratio <= 60; ratio += 10) {
            cvol_compress_report report;
            cvol_array *array;
            uint64_t bytes;
            options = options_of(CVOL_TARGET_RATIO, ratio);
            check_ok(cvol_array_transcode(context, &array, &report, from, &options));
            check_ok(cvol_array_file_bytes(context, array, &bytes));
            if (report.target_met && (double)bytes * ratio > 2 * (double)count)
                fail_msg("%d: %llu bytes are more than 1/%d of %zu", i, (unsigned long long)bytes,
                         ratio, 2 * count);
            cvol_array_free(array);
        }
        cvol_array_free(from);
        free(samples);
    }
}

/* Without its histogram a file is smaller, and decodes to the same samples. */
static void histograms_can_be_left_out(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(50, 40, 45, CVOL_FLOAT32);
    const size_t count = cvol_grid_samples(&grid), zero[3] = {0, 0, 0};
    float *samples = make_volume(&grid, 4), *out[2];
    cvol_array *from = compress(samples, &grid, 16, 10);
    uint64_t bytes[2];
    for (int without = 0; without <= 1; without++) {
        cvol_compress_options options = options_of(CVOL_TARGET_PSNR, 30);
        cvol_array *array;
        options.no_histogram = without;
        check_ok(cvol_array_transcode(context, &array, NULL, from, &options));
        check_ok(cvol_array_file_bytes(context, array, &bytes[without]));
        out[without] = malloc(count * sizeof(float));
        assert_non_null(out[without]);
        check_ok(cvol_array_evaluate_box(context, out[without], array, zero, grid.dims));
        cvol_array_free(array);
    }
    assert_true(bytes[1] < bytes[0] && bytes[0] - bytes[1] < 300);
    assert_memory_equal(out[0], out[1], count * sizeof(float));
    free(out[0]);
    free(out[1]);
    cvol_array_free(from);
    free(samples);
}

/* An array of effort fast has many small terms, which are all dropped at once when bits have their
 * usual weight: slightly coarser steps must be possible, too. */
static void slightly_coarser_than_effort_fast(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(80, 24, 70, CVOL_FLOAT32);
    float *samples = make_volume(&grid, 11);
    cvol_compress_options options = options_of(CVOL_TARGET_RATIO, 40);
    cvol_array *from, *array;
    options.effort = CVOL_EFFORT_FAST;
    check_ok(cvol_compress(context, &from, NULL, samples, &grid, &options));
    double bound = from->error_bound.l2_error;
    for (double ratio = 44; ratio < 100; ratio *= pow(1.3, SUPPORT_STRIDE)) {
        cvol_compress_report report;
        options = options_of(CVOL_TARGET_RATIO, ratio);
        check_ok(cvol_array_transcode(context, &array, &report, from, &options));
        if (test_verbose())
            print_message("asked %g: %g, off by %g\n", ratio, report.ratio, report.psnr_db);
        assert_true(report.target_met && report.ratio >= ratio && report.ratio < 1.1 * ratio);
        assert_true(distance(array, samples) <= array->error_bound.l2_error);
        assert_true(array->error_bound.l2_error > bound);
        bound = array->error_bound.l2_error;
        cvol_array_free(array);
    }
    cvol_array_free(from);
    free(samples);
}

/* Values chosen with respect to later ones are chosen in the same way again. */
static void slightly_coarser_loses_little(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(48, 40, 36, CVOL_FLOAT32);
    float *samples = make_volume(&grid, 5);
    cvol_array *from = compress(samples, &grid, 16, 20), *array;
    const cvol_compress_options options = options_of(CVOL_TARGET_RATIO, 21);
    check_ok(cvol_array_transcode(context, &array, NULL, from, &options));
    const double before = distance(from, samples), now = distance(array, samples);
    if (test_verbose())
        print_message("from %g to %g\n", before, now);
    assert_true(now < 1.4 * before);
    cvol_array_free(array);
    cvol_array_free(from);
    free(samples);
}

static void finer_is_refused(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(60, 50, 40, CVOL_FLOAT32);
    float *samples = make_volume(&grid, 8);
    cvol_array *from = compress(samples, &grid, 16, 20), *array;
    cvol_compress_options options = options_of(CVOL_TARGET_RATIO, 10);
    assert_int_equal(cvol_array_transcode(context, &array, NULL, from, &options),
                     CVOL_ERROR_TARGET);
    assert_non_null(strstr(cvol_context_message(context), "finer"));
    assert_null(array);
    options = options_of(CVOL_TARGET_PSNR, 90);
    assert_int_equal(cvol_array_transcode(context, &array, NULL, from, &options),
                     CVOL_ERROR_TARGET);
    assert_non_null(strstr(cvol_context_message(context), "promised"));
    options = options_of(CVOL_TARGET_MAX_ERROR, 3);
    assert_int_equal(cvol_array_transcode(context, &array, NULL, from, &options),
                     CVOL_ERROR_UNSUPPORTED);
    cvol_array_free(from);
    /* A source with errors of its own: decoded samples are compressed. */
    options = options_of(CVOL_TARGET_MAX_ERROR, 20);
    check_ok(cvol_compress(context, &from, NULL, samples, &grid, &options));
    options = options_of(CVOL_TARGET_PSNR, from->psnr_db + 1);
    assert_int_equal(cvol_array_transcode(context, &array, NULL, from, &options),
                     CVOL_ERROR_TARGET);
    assert_non_null(strstr(cvol_context_message(context), "promised"));
    cvol_array_free(from);
    free(samples);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ratios_and_bounds_hold),
        cmocka_unit_test(psnr_is_reached),
        cmocka_unit_test(any_threads_give_the_same_bytes),
        cmocka_unit_test(coarse_bounds_hold_at_the_ends),
        cmocka_unit_test(masks_are_kept),
        cmocka_unit_test(psnr_does_not_count_missing_samples),
        cmocka_unit_test(all_fills_of_a_lossless_array_are_kept),
        cmocka_unit_test(residuals_are_decoded),
        cmocka_unit_test(blocks_are_kept),
        cmocka_unit_test(residuals_keep_the_range),
        cmocka_unit_test(residuals_count),
        cmocka_unit_test(small_files_keep_ratio),
        cmocka_unit_test(histograms_can_be_left_out),
        cmocka_unit_test(finer_is_refused),
        cmocka_unit_test(slightly_coarser_than_effort_fast),
        cmocka_unit_test(slightly_coarser_loses_little),
    };
    return cmocka_run_group_tests(tests, context_setup_two, context_teardown);
}
