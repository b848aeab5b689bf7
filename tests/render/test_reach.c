/* Occlusion, shadows, fill light and exposure: engine sheet against engine ray, and both against
 * direct sums. */
#include "test.h"

#include <math.h>

#include "cvol/look.h"
#include "render/light/exposure.h"
#include "render/light/reach.h"
#include "render/light/sweep.h"
#include "render/view/camera.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

#define SIDE 64
#define SIZE 96

/* ---- sweeps ------------------------------------------------------------------------------ */

typedef struct all_depths {
    float *depths;
} all_depths;

static void keep_depths(void *user, const float *depths, size_t first, size_t count, size_t stride)
{
    const all_depths *all = user;
    for (size_t i = 0; i < count; i++)
        all->depths[first + i * stride] = depths[i];
}

static void make_coarse(cvol_coarse *coarse, float *extinction, float *depths)
{
    *coarse = (cvol_coarse){.dims = {20, 18, 16}, .pitch = {4, 4, 4}, .length = {4, 4, 8}};
    for (size_t i = 0; i < cvol_coarse_count(coarse); i++)
        extinction[i] = depths[i] = 0;
}

/* Along each half of each axis: a plate of two cells lies before what is behind it. */
static void test_plate(void **state)
{
    (void)state;
    static float extinction[20 * 18 * 16], depths[20 * 18 * 16];
    for (int k = 0; k < 6; k++) {
        cvol_coarse coarse;
        const int axis = k / 2, way = k % 2 ? 1 : -1;
        make_coarse(&coarse, extinction, depths);
        const size_t *n = coarse.dims;
        for (size_t i = 0; i < cvol_coarse_count(&coarse); i++) {
            const size_t cell[3] = {i % n[0], i / n[0] % n[1], i / n[0] / n[1]};
            extinction[i] = cell[axis] == 3 || cell[axis] == 4 ? 0.25f : 0;
        }
        cvol_sweep sweep = {.keep = 1};
        sweep.way[axis] = way * 3.0;
        assert_int_equal(cvol_sweep_run(context, &coarse, extinction, &sweep, keep_depths,
                                        &(all_depths){depths}),
                         CVOL_OK);
        for (size_t i = 0; i < cvol_coarse_count(&coarse); i++) {
            const size_t cell[3] = {i % n[0], i / n[0] % n[1], i / n[0] / n[1]};
            const int at = (int)cell[axis], before = way > 0 ? 4 - at : at - 3;
            int inside = before < 5; /* light comes in from the edges */
            for (int b = 1; b < 3; b++)
                inside &= cell[(axis + b) % 3] > 4 && cell[(axis + b) % 3] + 5 < n[(axis + b) % 3];
            const double plates = before < 0 ? 0 : before > 2 ? 2 : before;
            if (inside)
                assert_true(fabs((double)depths[i] - 0.25 * coarse.length[axis] * plates) < 1e-5);
        }
    }
}

/* Obliquely, far from the edges: the way through a plate is longer by 1 / cosine. */
static void test_oblique(void **state)
{
    (void)state;
    const size_t n = 40;
    cvol_coarse coarse = {.dims = {n, n, n}, .pitch = {2, 2, 2}, .length = {2, 2, 2}};
    float *extinction = calloc(n * n * n, sizeof *extinction), *depths = calloc(n * n * n, 4);
    for (size_t i = 0; i < n * n; i++)
        extinction[i + n * n * 30] = 0.5f;
    cvol_sweep sweep = {.way = {0.6, -0.3, 1}, .keep = 1};
    assert_int_equal(
        cvol_sweep_run(context, &coarse, extinction, &sweep, keep_depths, &(all_depths){depths}),
        CVOL_OK);
    const double longer = sqrt(1 + 0.36 + 0.09);
    assert_true(fabs((double)depths[18 + n * (20 + n * 26)] - 0.5 * 2 * longer) < 1e-4);
    assert_true(fabs((double)depths[18 + n * (20 + n * 31)]) < 1e-6);
    for (int k = 0; k <= 60; k++)
        assert_true(fabs((double)cvol_sweep_transmittance(0.1f * (float)k) - exp(-0.1 * k)) < 0.02);
    free(extinction);
    free(depths);
}

