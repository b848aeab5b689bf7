/* Files with a residual (lossless, or with a maximum error): pictures, figures and operations use
 * the decoded samples, not the coarse terms below the residual. */
#include "test.h"

#include "array/core/array.h"
#include "array/evaluate/decoded_terms.h"
#include "cvol/algebra.h"
#include "random.h"
#include "render/sheet/frame/policy.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

enum { NX = 93, NY = 70, NZ = 81, COUNT = NX * NY * NZ };
static const size_t zero[3], dims[3] = {NX, NY, NZ};

static const cvol_transfer_point points[] = {
    {0, 0, 0, 0, 0}, {40, 1, .3, .1, 0}, {120, 1, .8, .4, .25}, {255, 1, 1, .9, .7}};

/* Thin bright vessels on zeros: their terms are as coarse as possible. */
static cvol_volume make_vessels(cvol_type type)
{
    cvol_volume volume = support_volume(NX, NY, NZ, type);
    for (int k = 0; k < 14; k++)
        for (int i = 0; i < 400; i++) {
            const double t = i / 400.0;
            const double at[3] = {NX * (0.15 + 0.7 * t), NY * (0.5 + 0.4 * sin(5 * t + k)),
                                  NZ * (0.5 + 0.4 * cos(3 * t + 2.2 * k))};
            for (int j = 0; j < 27; j++) {
                const double p[3] = {round(at[0]) + j % 3 - 1, round(at[1]) + j / 3 % 3 - 1,
                                     round(at[2]) + j / 9 - 1};
                const double d = pow(p[0] - at[0], 2) + pow(p[1] - at[1], 2) + pow(p[2] - at[2], 2);
                const size_t at_index = support_index(&volume, (size_t)p[0], (size_t)p[1],
                                                      (size_t)p[2]);
                if (type == CVOL_UINT8 && d < 2)
                    ((uint8_t *)volume.data)[at_index] = (uint8_t)(150 + 7 * k);
                else if (type == CVOL_INT16 && d < 2)
                    ((int16_t *)volume.data)[at_index] = (int16_t)(150 + 7 * k);
            }
        }
    return volume;
}

static cvol_array *compress(const cvol_volume *volume, const cvol_compress_options *options)
{
    cvol_array *array, *read;
    void *file;
    size_t size;
    if (cvol_compress(context, &array, NULL, volume->data, &volume->grid, options) ||
        cvol_array_write_memory(context, array, &file, &size) ||
        cvol_array_read_memory(context, &read, file, size, "exact"))
        fail_msg("%s", cvol_context_message(context));
    cvol_array_free(array);
    free(file);
    return read;
}

static cvol_volume decode(const cvol_array *array)
{
    cvol_volume volume = support_volume(NX, NY, NZ, cvol_array_grid(array)->type);
    assert_int_equal(cvol_array_evaluate_box(context, volume.data, array, zero, dims), CVOL_OK);
    return volume;
}

/* ---- pictures -------------------------------------------------------------------------------- */

/* Compared with the ray engine's pictures of the decoded samples: as close as those of a file of
 * the same samples with almost no error. */
static void expect_pictures(const cvol_array *array, const char *name)
{
    cvol_volume back = decode(array);
    const cvol_keep keep = cvol_keep_step(0.5);
    static const cvol_mode modes[] = {CVOL_MODE_COMPOSITE, CVOL_MODE_MIP, CVOL_MODE_XRAY};
    cvol_array *fine;
    assert_int_equal(
        cvol_array_compress(context, &fine, back.data, &back.grid, 3, CVOL_DCT, 16, &keep),
        CVOL_OK);
    for (int i = 0; i < 3; i++) {
        cvol_render_options view = support_square(120, modes[i], 40 + 50 * i, 20);
        cvol_image *of_it = support_sheet(context, array, points, 4, &view);
        cvol_image *of_fine = support_sheet(context, fine, points, 4, &view);
        view.step_voxels = 0.25;
        cvol_image *ray = support_ray(context, &back, points, 4, &view);
        const double psnr = support_psnr(of_it, ray), best = support_psnr(of_fine, ray);
        if (test_verbose())
            print_message("%s, mode %d: %.2f dB, at best %.2f\n", name, i, psnr, best);
        if (psnr < fmin(best - 0.5, 60))
            fail_msg("%s, mode %d: %.2f dB from the ray engine's, at best %.2f", name, i, psnr,
                     best);
        cvol_image_free(of_it);
        cvol_image_free(of_fine);
        cvol_image_free(ray);
    }
    cvol_array_free(fine);
    free(back.data);
}

