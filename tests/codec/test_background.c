/* A separate background: found if it saves bytes, exact, an ordinary value for evaluation,
 * rendering and measurement, and merged into the terms for statistics. */
#include "test.h"

#include "array/core/array.h"
#include "base/for_type.h"
#include "codec/container/array_file.h"
#include "codec/container/header.h"
#include "cvol/algebra.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

/* Two bricks in x in every build. */
enum { NX = 75, NY = SUPPORT_SIDE(66), NZ = SUPPORT_SIDE(70), COUNT = NX * NY * NZ };

static const size_t dims[3] = {NX, NY, NZ}, zero[3] = {0, 0, 0};

/* ---- volumes --------------------------------------------------------------------------------- */

static int is_outside(size_t i)
{
    const double x = (double)(i % NX) - 34, y = (double)(i / NX % NY) * 66 / NY - 31,
                 z = (double)(i / NX / NY) * 70 / NZ - 36;
    return x * x + 1.3 * y * y + 0.8 * z * z > 700;
}

/* A body with some detail, and `background` around it, which may be noisy. */
static cvol_volume make_body(cvol_type type, double background, double noise, uint64_t seed)
{
    random_state r = {seed};
    cvol_volume volume = support_volume(NX, NY, NZ, type);
#define SET(t)                                                                                   \
    for (size_t i = 0; i < COUNT; i++) {                                                         \
        const double x = (double)(i % NX), y = (double)(i / NX % NY), z = (double)(i / NX / NY); \
        const double value = 100 + 20 * sin(x / 4) * cos(y / 5) + 10 * sin(z / 3 + x / 9);       \
        const double around = background + noise * fabs(random_signed(&r));                      \
        ((t *)volume.data)[i] = (t)(is_outside(i) ? around : value + random_signed(&r));         \
    }
    CVOL_FOR_TYPE(type, SET)
#undef SET
    return volume;
}

static cvol_compress_options finding(cvol_target target, double value)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target = target;
    options.target_value = value;
    options.background = CVOL_BACKGROUND_FIND;
    return options;
}

static cvol_array *compress(const cvol_volume *volume, const cvol_compress_options *options,
                            cvol_compress_report *report)
{
    cvol_array *array;
    if (cvol_compress(context, &array, report, volume->data, &volume->grid, options))
        fail_msg("%s", cvol_context_message(context));
    return array;
}

static double psnr_between(const cvol_volume *a, const cvol_volume *b)
{
    double squares = 0, lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; i < COUNT; i++) {
        const double value = support_sample(a, i), off = value - support_sample(b, i);
        squares += off * off;
        lo = fmin(lo, value);
        hi = fmax(hi, value);
    }
    return 20 * log10((hi - lo) / sqrt(squares / COUNT));
}

static cvol_volume decode(const cvol_array *array)
{
    cvol_volume volume = support_volume(NX, NY, NZ, cvol_array_grid(array)->type);
    assert_int_equal(cvol_array_evaluate_box(context, volume.data, array, zero, dims), CVOL_OK);
    return volume;
}

static uint64_t distance_in(const cvol_array *array)
{
    cvol_array_info info;
    cvol_array_get_info(&info, array);
    return info.background_samples;
}

/* ---- compressing ----------------------------------------------------------------------------- */

static void test_background_is_exact_and_saves_bytes(void **state)
{
    (void)state;
    static const cvol_type types[] = {CVOL_UINT8, CVOL_INT16, CVOL_FLOAT32, CVOL_FLOAT64};
    for (int t = 0; t < 4; t += SUPPORT_STRIDE) {
        const double background = types[t] == CVOL_UINT8 ? 3 : -500;
        cvol_volume volume = make_body(types[t], background, 0, 1);
        cvol_compress_options options = finding(CVOL_TARGET_PSNR, 44);
        cvol_compress_report with, without;
        cvol_array *array = compress(&volume, &options, &with);
        uint64_t outside = 0;
        for (size_t i = 0; i < COUNT; i++)
            outside += support_sample(&volume, i) == background;
        assert_true(with.background_samples == outside && with.background == background);
        assert_true(distance_in(array) == outside);
        cvol_volume back = decode(array);
        for (size_t i = 0; i < COUNT; i++)
            if (is_outside(i) && support_sample(&back, i) != background)
                fail_msg("type %d: sample %zu is %g", (int)types[t], i, support_sample(&back, i));
        assert_true(with.psnr_db >= 44);
        assert_true(fabs(psnr_between(&volume, &back) - with.psnr_db) < 0.001);
        options.background = CVOL_BACKGROUND_NONE;
        cvol_array_free(array);
        array = compress(&volume, &options, &without);
        assert_true(without.background_samples == 0 && distance_in(array) == 0);
        if (with.file_bytes >= without.file_bytes * 3 / 4)
            fail_msg("type %d: %llu bytes with, %llu without", (int)types[t],
                     (unsigned long long)with.file_bytes, (unsigned long long)without.file_bytes);
        cvol_array_free(array);
        free(back.data);
        free(volume.data);
    }
}