/* ---- pictures ---------------------------------------------------------------------------- */

static const cvol_transfer_point points[] = {{18, 0.2, 0.3, 0.7, 0},
                                             {30, 0.9, 0.6, 0.4, 0.25},
                                             {60, 0.9, 0.85, 0.7, 0.6},
                                             {90, 0.95, 0.95, 0.9, 0.8}};
#define POINTS (sizeof points / sizeof *points)

static cvol_render_options studio(double azimuth, double elevation)
{
    cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, azimuth, elevation);
    cvol_render_options_set_studio(&options);
    options.camera.zoom = 1.6;
    return options;
}

/* Both engines find the light from different low resolutions, of decoded and of original samples.
 * Without factors of light the pictures differ by 30 to 38 dB less. */
static void test_engines(void **state)
{
    (void)state;
    static const double views[][2] = {{20, 15}, {110, -30}, {200, 40},
                                      {290, 5}, {30, 75},   {75, -80}};
    cvol_volume volume = support_blobs(SIDE, SIDE - 6, SIDE - 11);
    cvol_array *array = support_compress(context, &volume, 16, 75);
    for (size_t k = 0; k < sizeof views / sizeof *views; k++)
        for (int order = CVOL_RAY_ORDER_IMAGE; order <= CVOL_RAY_ORDER_OBJECT; order++) {
            cvol_render_options options = studio(views[k][0], views[k][1]);
            options.sheet.ray_order = (cvol_ray_order)order;
            const double db = support_sheet_db(context, array, &volume, points, POINTS, options);
            options.illumination = (cvol_illumination){0};
            if (test_verbose())
                print_message("view %zu, order %d: %.1f dB, %.1f dB without factors\n", k, order,
                              db,
                              support_sheet_db(context, array, &volume, points, POINTS, options));
            assert_true(db > (order == CVOL_RAY_ORDER_IMAGE ? 38 : 33));
        }
    cvol_array_free(array);
    free(volume.data);
}

/* Clips, perspective, surfaces, and a mask. */
static void test_kinds(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(SIDE, SIDE, SIDE);
    cvol_array *array = support_compress(context, &volume, 16, 75);
    cvol_render_options options = studio(35, 25);
    options.clip = (cvol_clip){.axes = 2, .from = {0, 24, 0}, .to = {0, SIDE, 0}};
    assert_true(support_sheet_db(context, array, &volume, points, POINTS, options) > 36);
    options = studio(35, 25);
    options.camera.fov_deg = 50;
    assert_true(support_sheet_db(context, array, &volume, points, POINTS, options) > 33);
    options = studio(35, 25);
    options.mode = CVOL_MODE_ISO;
    options.surface.value = 30;
    options.oversample = 1;
    const double surface = support_sheet_db(context, array, &volume, NULL, 0, options);
    if (test_verbose())
        print_message("surface: %.1f dB\n", surface);
    options.illumination = (cvol_illumination){0};
    if (test_verbose())
        print_message("surface without factors: %.1f dB\n",
                      support_sheet_db(context, array, &volume, NULL, 0, options));
    assert_true(surface > 27);
    cvol_array_free(array);
    free(volume.data);
}

static double mean_of(const cvol_image *image)
{
    double sum = 0;
    for (int i = 0; i < image->width * image->height; i++)
        for (int c = 0; c < 3; c++)
            sum += image->rgba[4 * i + c];
    return sum / (3.0 * image->width * image->height);
}

/* Studio light keeps the brightness; occlusion and shadows alone darken. */
static void test_brightness(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(SIDE, SIDE, SIDE);
    cvol_array *array = support_compress(context, &volume, 16, 75);
    for (int k = 0; k < 4; k++) {
        cvol_render_options options = studio(90 * k + 20, 20), unlit = options, darker = options;
        unlit.shading.on = 0;
        darker.illumination.keeps_brightness = 0;
        cvol_render_options open = darker;
        open.illumination.occlusion = open.illumination.shadows = 0;
        cvol_image *images[4];
        const cvol_render_options *all[4] = {&options, &unlit, &darker, &open};
        for (int i = 0; i < 4; i++)
            images[i] = support_sheet(context, array, points, POINTS, all[i]);
        if (test_verbose())
            print_message("mean: %.1f lit, %.1f unlit, %.1f darker, %.1f open\n",
                          mean_of(images[0]), mean_of(images[1]), mean_of(images[2]),
                          mean_of(images[3]));
        assert_true(mean_of(images[0]) > 0.87 * mean_of(images[1]));
        assert_true(mean_of(images[0]) < 1.1 * mean_of(images[1]));
        assert_true(mean_of(images[2]) < 0.9 * mean_of(images[3]));
        for (int i = 0; i < 4; i++)
            cvol_image_free(images[i]);
    }
    cvol_array_free(array);
    free(volume.data);
}

