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

typedef struct picture {
    cvol_engine engine;
    cvol_mode mode;
    int has_window;
    int is_dense; /* of the decoded samples */
} picture;

static const picture pictures[] = {{CVOL_ENGINE_SHEET, CVOL_MODE_COMPOSITE, 0, 0},
                                   {CVOL_ENGINE_SHEET, CVOL_MODE_COMPOSITE, 1, 0},
                                   {CVOL_ENGINE_SHEET, CVOL_MODE_ISO, 0, 0},
                                   {CVOL_ENGINE_SHEET, CVOL_MODE_XRAY, 1, 0},
                                   {CVOL_ENGINE_SHEET, CVOL_MODE_MIP, 1, 0},
                                   {CVOL_ENGINE_SHEET, CVOL_MODE_MIN, 1, 0},
                                   {CVOL_ENGINE_SPLAT, CVOL_MODE_COMPOSITE, 0, 0},
                                   {CVOL_ENGINE_SPLAT, CVOL_MODE_COMPOSITE, 0, 1},
                                   {CVOL_ENGINE_TRANSFORM, CVOL_MODE_COMPOSITE, 0, 0},
                                   {CVOL_ENGINE_FOURIER, CVOL_MODE_XRAY, 0, 0},
                                   {CVOL_ENGINE_FOURIER, CVOL_MODE_XRAY, 1, 1}};

static cvol_volume *decode(const cvol_array *array)
{
    static const size_t zero[3] = {0, 0, 0};
    cvol_volume *volume;
    check_ok(cvol_volume_create(context, &volume, cvol_array_grid(array)));
    check_ok(cvol_array_evaluate_box(context, volume->data, array, zero, volume->grid.dims));
    return volume;
}

/* A picture, with the frame, the transfer function and the light that the command chooses. */
static cvol_image *draw(const cvol_array *array, const picture *of, double offset)
{
    cvol_render_options options = support_square(160, of->mode, 35, 25);
    cvol_volume *volume = of->is_dense ? decode(array) : NULL;
    const cvol_source source = {
        .size = sizeof source, .array = volume ? NULL : array, .volume = volume};
    const double window[2] = {offset, offset + 1};
    cvol_histogram histogram;
    cvol_transfer *fitted, *transfer;
    cvol_renderer *renderer;
    check_ok(cvol_array_compute_histogram(context, &histogram, array));
    check_ok(cvol_transfer_create_named(context, &fitted, "auto", &histogram));
    check_ok(cvol_transfer_create_adjusted(context, &transfer, fitted,
                                           of->has_window ? window : NULL, 1));
    check_ok(cvol_renderer_create(context, &renderer, of->engine, &source));
    if (of->engine != CVOL_ENGINE_FOURIER)
        check_ok(cvol_renderer_set_transfer(context, renderer, transfer));
    options.surface.value = offset + 0.4;
    if (of->has_window)
        memcpy(options.window, window, sizeof window);
    options.shading.on = of->engine != CVOL_ENGINE_FOURIER;
    if (of->engine == CVOL_ENGINE_SHEET) {
        options.illumination.occlusion = 0.7;
        options.illumination.shadows = 0.8;
        options.illumination.keeps_brightness = 1;
    }
    check_ok(cvol_camera_fit(context, &options, &source, transfer, 1));
    cvol_image *image = support_picture(context, renderer, &options);
    cvol_renderer_free(renderer);
    cvol_transfer_free(transfer);
    cvol_transfer_free(fitted);
    cvol_volume_free(volume);
    return image;
}

static void test_constants_do_not_change_pictures(void **state)
{
    (void)state;
    static const double offsets[] = {-0x1p10, 0x1p17, 0x1p30};
    cvol_array *plain = make_array();
    for (size_t k = 0; k < sizeof offsets / sizeof *offsets; k++) {
        cvol_array *array = move(plain, offsets[k]);
        for (size_t i = 0; i < sizeof pictures / sizeof *pictures; i++) {
            cvol_image *expected = draw(plain, &pictures[i], 0),
                       *image = draw(array, &pictures[i], offsets[k]);
            const int off = support_difference(image, expected);
            const double db = support_psnr(image, expected);
            if (test_verbose() || off > 1 || db < 75)
                print_message("offset %g, picture %zu: off by %d, %.1f dB\n", offsets[k], i, off,
                              db);
            assert_true(off <= 1 && db >= 75);
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
