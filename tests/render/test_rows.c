/* Pictures in strips: the rows of cvol_rows are those of the whole picture. CVOL_TEST_VERBOSE=1
 * prints the differences.
 */
#include "test.h"

#include "support.h"
#include "support_context.h"
#include "support_render.h"

enum { WIDTH = 70, HEIGHT = 90, CUTS = 4 };

/* Draws the picture in strips and returns the largest difference from the whole. */
static int find_difference(cvol_renderer *renderer, const cvol_render_options *options)
{
    static const int cut[CUTS] = {0, 12, 58, HEIGHT};
    cvol_image *whole = support_picture(context, renderer, options);
    int most = 0;
    for (int k = 0; k + 1 < CUTS; k++) {
        cvol_render_options strip = *options;
        strip.rows = (cvol_rows){cut[k], HEIGHT};
        strip.height = cut[k + 1] - cut[k];
        cvol_image *part = support_picture(context, renderer, &strip);
        cvol_image rows = *whole;
        rows.height = strip.height;
        rows.rgba += 4 * (size_t)WIDTH * (size_t)cut[k];
        const int difference = support_difference(&rows, part);
        most = difference > most ? difference : most;
        cvol_image_free(part);
    }
    cvol_image_free(whole);
    return most;
}

static cvol_render_options make_options(cvol_mode mode, int light, double azimuth, double elevation)
{
    cvol_render_options options = support_square(HEIGHT, mode, azimuth, elevation);
    options.width = WIDTH;
    options.camera.zoom = 2;
    options.surface.value = 50;
    options.shading.on = light;
    options.illumination.shadows = options.illumination.occlusion = 0.6 * light;
    return options;
}

static void check(cvol_renderer *renderer, const cvol_render_options *options, int most)
{
    const int difference = find_difference(renderer, options);
    if (test_verbose() || difference > most)
        print_message("mode %d, azimuth %g, light %d, field %g, order %d, level %d: %d\n",
                      (int)options->mode, options->camera.azimuth_deg, options->shading.on,
                      options->camera.fov_deg, (int)options->sheet.ray_order, options->level,
                      difference);
    assert_true(difference <= most);
}

static void test_engine_sheet(void **state)
{
    (void)state;
    static const double views[][3] = {{0, 0, 0}, {30, 20, 0}, {200, 60, 35}};
    cvol_volume volume = support_blobs(50, 40, 45);
    cvol_array *array = support_compress(context, &volume, 16, 60);
    cvol_renderer *renderer;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    support_set_transfer(context, renderer, support_blob_points, SUPPORT_BLOB_POINTS);
    for (size_t k = 0; k < sizeof views / sizeof *views; k++)
        for (int mode = CVOL_MODE_COMPOSITE; mode <= CVOL_MODE_ISO; mode++)
            for (int kind = 0; kind < 6; kind++) {
                cvol_render_options options = make_options((cvol_mode)mode, kind / 3, views[k][0],
                                                           views[k][1]);
                options.camera.roll_deg = views[k][2];
                if (kind % 3)
                    options.sheet.ray_order = CVOL_RAY_ORDER_OBJECT;
                options.level = kind % 3 == 2;
                check(renderer, &options, 1);
            }
    cvol_renderer_free(renderer);
    cvol_array_free(array);
    free(volume.data);
}

/* A plate seen across its edge: the samples of a band of rows are many, so the points between them
 * are as many as a frame may take. A strip has as many as the whole picture. */
static void test_points_of_a_plate(void **state)
{
    (void)state;
    static const double views[][2] = {{68, 29}, {254, 42}, {269, -24}, {251, -26}};
    cvol_volume volume = support_blobs(40, 400, 400);
    for (size_t i = 0; i < cvol_grid_samples(&volume.grid); i++) /* with detail between samples */
        ((float *)volume.data)[i] *= (i / 2 + i / 80 + i / 32000) % 2 ? 1.5f : 0.5f;
    cvol_array *array = support_compress(context, &volume, 16, 40);
    cvol_renderer *renderer;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    support_set_transfer(context, renderer, support_blob_points, SUPPORT_BLOB_POINTS);
    for (size_t k = 0; k < sizeof views / sizeof *views; k++) {
        const cvol_render_options options = make_options(CVOL_MODE_COMPOSITE, 0, views[k][0],
                                                         views[k][1]);
        check(renderer, &options, 1);
    }
    cvol_renderer_free(renderer);
    cvol_array_free(array);
    free(volume.data);
}

static void test_engine_ray(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(30, 20, 25);
    cvol_renderer *renderer;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_RAY, CVOL_SOURCE(.volume = &volume)),
        CVOL_OK);
    support_set_transfer(context, renderer, support_blob_points, SUPPORT_BLOB_POINTS);
    for (int perspective = 0; perspective < 2; perspective++) {
        cvol_render_options options = make_options(CVOL_MODE_COMPOSITE, 1, 30, 20);
        options.camera.fov_deg = 40 * perspective;
        check(renderer, &options, 1);
    }
    cvol_renderer_free(renderer);
    free(volume.data);
}

static void test_rows_outside_are_refused(void **state)
{
    (void)state;
    static const cvol_rows wrong[] = {{-1, HEIGHT}, {0, HEIGHT - 1}, {1, HEIGHT}, {0, -1}};
    cvol_volume volume = support_blobs(20, 20, 20);
    cvol_renderer *renderer;
    cvol_image *image;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_RAY, CVOL_SOURCE(.volume = &volume)),
        CVOL_OK);
    support_set_transfer(context, renderer, support_blob_points, SUPPORT_BLOB_POINTS);
    assert_int_equal(cvol_image_create(context, &image, WIDTH, HEIGHT), CVOL_OK);
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        cvol_render_options options = make_options(CVOL_MODE_COMPOSITE, 0, 0, 0);
        options.rows = wrong[k];
        assert_int_equal(cvol_renderer_render(context, renderer, image, &options),
                         CVOL_ERROR_ARGUMENT);
        assert_non_null(strstr(cvol_context_message(context), "rows"));
    }
    cvol_image_free(image);
    cvol_renderer_free(renderer);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_engine_sheet), TEST(test_points_of_a_plate),
                                       TEST(test_engine_ray), TEST(test_rows_outside_are_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