/* A ball: light in the view turns with the eye, light in the world does not. In mirrored pictures
 * it comes from the same side. */
static void test_in_view(void **state)
{
    (void)state;
    cvol_volume volume = support_volume(33, 33, 33, CVOL_FLOAT32);
    for (size_t z = 0; z < 33; z++)
        for (size_t y = 0; y < 33; y++)
            for (size_t x = 0; x < 33; x++)
                ((float *)volume.data)[support_index(&volume, x, y, z)] =
                    (float)(100 - 5 * sqrt(pow((double)x - 16, 2) + pow((double)y - 16, 2) +
                                           pow((double)z - 16, 2)));
    cvol_render_options options = studio(0, 0), other = studio(90, 0), mirrored = studio(0, 0);
    mirrored.illumination.in_view = -1;
    cvol_image *a = support_ray(context, &volume, points, POINTS, &options),
               *b = support_ray(context, &volume, points, POINTS, &other),
               *c = support_ray(context, &volume, points, POINTS, &mirrored);
    assert_true(support_psnr(a, b) > 45);
    assert_true(support_psnr(a, c) < 30);
    cvol_image_mirror(c);
    assert_true(support_psnr(a, c) > 45);
    /* Brighter on the upper left. */
    assert_true(support_pixel(a, SIZE / 2 - 12, SIZE / 2 - 12)[0] >
                support_pixel(a, SIZE / 2 + 12, SIZE / 2 + 12)[0] + 40);
    cvol_image_free(a);
    cvol_image_free(b);
    cvol_image_free(c);
    free(volume.data);
}

/* ---- refusals ---------------------------------------------------------------------------- */

static void test_refusals(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(20, 20, 20);
    cvol_image *image, *upper;
    cvol_renderer *renderer;
    cvol_render_options options = studio(0, 0);
    options.illumination.in_view = 0;
    assert_int_equal(cvol_image_create(context, &image, SIZE, SIZE), CVOL_OK);
    assert_int_equal(cvol_image_create(context, &upper, SIZE, SIZE), CVOL_OK);
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SPLAT, CVOL_SOURCE(.volume = &volume)),
        CVOL_OK);
    support_set_transfer(context, renderer, points, POINTS);
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "shadows"));
    cvol_renderer_free(renderer);
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_RAY, CVOL_SOURCE(.volume = &volume)),
        CVOL_OK);
    support_set_transfer(context, renderer, points, POINTS);
    assert_int_equal(cvol_renderer_certify(context, renderer, image, upper, &options, 0.1, NULL),
                     CVOL_ERROR_UNSUPPORTED);
    double *const numbers[] = {&options.illumination.fill, &options.illumination.occlusion,
                               &options.illumination.shadows};
    static const char *const names[] = {"fill", "occlusion", "shadows"};
    for (int k = 0; k < 3; k++)
        for (int way = 0; way < 3; way++) {
            const double kept = *numbers[k];
            *numbers[k] = way == 0 ? -0.1 : way == 1 ? 10.5 : NAN;
            assert_int_equal(cvol_renderer_render(context, renderer, image, &options),
                             CVOL_ERROR_ARGUMENT);
            assert_non_null(strstr(cvol_context_message(context), names[k]));
            *numbers[k] = kept;
        }
    cvol_renderer_free(renderer);
    cvol_image_free(image);
    cvol_image_free(upper);
    free(volume.data);
}

/* A row of cells side by side, of which more and more are bright: the exposure has no steps, which
 * would be a flicker while a volume turns. */