static void test_pictures_show_the_decoded_samples(void **state)
{
    (void)state;
    cvol_volume volume = make_vessels(CVOL_UINT8);
    cvol_compress_options options = cvol_compress_options_defaults();
    options.lossless = 1;
    cvol_array *array = compress(&volume, &options);
    expect_pictures(array, "lossless");
    cvol_array_free(array);
    options.lossless = 0;
    options.target = CVOL_TARGET_MAX_ERROR;
    options.target_value = 6;
    array = compress(&volume, &options);
    expect_pictures(array, "largest error");
    cvol_array_free(array);
    free(volume.data);
}

/* A mask of 0 and 1: half a unit is no small step there. */
static void test_pictures_show_a_mask(void **state)
{
    (void)state;
    static const cvol_transfer_point of_mask[] = {{0.2, 1, .3, .1, 0}, {1, 1, .9, .8, 0.4}};
    const cvol_keep keep = cvol_keep_step(0.002);
    cvol_volume volume = make_vessels(CVOL_UINT8);
    uint8_t *samples = volume.data;
    for (size_t i = 0; i < COUNT; i++)
        samples[i] = samples[i] > 0;
    cvol_compress_options options = cvol_compress_options_defaults();
    options.lossless = 1;
    cvol_array *exact = compress(&volume, &options), *fine;
    assert_int_equal(
        cvol_array_compress(context, &fine, volume.data, &volume.grid, 3, CVOL_DCT, 16, &keep),
        CVOL_OK);
    cvol_render_options view = support_square(100, CVOL_MODE_COMPOSITE, 30, 25);
    cvol_image *a = support_sheet(context, exact, of_mask, 2, &view);
    cvol_image *b = support_sheet(context, fine, of_mask, 2, &view);
    const double psnr = support_psnr(a, b);
    if (psnr < 50)
        fail_msg("%.2f dB from the picture of the samples", psnr);
    cvol_image_free(a);
    cvol_image_free(b);
    cvol_array_free(exact);
    cvol_array_free(fine);
    free(volume.data);
}

/* The terms of an exact file are rounded. That is no error of the data, which would hide coarse
 * sampling of translucent objects. */
static void test_exact_files_have_no_noise(void **state)
{
    (void)state;
    static const cvol_transfer_point soft[] = {{20, 1, 0, 0, 0}, {200, 1, 1, 1, 0.15}};
    cvol_volume volume = make_vessels(CVOL_INT16);
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_transfer *transfer;
    const cvol_array *terms;
    options.lossless = 1;
    cvol_array *array = compress(&volume, &options);
    assert_int_equal(cvol_transfer_create(context, &transfer, soft, 2), CVOL_OK);
    assert_int_equal(cvol_array_decoded_terms(context, &terms, array), CVOL_OK);
    assert_true(terms->error_bound.l2_error > 0);
    assert_true(!(cvol_transfer_traits_of(terms, transfer).noise > 0));
    cvol_transfer_free(transfer);
    cvol_array_free(array);
    free(volume.data);
}

/* The same at levels, compared with those of a file with almost no error. */
static void test_levels_show_the_decoded_samples(void **state)
{
    (void)state;
    cvol_volume volume = make_vessels(CVOL_UINT8);
    cvol_compress_options options = cvol_compress_options_defaults();
    options.lossless = 1;
    cvol_array *exact = compress(&volume, &options), *fine;
    const cvol_keep keep = cvol_keep_step(0.5);
    assert_int_equal(
        cvol_array_compress(context, &fine, volume.data, &volume.grid, 3, CVOL_DCT, 16, &keep),
        CVOL_OK);
    for (int level = 1; level <= 3; level++) {
        cvol_render_options view = support_square(100, CVOL_MODE_COMPOSITE, 30, 25);
        view.level = level;
        cvol_image *a = support_sheet(context, exact, points, 4, &view);
        cvol_image *b = support_sheet(context, fine, points, 4, &view);
        const double psnr = support_psnr(a, b);
        if (psnr < 50)
            fail_msg("level %d: %.2f dB from the samples'", level, psnr);
        cvol_image_free(a);
        cvol_image_free(b);
    }
    cvol_array_free(exact);
    cvol_array_free(fine);
    free(volume.data);
}