static void test_ratios_are_kept(void **state)
{
    (void)state;
    cvol_volume volume = make_body(CVOL_UINT8, 0, 0, 2);
    uint64_t last_apart = 1;
    for (int r = 0; r < 3; r += SUPPORT_STRIDE) {
        const cvol_compress_options options = finding(CVOL_TARGET_RATIO, 12 << r);
        cvol_compress_report report;
        cvol_array *array = compress(&volume, &options, &report);
        assert_true(report.target_met && report.ratio >= 12 << r);
        assert_true(report.ratio <= 1.021 * (12 << r));
        cvol_array_free(array);
    }
    /* If a mask takes much of the file, the better of both ways is chosen. */
    for (int r = 75; r <= 1200 * COUNT / (75 * 66 * 70); r *= 4) {
        cvol_compress_options options = finding(CVOL_TARGET_RATIO, r);
        cvol_compress_report best, without;
        cvol_array_free(compress(&volume, &options, &best));
        options.background = CVOL_BACKGROUND_NONE;
        cvol_array_free(compress(&volume, &options, &without));
        if (best.psnr_db < without.psnr_db || best.ratio < r)
            fail_msg("1/%d: 1/%g at %g dB, without 1/%g at %g dB", r, best.ratio, best.psnr_db,
                     without.ratio, without.psnr_db);
        last_apart = best.background_samples;
    }
    assert_true(last_apart == 0);
    free(volume.data);
}

static void test_no_background_without_gain(void **state)
{
    (void)state;
    cvol_compress_report report;
    cvol_compress_options options = finding(CVOL_TARGET_PSNR, 40);
    cvol_volume noisy = make_body(CVOL_UINT8, 0, 9, 3), smooth = support_blobs(NX, NY, NZ);
    cvol_array_free(compress(&noisy, &options, &report));
    assert_int_equal(report.background_samples, 0);
    cvol_array_free(compress(&smooth, &options, &report));
    assert_int_equal(report.background_samples, 0);
    /* Steps so fine that a background saves nothing. */
    cvol_volume sharp = make_body(CVOL_FLOAT32, 0, 0, 4);
    options.target_value = 100;
    cvol_array_free(compress(&sharp, &options, &report));
    assert_int_equal(report.background_samples, 0);
    assert_true(report.psnr_db >= 100);
    /* So few terms that the mask would take most of the file. */
    cvol_volume body = make_body(CVOL_UINT8, 0, 0, 5);
    cvol_compress_options coarse = finding(CVOL_TARGET_PSNR, 20);
    cvol_compress_report without;
    cvol_array_free(compress(&body, &coarse, &report));
    coarse.background = CVOL_BACKGROUND_NONE;
    cvol_array_free(compress(&body, &coarse, &without));
    assert_true(report.background_samples == 0 && report.psnr_db >= 20);
    assert_int_equal(report.file_bytes, without.file_bytes);
    free(body.data);
    /* It can still be requested. */
    options.background = CVOL_BACKGROUND_VALUE;
    cvol_array_free(compress(&sharp, &options, &report));
    assert_true(report.background_samples > 0 && report.psnr_db >= 100);
    free(noisy.data);
    free(smooth.data);
    free(sharp.data);
}

/* Samples without a value are a mask already: their fill is not a background. */
static void test_fill_is_not_background(void **state)
{
    (void)state;
    cvol_volume volume = make_body(CVOL_INT16, -1000, 0, 8);
    cvol_compress_report report;
    cvol_compress_options options = finding(CVOL_TARGET_PSNR, 38);
    options.has_fill = 1;
    options.fill = -1000;
    cvol_array *array = compress(&volume, &options, &report);
    assert_int_equal(report.background_samples, 0);
    assert_true(report.psnr_db >= 38 && report.psnr_db < 40);
    cvol_array_free(array);
    free(volume.data);
}