static void test_exposure_without_steps(void **state)
{
    (void)state;
    enum { CELLS = 200 };
    const cvol_grid grid = {.dims = {2 * CELLS, 2, 2}, .spacing = {1, 1, 1}};
    cvol_coarse coarse = {.dims = {CELLS, 1, 1}, .pitch = {2, 2, 2}, .length = {2, 2, 2}};
    float extinction[CELLS], factors[CELLS], values[CELLS] = {0};
    cvol_render_options options = cvol_render_options_defaults();
    cvol_view view;
    double exposure[CELLS + 1];
    cvol_render_options_set_studio(&options);
    options.mode = CVOL_MODE_ISO;
    for (int a = 0; a < 3; a++)
        options.surface.colour[a] = 1, options.shading.light[a] = 0;
    assert_int_equal(cvol_view_make(context, &view, &grid, &options), CVOL_OK);
    coarse.values = values;
    for (int bright = 0; bright <= CELLS; bright++) {
        for (int i = 0; i < CELLS; i++) {
            extinction[i] = 1;
            factors[i] = (float)(0.5 + 0.5 * fmin(fmax((bright - i) / 40.0, 0), 1));
        }
        assert_int_equal(cvol_exposure_find(context, &exposure[bright],
                                            &(cvol_lit_cells){&coarse, extinction, factors}, &grid,
                                            NULL, &view, &options),
                         CVOL_OK);
        if (bright)
            assert_true(fabs(exposure[bright] / exposure[bright - 1] - 1) < 0.03);
    }
    assert_true(exposure[CELLS / 2] < 0.8 * exposure[0]);
}

/* Opaque balls, lit from the side: where the longest axis of the way to the eye changes, the
 * exposure does not jump. */
static void test_exposure_at_diagonals(void **state)
{
    (void)state;
    enum { CELLS = 24 };
    const cvol_grid grid = {.dims = {2 * CELLS, 2 * CELLS, 2 * CELLS}, .spacing = {1, 1, 1}};
    cvol_coarse coarse = {.dims = {CELLS, CELLS, CELLS}, .pitch = {2, 2, 2}, .length = {2, 2, 2}};
    const size_t count = cvol_coarse_count(&coarse);
    float *extinction = calloc(count, sizeof *extinction),
          *factors = calloc(count, sizeof *factors);
    coarse.values = calloc(count, sizeof *coarse.values);
    for (size_t i = 0; i < count; i++) {
        const double x = (double)(i % CELLS), y = (double)(i / CELLS % CELLS),
                     z = (double)(i / CELLS / CELLS);
        const double ball = fmin(hypot(hypot(x - 7, y - 8), z - 12),
                                 hypot(hypot(x - 17, y - 14), z - 11));
        extinction[i] = ball < 5 ? 3 : 0;
        factors[i] = (float)(0.4 + 0.6 * (x + z) / (2 * CELLS));
    }
    for (int k = 0; k < 4; k++) {
        cvol_render_options options = cvol_render_options_defaults();
        double exposure[2];
        cvol_render_options_set_studio(&options);
        options.mode = CVOL_MODE_ISO;
        options.camera.elevation_deg = 10;
        for (int side = 0; side < 2; side++) {
            cvol_view view;
            options.camera.azimuth_deg = 45 + 90 * k + (side ? 0.01 : -0.01);
            assert_int_equal(cvol_view_make(context, &view, &grid, &options), CVOL_OK);
            assert_int_equal(cvol_exposure_find(context, &exposure[side],
                                                &(cvol_lit_cells){&coarse, extinction, factors},
                                                &grid, NULL, &view, &options),
                             CVOL_OK);
        }
        if (test_verbose())
            print_message("%d: %.4f %.4f\n", k, exposure[0], exposure[1]);
        assert_true(fabs(exposure[1] / exposure[0] - 1) < 0.002);
    }
    free(coarse.values);
    free(extinction);
    free(factors);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_plate),
        TEST(test_oblique),
        TEST(test_engines),
        TEST(test_kinds),
        TEST(test_brightness),
        TEST(test_in_view),
        TEST(test_refusals),
        TEST(test_exposure_without_steps),
        TEST(test_exposure_at_diagonals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
