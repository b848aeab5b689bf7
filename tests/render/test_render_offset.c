/* Pictures of samples far from 0: the same as those of the samples less a constant. Windows and
 * transfer functions move with the constant. */
#include "test.h"

#include "cvol/algebra.h"
#include "cvol/codec.h"
#include "cvol/look.h"
#include "cvol/transfer.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

enum { SIDE = 56 };

/* A ball of noisy waves in 0 .. 1. */
static cvol_array *make_array(void)
{
    random_state r = {7};
    cvol_volume volume = support_volume(SIDE, SIDE, SIDE, CVOL_FLOAT64);
    double *samples = volume.data;
    for (size_t z = 0; z < SIDE; z++)
        for (size_t y = 0; y < SIDE; y++)
            for (size_t x = 0; x < SIDE; x++) {
                const double at[3] = {(double)x / SIDE - 0.5, (double)y / SIDE - 0.5,
                                      (double)z / SIDE - 0.5};
                const double radius = sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]);
                const double wave = 0.75 + 0.25 * sin(14 * at[0]) * cos(11 * at[1]);
                const double value = (1.2 - 2.6 * radius) * wave + 0.02 * random_signed(&r);
                samples[support_index(&volume, x, y, z)] = fmin(fmax(value, 0), 1);
            }
    cvol_array *array;
    const cvol_compress_options options = cvol_compress_options_defaults();
    check_ok(cvol_compress(context, &array, NULL, samples, &volume.grid, &options));
    free(samples);
    return array;
}

/* The same terms, and another offset. */
static cvol_array *move(const cvol_array *array, double offset)
{
    cvol_array *out;
    check_ok(cvol_array_scale(context, &out, 1, array, offset));
    check_ok(cvol_array_set_type(context, out, CVOL_FLOAT64));
    return out;
}

/* A picture with the defaults of the command: the frame, the transfer function and the light of a
 * studio. */
static cvol_image *draw(const cvol_array *array, cvol_mode mode, double offset, int has_window)
{
    cvol_render_options options = support_square(160, mode, 35, 25);
    const cvol_source source = {.size = sizeof source, .array = array};
    cvol_histogram histogram;
    cvol_transfer *fitted, *transfer;
    cvol_renderer *renderer;
    const double window[2] = {offset, offset + 1};
    check_ok(cvol_array_compute_histogram(context, &histogram, array));
    check_ok(cvol_transfer_create_named(context, &fitted, "auto", &histogram));
    check_ok(
        cvol_transfer_create_adjusted(context, &transfer, fitted, has_window ? window : NULL, 1));
    check_ok(cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, &source));
    check_ok(cvol_renderer_set_transfer(context, renderer, transfer));
    options.surface.value = offset + 0.4;
    options.window[0] = window[0];
    options.window[1] = window[1];
    options.shading.on = 1;
    options.illumination.occlusion = 0.7;
    options.illumination.shadows = 0.8;
    options.illumination.keeps_brightness = 1;
    check_ok(cvol_camera_fit(context, &options, &source, transfer, 1));
    cvol_image *image = support_picture(context, renderer, &options);
    cvol_renderer_free(renderer);
    cvol_transfer_free(transfer);
    cvol_transfer_free(fitted);
    return image;
}

static void test_constants_do_not_change_pictures(void **state)
{
    (void)state;
    static const cvol_mode modes[] = {CVOL_MODE_COMPOSITE, CVOL_MODE_ISO, CVOL_MODE_XRAY,
                                      CVOL_MODE_MIP, CVOL_MODE_MIN};
    static const double offsets[] = {-0x1p10, 0x1p17, 0x1p30};
    cvol_array *plain = make_array();
    for (size_t k = 0; k < sizeof offsets / sizeof *offsets; k++) {
        cvol_array *array = move(plain, offsets[k]);
        for (size_t m = 0; m < 6; m++) {
            const cvol_mode mode = modes[m % 5];
            cvol_image *expected = draw(plain, mode, 0, m == 5),
                       *image = draw(array, mode, offsets[k], m == 5);
            const int off = support_difference(image, expected);
            const double db = support_psnr(image, expected);
            if (test_verbose() || off > 1 || db < 80)
                print_message("offset %g, mode %d: off by %d, %.1f dB\n", offsets[k], (int)mode,
                              off, db);
            assert_true(off <= 1 && db >= 80);
            cvol_image_free(image);
            cvol_image_free(expected);
        }
        cvol_array_free(array);
    }
    cvol_array_free(plain);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test_setup_teardown(
        test_constants_do_not_change_pictures, context_setup, context_teardown)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
