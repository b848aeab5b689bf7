/* Surfaces that a clip, or a face of the volume, cuts: the cut shows the values there. */
#include "test.h"

#include "cvol/look.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

#define SIDE 32
#define SIZE 64

/* Above the surface's value everywhere; brighter to the right, with noise. */
static cvol_volume make_ramp(void)
{
    random_state r = {21};
    cvol_volume volume = support_volume(SIDE, SIDE, SIDE, CVOL_FLOAT32);
    for (size_t i = 0; i < cvol_grid_samples(&volume.grid); i++)
        ((float *)volume.data)[i] = (float)(100 + 3 * (double)(i % SIDE) + random_signed(&r));
    return volume;
}

static const double colour[3] = {1, 0.8, 0.5};

static cvol_render_options request(double azimuth, double elevation)
{
    cvol_render_options options = support_square(SIZE, CVOL_MODE_ISO, azimuth, elevation);
    options.surface.value = 50;
    for (int c = 0; c < 3; c++)
        options.surface.colour[c] = colour[c];
    options.window[0] = 90;
    options.window[1] = 210;
    return options;
}

static cvol_image *draw(const cvol_volume *volume, const cvol_array *array, int engine,
                        const cvol_render_options *options)
{
    cvol_renderer *renderer;
    cvol_image *image;
    const cvol_source source = {
        .size = sizeof source, .array = engine ? NULL : array, .volume = engine ? volume : NULL};
    assert_int_equal(cvol_renderer_create(context, &renderer,
                                          engine ? CVOL_ENGINE_RAY : CVOL_ENGINE_SHEET, &source),
                     CVOL_OK);
    image = support_picture(context, renderer, options);
    cvol_renderer_free(renderer);
    return image;
}

/* From the front: the column of a pixel gives its value, but for noise (8 of 255). */
static void test_values(void **state)
{
    (void)state;
    cvol_volume volume = make_ramp();
    cvol_array *array = support_compress(context, &volume, 16, 90);
    for (int engine = 0; engine < 2; engine++)
        for (int clipped = 0; clipped < 2; clipped++) {
            cvol_render_options options = request(0, 0);
            if (clipped)
                options.clip = (cvol_clip){.axes = 2, .from = {0, 11, 0}, .to = {0, SIDE, 0}};
            cvol_image *image = draw(&volume, array, engine, &options);
            const double pixel = sqrt(3) * SIDE / SIZE; /* in samples */
            for (int i = 20; i < SIZE - 20; i++)
                for (int c = 0; c < 3; c++) {
                    const double x = (i + 0.5 - SIZE / 2.0) * pixel + (SIDE - 1) / 2.0;
                    const double level = (100 + 3 * x - 90) / 120;
                    const int is = image->rgba[4 * (SIZE / 2 * SIZE + i) + c];
                    if (fabs(is - 255 * level * colour[c]) > 8)
                        fail_msg("engine %d, clip %d, pixel %d, channel %d: %d for %.1f", engine,
                                 clipped, i, c, is, 255 * level * colour[c]);
                }
            cvol_image_free(image);
        }
    cvol_array_free(array);
    free(volume.data);
}

/* Both engines from other angles, and with oblique planes. */
static void test_engines_agree(void **state)
{
    (void)state;
    cvol_volume volume = make_ramp();
    cvol_array *array = support_compress(context, &volume, 16, 90);
    for (int k = 0; k < 6; k++) {
        cvol_render_options options = request(30 + 50 * k, 20 * k - 45);
        if (k % 3)
            options.clip = (cvol_clip){.planes = 1, .plane = {{1, -1 + k / 3, 0.5, 1}}};
        options.camera.fov_deg = k == 5 ? 40 : 0;
        cvol_image *images[2];
        for (int engine = 0; engine < 2; engine++)
            images[engine] = draw(&volume, array, engine, &options);
        const double db = support_psnr(images[0], images[1]);
        if (test_verbose() || db < 30)
            print_message("view %d: %.1f dB\n", k, db);
        assert_true(db >= 30);
        cvol_image_free(images[0]);
        cvol_image_free(images[1]);
    }
    cvol_array_free(array);
    free(volume.data);
}

/* Without a window, the least sample is black and the largest white; a volume of one value is
 * white. A window must be one. */
static void test_windows(void **state)
{
    (void)state;
    cvol_volume volume = make_ramp();
    cvol_array *array = support_compress(context, &volume, 16, 90);
    cvol_render_options options = request(0, 0);
    options.window[0] = options.window[1] = 0;
    for (int engine = 0; engine < 2; engine++) {
        cvol_image *image = draw(&volume, array, engine, &options);
        int least = 255, most = 0;
        for (int i = 16; i < SIZE - 16; i++) {
            const int is = image->rgba[4 * (SIZE / 2 * SIZE + i)];
            least = is < least ? is : least;
            most = is > most ? is : most;
        }
        assert_true(least < 40 && most > 215);
        cvol_image_free(image);
    }
    cvol_renderer *renderer;
    cvol_image *image;
    options.window[0] = 5;
    options.window[1] = 4;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    assert_int_equal(cvol_image_create(context, &image, SIZE, SIZE), CVOL_OK);
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "the second larger"));
    cvol_image_free(image);
    cvol_renderer_free(renderer);
    cvol_array_free(array);
    for (size_t i = 0; i < cvol_grid_samples(&volume.grid); i++)
        ((float *)volume.data)[i] = 70;
    options.window[0] = options.window[1] = 0;
    image = draw(&volume, NULL, 1, &options);
    assert_int_equal(image->rgba[4 * (SIZE / 2 * SIZE + SIZE / 2)], 255);
    cvol_image_free(image);
    free(volume.data);
}