static void test_invalid_options(void **state)
{
    (void)state;
    cvol_volume volume = make_body(CVOL_UINT8, 0, 0, 5);
    cvol_array *array;
    cvol_compress_options options = finding(CVOL_TARGET_PSNR, 40);
    options.background = CVOL_BACKGROUND_VALUE;
    options.background_value = 0.5;
    assert_int_equal(cvol_compress(context, &array, NULL, volume.data, &volume.grid, &options),
                     CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "uint8 cannot hold the background 0.5"));
    options.background_value = 0;
    options.lossless = 1;
    assert_int_equal(cvol_compress(context, &array, NULL, volume.data, &volume.grid, &options),
                     CVOL_ERROR_ARGUMENT);
    /* A value without samples is not a background. */
    cvol_compress_report report;
    options.lossless = 0;
    options.background_value = 250;
    array = compress(&volume, &options, &report);
    assert_int_equal(report.background_samples, 0);
    cvol_array_free(array);
    free(volume.data);
}

/* ---- files ----------------------------------------------------------------------------------- */

static void test_files_keep_it(void **state)
{
    (void)state;
    char *folder = support_folder_make(), *path = support_path(folder, "background.cvol");
    cvol_volume volume = make_body(CVOL_INT16, -7, 0, 6);
    const cvol_compress_options options = finding(CVOL_TARGET_PSNR, 50);
    uint64_t bytes[2];
    cvol_array *arrays[2], *read, *coarse;
    cvol_compress_report report;
    for (int i = 0; i < 2; i++) {
        cvol_context_set_threads(context, 1 + 2 * i);
        arrays[i] = compress(&volume, &options, &report);
        assert_int_equal(cvol_array_write(context, arrays[i], path, &bytes[i]), CVOL_OK);
        assert_true(bytes[i] == report.file_bytes);
    }
    assert_true(bytes[0] == bytes[1]);
    assert_int_equal(cvol_array_read(context, &read, path, NULL), CVOL_OK);
    cvol_volume a = decode(arrays[0]), b = decode(arrays[1]), c = decode(read);
    assert_memory_equal(a.data, b.data, COUNT * sizeof(int16_t));
    assert_memory_equal(a.data, c.data, COUNT * sizeof(int16_t));
    assert_true(distance_in(read) == distance_in(arrays[0]));
    /* Coarser: the background stays unchanged, and the target is met. */
    cvol_compress_options less = finding(CVOL_TARGET_RATIO, report.ratio * 1.5);
    assert_int_equal(cvol_array_transcode(context, &coarse, &report, read, &less), CVOL_OK);
    cvol_volume d = decode(coarse);
    for (size_t i = 0; i < COUNT; i++)
        if (is_outside(i))
            assert_int_equal(((int16_t *)d.data)[i], -7);
    assert_true(psnr_between(&volume, &d) >= report.psnr_db);
    cvol_array_free(arrays[0]);
    cvol_array_free(arrays[1]);
    cvol_array_free(read);
    cvol_array_free(coarse);
    free(a.data);
    free(b.data);
    free(c.data);
    free(d.data);
    free(volume.data);
    free(path);
    support_folder_remove(folder);
}

static void test_invalid_headers(void **state)
{
    (void)state;
    cvol_volume volume = make_body(CVOL_UINT8, 0, 0, 7);
    const cvol_compress_options options = finding(CVOL_TARGET_PSNR, 40);
    cvol_array *array = compress(&volume, &options, NULL);
    const cvol_header header = cvol_header_of(array);
    for (int overwrite = 0; overwrite < 4; overwrite++) {
        cvol_header given = header, told = header;
        cvol_bytes bytes = {0};
        given.fills.background = overwrite == 1 ? 2 : 1;
        given.fills.bits[0] = overwrite == 2 ? 255 : 0;
        if (overwrite == 3)
            given.fills.bits[given.fills.count++] = 9;
        told.fills = (cvol_fills){0};
        cvol_modes_put(&bytes, &given);
        cvol_cursor content = {.data = bytes.data, .size = bytes.size};
        const int code = cvol_modes_take(context, &told, &content, "x.cvol");
        assert_int_equal(code, overwrite ? CVOL_ERROR_CORRUPT : CVOL_OK);
        if (overwrite)
            assert_non_null(strstr(cvol_context_message(context), "section MODE: "));
        cvol_bytes_free(&bytes);
    }
    cvol_array_free(array);
    free(volume.data);
}