/* ---- values ---------------------------------------------------------------------------------- */

static void test_values_are_the_decoded_samples(void **state)
{
    (void)state;
    cvol_volume volume = make_vessels(CVOL_INT16);
    const int16_t *truth = volume.data;
    cvol_compress_options options = cvol_compress_options_defaults();
    options.lossless = 1;
    cvol_array *array = compress(&volume, &options), *doubled;
    float *real = malloc(COUNT * sizeof *real);
    assert_int_equal(cvol_array_evaluate_real(context, real, array, zero, dims), CVOL_OK);
    for (size_t i = 0; i < COUNT; i++)
        assert_true(real[i] == truth[i]);
    /* operations: within the bound, which is small */
    assert_int_equal(cvol_array_scale(context, &doubled, 2, array, 1), CVOL_OK);
    assert_int_equal(cvol_array_evaluate_real(context, real, doubled, zero, dims), CVOL_OK);
    double squares = 0, sum = 0, norm = 0;
    for (size_t i = 0; i < COUNT; i++) {
        squares += pow(real[i] - 2.0 * truth[i] - 1, 2);
        sum += truth[i];
        norm += (double)truth[i] * truth[i];
    }
    assert_true(sqrt(squares) <= doubled->error_bound.l2_error);
    assert_true(doubled->error_bound.l2_error < 0.3 * sqrt(COUNT));
    cvol_array_statistics of;
    assert_int_equal(cvol_array_compute_statistics(context, &of, array), CVOL_OK);
    assert_true(fabs(of.sum - sum) <= of.sum_error);
    assert_true(fabs(of.l2_norm - sqrt(norm)) <= of.l2_norm_error);
    assert_true(of.mean_error < 0.3);
    /* points on samples */
    random_state r = {5};
    for (int i = 0; i < 50; i++) {
        const double at[3] = {(double)(random_below(&r, NX)), (double)(random_below(&r, NY)),
                              (double)(random_below(&r, NZ))};
        float value;
        assert_int_equal(cvol_array_evaluate_points(context, &value, array, at, 1), CVOL_OK);
        const double exact =
            truth[support_index(&volume, (size_t)at[0], (size_t)at[1], (size_t)at[2])];
        if (fabs(value - exact) > 3)
            fail_msg("point %d: %g instead of %g", i, (double)value, exact);
    }
    free(real);
    cvol_array_free(doubled);
    cvol_array_free(array);
    free(volume.data);
}

/* A lossy file made from an exact one uses its samples, not its terms. */
static void test_transcoding_starts_from_the_decoded_samples(void **state)
{
    (void)state;
    cvol_volume volume = make_vessels(CVOL_UINT8);
    cvol_compress_options options = cvol_compress_options_defaults();
    options.lossless = 1;
    cvol_array *array = compress(&volume, &options), *coarse;
    options = cvol_compress_options_defaults();
    options.target = CVOL_TARGET_PSNR;
    options.target_value = 30;
    cvol_compress_report report;
    assert_int_equal(cvol_array_transcode(context, &coarse, &report, array, &options), CVOL_OK);
    cvol_volume back = decode(coarse);
    double squares = 0;
    for (size_t i = 0; i < COUNT; i++)
        squares += pow((double)((uint8_t *)back.data)[i] - ((uint8_t *)volume.data)[i], 2);
    assert_true(20 * log10(248 / sqrt(squares / COUNT)) > 29.5);
    cvol_array_free(coarse);
    cvol_array_free(array);
    free(back.data);
    free(volume.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pictures_show_the_decoded_samples),
        cmocka_unit_test(test_pictures_show_a_mask),
        cmocka_unit_test(test_exact_files_have_no_noise),
        cmocka_unit_test(test_levels_show_the_decoded_samples),
        cmocka_unit_test(test_values_are_the_decoded_samples),
        cmocka_unit_test(test_transcoding_starts_from_the_decoded_samples),
    };
    return cmocka_run_group_tests(tests, context_setup_two, context_teardown);
}