/* Matter that is the same everywhere, but for noise, next to air. */
static cvol_volume make_noise(size_t slices)
{
    random_state r = {5};
    cvol_volume volume = support_volume(SIDE, SIDE, slices, CVOL_FLOAT32);
    for (size_t i = 0; i < cvol_grid_samples(&volume.grid); i++)
        ((float *)volume.data)[i] = i % SIDE > SIDE - 4 ? 0 : (float)(100 + 2 * random_signed(&r));
    return volume;
}

/* The standard deviation of the middle of a picture. */
static double find_deviation(const cvol_image *image)
{
    double sum = 0, squares = 0, count = 0;
    for (int j = 20; j < SIZE - 20; j++)
        for (int i = 20; i < SIZE - 20; i++) {
            const double is = image->rgba[4 * (j * SIZE + i)];
            sum += is;
            squares += is * is;
            count++;
        }
    return sqrt(fmax(squares / count - sum * sum / (count * count), 0));
}

/* Pictures of matter by both engines deviate at most so much. */
static void expect_smooth(const cvol_volume *volume, const cvol_array *array,
                          const cvol_render_options *options, int number, double most)
{
    static const cvol_transfer_point opaque[] = {{40, 0.6, 0.6, 0.6, 0}, {90, 0.6, 0.6, 0.6, 0.8}};
    cvol_image *images[2] = {support_sheet(context, array, opaque, 2, options),
                             support_ray(context, volume, opaque, 2, options)};
    for (int engine = 0; engine < 2; engine++) {
        const double deviation = find_deviation(images[engine]);
        if (test_verbose() || deviation > most)
            print_message("picture %d, engine %d: %.1f\n", number, engine, deviation);
        assert_true(deviation <= most);
        cvol_image_free(images[engine]);
    }
}

/* A composite with light: a cut shows its matter, not the light of the noise within it (deviations
 * of 15 to 23 without the fade). */
static void test_light(void **state)
{
    (void)state;
    cvol_volume volume = make_noise(SIDE);
    cvol_array *array = support_compress(context, &volume, 16, 60);
    for (int k = 0; k < 6; k++) {
        cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, 20, 10);
        options.shading.on = 1;
        options.camera.zoom = 1.5;
        options.sheet.ray_order = k % 2 ? CVOL_RAY_ORDER_OBJECT : CVOL_RAY_ORDER_IMAGE;
        if (k < 2)
            options.clip = (cvol_clip){.axes = 2, .from = {0, 11.3, 0}, .to = {0, SIDE, 0}};
        else
            options.clip = (cvol_clip){.planes = 1, .plane = {{0.2, 1, -0.1, -2}}};
        options.camera.fov_deg = k >= 4 ? 30 : 0;
        expect_smooth(&volume, array, &options, k, 13);
    }
    cvol_array_free(array);
    free(volume.data);
}

/* The large faces of a slab are cuts, also of a single slice (deviations without the fade: 13.5 for
 * one slice, 19 to 24 for more). */
static void test_slabs(void **state)
{
    (void)state;
    static const size_t slices[] = {1, 2, 5, 10};
    static const double mosts[] = {10, 8, 15, 15};
    for (int k = 0; k < 8; k++) {
        cvol_volume volume = make_noise(slices[k / 2]);
        cvol_array *array = support_compress(context, &volume, 16, 60);
        cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, 20, 60);
        options.shading.on = 1;
        options.camera.zoom = 1.5;
        options.sheet.ray_order = k % 2 ? CVOL_RAY_ORDER_OBJECT : CVOL_RAY_ORDER_IMAGE;
        expect_smooth(&volume, array, &options, k, mosts[k / 2]);
        cvol_array_free(array);
        free(volume.data);
    }
}

/* In studio light, the faces of a volume that is full of matter are cuts (deviations of 21 to 32
 * without the fade). */
static void test_full_volume(void **state)
{
    (void)state;
    cvol_volume volume = make_noise(SIDE);
    cvol_array *array = support_compress(context, &volume, 16, 60);
    for (int k = 0; k < 3; k++) {
        cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, 5, 5);
        cvol_render_options_set_studio(&options);
        options.camera.zoom = 1.5;
        options.camera.fov_deg = k == 2 ? 30 : 0;
        options.sheet.ray_order = k == 1 ? CVOL_RAY_ORDER_OBJECT : CVOL_RAY_ORDER_AUTO;
        expect_smooth(&volume, array, &options, k, 8);
    }
    cvol_array_free(array);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_values),  TEST(test_engines_agree),
                                       TEST(test_windows), TEST(test_light),
                                       TEST(test_slabs),   TEST(test_full_volume)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