/* ---- evaluating and rendering ---------------------------------------------------------------- */

static void test_real_samples_and_ranges(void **state)
{
    (void)state;
    cvol_volume volume = make_body(CVOL_UINT8, 20, 0, 8);
    const cvol_compress_options options = finding(CVOL_TARGET_PSNR, 45);
    cvol_array *array = compress(&volume, &options, NULL);
    cvol_volume back = decode(array);
    float *real = malloc(COUNT * sizeof *real);
    uint8_t *which = malloc(COUNT);
    assert_true(real && which);
    assert_int_equal(cvol_array_evaluate_real(context, real, array, zero, dims), CVOL_OK);
    assert_int_equal(cvol_array_evaluate_mask(which, array, zero, dims), 0);
    double error = 0;
    for (size_t i = 0; i < COUNT; i++) {
        const double off = (double)real[i] - support_sample(&volume, i);
        error += off * off;
        assert_true(is_outside(i) ? (double)real[i] == 20
                                  : fabs((double)real[i] - support_sample(&back, i)) < 0.5001 ||
                                        support_sample(&back, i) == array->error_bound.value_min ||
                                        support_sample(&back, i) == array->error_bound.value_max);
    }
    assert_true(sqrt(error) <= array->error_bound.l2_error);
    assert_int_equal(cvol_array_ensure_ranges(context, array), CVOL_OK);
    const double unit = (array->range_max - array->range_min) / 255;
    for (size_t b = 0; b < array->block_count; b++) {
        size_t at[3];
        cvol_block_origin(at, array, b);
        const double value = (double)real[at[0] + NX * (at[1] + NY * at[2])];
        const uint8_t *range = array->block_table[b].range;
        assert_true(value >= array->range_min + unit * range[0] - 1e-3 &&
                    value <= array->range_min + unit * range[1] + 1e-3);
    }
    cvol_array_free(array);
    free(back.data);
    free(real);
    free(which);
    free(volume.data);
}

/* The edge of a background is as sharp as in the samples; without a background, the codec smooths
 * it. Pixels of three samples show more of such an edge: with float samples (sets below AVX-512),
 * up to 1.24 dB. */
#define COARSE_LOSS 1.5

/* The sheet engine's picture is as close to the ray engine's of the decoded samples as without a
 * background: for all modes, sizes and directions, and for lapped and other volumes. */
static void test_pictures(void **state)
{
    (void)state;
    static const cvol_mode modes[] = {CVOL_MODE_COMPOSITE, CVOL_MODE_XRAY, CVOL_MODE_MIP};
    static const cvol_transfer_point points[] = {
        {30, 1, 0, 0, 0}, {60, 1, .4, 0, .2}, {110, .6, .9, .2, .5}, {130, 1, 1, 1, 1}};
    cvol_volume volume = make_body(CVOL_UINT8, 5, 0, 9);
    cvol_array *arrays[2][2]; /* lapped or not, with a background or not */
    cvol_volume decoded[2][2];
    for (int i = 0; i < 4; i++) {
        cvol_compress_options options = finding(CVOL_TARGET_PSNR, 52);
        options.lapped = i / 2;
        options.background = i % 2 ? CVOL_BACKGROUND_FIND : CVOL_BACKGROUND_NONE;
        arrays[i / 2][i % 2] = compress(&volume, &options, NULL);
        decoded[i / 2][i % 2] = decode(arrays[i / 2][i % 2]);
        assert_int_equal(distance_in(arrays[i / 2][i % 2]) > 0, i % 2);
    }
    for (int k = 0; k < 12; k += SUPPORT_STRIDE) {
        cvol_render_options view = support_square(k % 4 == 3 ? 40 : 130, modes[k / 2 % 3], 47 * k,
                                                  31 * (k % 5) - 60);
        double psnr[2];
        view.camera.zoom = k % 4 == 2 ? 2.5 : 1;
        cvol_render_options fine = view;
        fine.step_voxels = 0.25;
        for (int apart = 0; apart < 2; apart++) {
            const int lapped = !(k & 1);
            cvol_image *sheet = support_sheet(context, arrays[lapped][apart], points, 4, &view);
            cvol_image *ray = support_ray(context, &decoded[lapped][apart], points, 4, &fine);
            psnr[apart] = support_psnr(sheet, ray);
            cvol_image_free(sheet);
            cvol_image_free(ray);
        }
        if (test_verbose())
            print_message("view %d: %.2f without, %.2f dB with\n", k, psnr[0], psnr[1]);
        if (psnr[1] < fmin(psnr[0] - (view.width < NX ? COARSE_LOSS : 0.7), 45))
            fail_msg("view %d: %.2f dB, without a background %.2f", k, psnr[1], psnr[0]);
    }
    for (int i = 0; i < 4; i++) {
        cvol_array_free(arrays[i / 2][i % 2]);
        free(decoded[i / 2][i % 2].data);
    }
    free(volume.data);
}

/* ---- operations ------------------------------------------------------------------------------ */

static void test_flat_background(void **state)
{
    (void)state;
    cvol_volume volume = make_body(CVOL_UINT8, 0, 0, 10);
    const cvol_compress_options options = finding(CVOL_TARGET_PSNR, 48);
    cvol_array *array = compress(&volume, &options, NULL), *flat, *sum = NULL;
    cvol_array_statistics statistics;
    assert_int_equal(cvol_array_flatten(context, &flat, array), CVOL_OK);
    assert_true(distance_in(flat) == 0 && cvol_array_grid(flat)->type == CVOL_UINT8);
    float *real = malloc(COUNT * sizeof *real);
    assert_non_null(real);
    assert_int_equal(cvol_array_evaluate_real(context, real, flat, zero, dims), CVOL_OK);
    double error = 0, total = 0;
    for (size_t i = 0; i < COUNT; i++) {
        const double off = (double)real[i] - support_sample(&volume, i);
        error += off * off;
        total += support_sample(&volume, i);
    }
    assert_true(sqrt(error) <= flat->error_bound.l2_error);
    assert_true(flat->error_bound.l2_error < 1.51 * array->error_bound.l2_error);
    assert_int_equal(cvol_array_compute_statistics(context, &statistics, flat), CVOL_OK);
    assert_true(fabs(statistics.sum - total) <= statistics.sum_error);
    assert_int_equal(cvol_array_add(context, &sum, 1, flat, 1, flat, NULL), CVOL_OK);
    cvol_array_free(sum);
    assert_int_equal(cvol_array_flatten(context, &sum, flat), CVOL_ERROR_ARGUMENT);
    cvol_array_free(flat);
    cvol_array_free(array);
    free(real);
    free(volume.data);
}

/* The array of a result has no ranges yet. The writer finds them: they and the bound of the largest
 * sample, from which products take their bounds, include the background. */
static void test_files_of_results(void **state)
{
    (void)state;
    cvol_volume volume = make_body(CVOL_FLOAT32, 3000, 0, 11);
    const cvol_compress_options options = finding(CVOL_TARGET_PSNR, 48);
    cvol_array *array = compress(&volume, &options, NULL), *twice, *back;
    void *bytes;
    size_t size;
    cvol_array_info info;
    assert_int_equal(cvol_array_scale(context, &twice, 2, array, 0), CVOL_OK);
    assert_int_equal(cvol_array_write_memory(context, twice, &bytes, &size), CVOL_OK);
    assert_int_equal(cvol_array_read_memory(context, &back, bytes, size, "back"), CVOL_OK);
    cvol_array_get_info(&info, back);
    assert_true(info.background == 6000 && info.max_abs >= 6000);
    free(bytes);
    cvol_array_free(back);
    cvol_array_free(twice);
    cvol_array_free(array);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_background_is_exact_and_saves_bytes),
        TEST(test_ratios_are_kept),
        TEST(test_no_background_without_gain),
        TEST(test_fill_is_not_background),
        TEST(test_invalid_options),
        TEST(test_files_keep_it),
        TEST(test_invalid_headers),
        TEST(test_real_samples_and_ranges),
        TEST(test_pictures),
        TEST(test_flat_background),
        TEST(test_files_of_results),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
