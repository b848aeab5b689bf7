/* The sheet engine in image order: against the ray engine, from random directions, near and far,
 * rolled, clipped, lapped or not, and never much worse than object order; and options without
 * effect. The seed is printed. CVOL_TEST_VERBOSE=1 prints the measurements. */
#include "test.h"

#include "random.h"
#include "render/counters.h"
#include "render/sheet/frame/frame.h"
#include "support.h"
#include "support_context.h"
#include "support_lapped.h"
#include "support_render.h"

#define SEED 20261123

/* Three bodies of different detail; slices are `apart` times as far apart as the samples on
 * them. */
static cvol_volume make_volume(int kind, double apart)
{
    static const size_t shapes[3][3] = {{53, 47, 50}, {90, 33, 18}, {20, 70, 64}};
    const size_t *n = shapes[kind];
    cvol_volume volume = support_volume(n[0], n[1], n[2], CVOL_FLOAT32);
    volume.grid.spacing[2] = apart;
    for (size_t z = 0; z < n[2]; z++)
        for (size_t y = 0; y < n[1]; y++)
            for (size_t x = 0; x < n[0]; x++) {
                const double at[3] = {(double)x / (double)n[0] - 0.5,
                                      (double)y / (double)n[1] - 0.5,
                                      (double)z / (double)n[2] - 0.5};
                const double r = sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]);
                ((float *)volume.data)[support_index(&volume, x, y, z)] =
                    (float)(100 - 200 * r +
                            12 * sin(0.9 * (double)x) * cos(0.7 * (double)y + 0.3 * (double)z));
            }
    return volume;
}

static const cvol_transfer_point soft[] = {{30, 0.1, 0.2, 1, 0}, {80, 1, 0.6, 0.1, 0.3}};
static const cvol_transfer_point solid[] = {{38, 0.9, 0.5, 0.2, 0}, {46, 1, 0.9, 0.6, 0.9}};

static double between(double lo, double hi, random_state *r)
{
    return lo + (hi - lo) * (0.5 + 0.5 * random_signed(r));
}

/* Any camera; every third along an axis, for which lines and rows are parallel. */
static cvol_render_options make_options(int number, random_state *r)
{
    const double elevation = between(-90, 90, r), azimuth = between(0, 360, r);
    cvol_render_options options = support_square(72, CVOL_MODE_COMPOSITE, azimuth, elevation);
    options.height = 56 + (int)random_below(r, 60);
    options.camera.roll_deg = between(-180, 180, r);
    options.camera.zoom = exp(between(-0.7, 1.6, r));
    if (number % 3 == 2) {
        options.camera.azimuth_deg = 90 * (double)random_below(r, 4);
        options.camera.elevation_deg = 90 * ((double)random_below(r, 3) - 1);
        options.camera.roll_deg = 45 * (double)random_below(r, 8);
    }
    if (number % 4 == 3)
        options.clip = (cvol_clip){.planes = 1, .plane = {{0.6, -0.7, 0.4, -3}}};
    return options;
}

static double compare(const cvol_array *array, const cvol_volume *volume,
                      const cvol_transfer_point *points, cvol_render_options options,
                      cvol_ray_order rays)
{
    options.sheet.ray_order = rays;
    return support_sheet_db(context, array, volume, points, 2, options);
}

static cvol_array *make_array(const cvol_volume *volume, int lapped, uint64_t seed)
{
    if (!lapped)
        return support_compress(context, volume, 16, 80);
    cvol_array *array = support_lapped(context, volume->data, volume->grid.dims, 0, 0.005,
                                       (int)(seed % 2), seed);
    array->grid = volume->grid;
    return array;
}

static void test_close_to_rays(void **state)
{
    (void)state;
    int cases = 0, behind = 0;
    double gain = 0;
    print_message("seed %d\n", SEED);
    for (int k = 0; k < 48; k = support_next(k)) {
        random_state r = {SEED + (uint64_t)k}; /* for any number of omitted ones */
        cvol_volume volume = make_volume(k % 3, k % 2 ? 1.7 : 1);
        cvol_array *array = make_array(&volume, k / 3 % 2, (uint64_t)k);
        const cvol_transfer_point *points = k % 5 < 2 ? soft : solid;
        cvol_render_options options = make_options(k, &r);
        options.step_voxels = k % 7 < 4 ? 0.4 : 0;
        const double floor_db = options.step_voxels > 0 ? (points == soft ? 50 : 28)
                                                        : (points == soft ? 48 : 35);
        const double pixels = compare(array, &volume, points, options, CVOL_RAY_ORDER_IMAGE),
                     lattice = compare(array, &volume, points, options, CVOL_RAY_ORDER_OBJECT);
        const int good = pixels >= floor_db && pixels >= lattice - 3;
        if (test_verbose() || !good)
            print_message("%d, %s, step %g: %.2f dB, lattice %.2f\n", k,
                          points == soft ? "soft" : "solid", options.step_voxels, pixels, lattice);
        assert_true(good);
        cases++;
        behind += pixels < fmin(lattice, 53) - 1; /* single pixels of a silhouette differ as much */
        gain += pixels - lattice;
        cvol_array_free(array);
        free(volume.data);
    }
    print_message("%d cases, %d behind the lattice, %.2f dB nearer\n", cases, behind, gain / cases);
    assert_true(24 * behind <= cases && gain > 4 * cases);
}

/* With light, image order needs the widest vectors; otherwise both are drawn in object order, whose
 * figures the bounds are for. */
static void test_lit_close_to_rays(void **state)
{
    (void)state;
    int cases = 0, behind = 0, differ = 0;
    double gain = 0;
    for (int k = 0; k < 36; k = support_next(k)) {
        random_state r = {SEED + 300 + (uint64_t)k};
        cvol_volume volume = make_volume(k % 3, k % 2 ? 1.7 : 1);
        cvol_array *array = make_array(&volume, k / 3 % 2, (uint64_t)k);
        const cvol_transfer_point *points = k % 5 < 2 ? soft : solid;
        cvol_render_options options = make_options(k, &r);
        options.step_voxels = k % 7 < 2 ? 0.4 : 0;
        options.shading.on = 1;
        options.shading.shininess = k % 4 == 2 ? 20 : options.shading.shininess;
        options.shading.gradient_opacity = k % 5 == 3 ? 8 : 0;
        const double pixels = compare(array, &volume, points, options, CVOL_RAY_ORDER_IMAGE),
                     lattice = compare(array, &volume, points, options, CVOL_RAY_ORDER_OBJECT);
        const double floor_db = pixels == lattice ? (points == soft ? 40 : 25)
                                                  : (points == soft ? 44 : 35);
        const int good = pixels >= floor_db && pixels >= lattice - 3;
        if (test_verbose() || !good)
            print_message("lit %d, %s, step %g: %.2f dB, lattice %.2f\n", k,
                          points == soft ? "soft" : "solid", options.step_voxels, pixels, lattice);
        assert_true(good);
        cases++;
        differ += pixels != lattice;
        behind += pixels < lattice - 1;
        gain += pixels - lattice;
        cvol_array_free(array);
        free(volume.data);
    }
    print_message("lit: %d cases, %d behind the lattice, %.2f dB nearer\n", cases, behind,
                  gain / cases);
    assert_true(8 * behind <= cases && (!differ || gain > 2 * cases));
}

static void test_same_for_any_threads(void **state)
{
    (void)state;
    for (int k = 0; k < 16; k = support_next(k)) {
        random_state r = {SEED + 100 + (uint64_t)k};
        cvol_volume volume = make_volume(k % 3, 1.3);
        cvol_array *array = make_array(&volume, k % 2, (uint64_t)k);
        cvol_render_options options = make_options(k, &r);
        options.height = 300;
        options.step_voxels = k % 4 == 1 ? 0.5 : 0;
        options.shading.on = k % 4 > 1;
        cvol_context_set_threads(context, 1);
        cvol_image *one = support_sheet(context, array, solid, 2, &options);
        for (int threads = 2; threads <= 7; threads += 5) {
            cvol_context_set_threads(context, threads);
            cvol_image *more = support_sheet(context, array, solid, 2, &options);
            assert_memory_equal(one->rgba, more->rgba, (size_t)4 * 72 * 300);
            cvol_image_free(more);
        }
        cvol_image_free(one);
        cvol_array_free(array);
        free(volume.data);
    }
}

/* Requests that image-order rays cannot draw are drawn in object order, also if image order is
 * requested. */
static void test_object_order_is_unchanged(void **state)
{
    (void)state;
    cvol_volume volume = make_volume(0, 1);
    cvol_array *array = make_array(&volume, 1, 4);
    for (int kind = 0; kind < 6; kind++) {
        cvol_render_options options = support_square(64, CVOL_MODE_COMPOSITE, 33, 21);
        options.camera.fov_deg = kind == 1 ? 40 : 0;
        options.mode = kind == 0 ? CVOL_MODE_ISO : kind == 2 ? CVOL_MODE_MIP : CVOL_MODE_COMPOSITE;
        options.surface.value = 50;
        options.level = kind == 3;
        options.oversample = kind == 4 ? 1.5 : 0;
        options.sheet.footprint = kind == 5 ? CVOL_SHEET_CATMULL_ROM : CVOL_SHEET_LINEAR;
        cvol_image *pixels = support_sheet(context, array, soft, 2, &options);
        options.sheet.ray_order = CVOL_RAY_ORDER_OBJECT;
        cvol_image *lattice = support_sheet(context, array, soft, 2, &options);
        assert_int_equal(support_difference(pixels, lattice), 0);
        cvol_image_free(pixels);
        cvol_image_free(lattice);
    }
    cvol_render_options options = support_square(16, CVOL_MODE_COMPOSITE, 0, 0);
    cvol_renderer *renderer;
    cvol_image *image;
    assert_int_equal(cvol_image_create(context, &image, 16, 16), CVOL_OK);
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    support_set_transfer(context, renderer, soft, 2);
    options.sheet.ray_order = (cvol_ray_order)7;
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "ray order is 7"));
    cvol_renderer_free(renderer);
    cvol_image_free(image);
    cvol_array_free(array);
    free(volume.data);
}

/* Returns 1 if the engine's own choice gives the picture of image order. */
static int take_pixels(const cvol_array *array, const cvol_transfer_point *points,
                       cvol_render_options options)
{
    cvol_image *images[2];
    for (int rays = CVOL_RAY_ORDER_AUTO; rays <= CVOL_RAY_ORDER_IMAGE; rays++) {
        options.sheet.ray_order = (cvol_ray_order)rays;
        images[rays] = support_sheet(context, array, points, 2, &options);
    }
    const int are_pixels = support_difference(images[0], images[1]) == 0;
    for (int i = 0; i < 2; i++)
        cvol_image_free(images[i]);
    return are_pixels;
}

/* Composites go through the pixels, whatever the zoom and the array's error, except for translucent
 * functions, unlit, of arrays that are not nearly exact. */
static void test_automatic_order(void **state)
{
    (void)state;
    const cvol_transfer_point jump[] = {{50, 1, 1, 1, 0}, {50, 1, 1, 1, 0.4}};
    const cvol_transfer_point *const functions[] = {soft, solid, jump};
    cvol_volume volume = make_volume(0, 1);
    cvol_array *array = make_array(&volume, 0, 1);
    const double samples = (double)cvol_grid_samples(&array->grid);
    array->measured = 0; /* so that the error is the one set here, not that of the file */
    for (int azimuth = 10; azimuth < 360; azimuth += 35)
        for (int f = 0; f < 3; f++) {
            cvol_render_options options = support_square(72, CVOL_MODE_COMPOSITE, azimuth, 25);
            const int lit = azimuth / 5 % 2, distant = azimuth % 3 == 1;
            options.camera.zoom = azimuth % 3 == 0 ? 1 : distant ? 0.6 : 4;
            options.shading.on = lit;
            array->error_bound.l2_error = 0.5 * sqrt(samples);
            assert_int_equal(take_pixels(array, functions[f], options), f > 0 || lit || distant);
            array->error_bound.l2_error = 1e-4 * sqrt(samples);
            assert_true(take_pixels(array, functions[f], options));
        }
    array->error_bound.l2_error = 6 * sqrt(samples);
    assert_true(take_pixels(array, solid, support_square(72, CVOL_MODE_COMPOSITE, 10, 25)));
    cvol_array_free(array);
    free(volume.data);
}

/* From int16 if there are such kernels, and from floats, for which operations are counted. */
static void test_int16_blocks(void **state)
{
    (void)state;
    for (int k = 0; k < 24; k = support_next(k)) {
        random_state r = {SEED + 200 + (uint64_t)k};
        cvol_volume volume = make_volume(k % 3, 1);
        cvol_array *array = make_array(&volume, k % 2, (uint64_t)k);
        cvol_render_options options = make_options(k, &r);
        cvol_renderer *renderer;
        cvol_image *floats;
        uint64_t count;
        assert_int_equal(cvol_image_create(context, &floats, options.width, options.height),
                         CVOL_OK);
        assert_int_equal(cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET,
                                              CVOL_SOURCE(.array = array)),
                         CVOL_OK);
        support_set_transfer(context, renderer, k % 4 < 2 ? soft : solid, 2);
        assert_int_equal(
            cvol_renderer_sheet_multiply_adds(context, renderer, floats, &options, &count),
            CVOL_OK);
        cvol_image *words = support_picture(context, renderer, &options);
        const double db = support_psnr(words, floats);
        if (test_verbose() || db < 60)
            print_message("%d: %.2f dB, %d\n", k, db, support_difference(words, floats));
        assert_true(db >= 60);
        cvol_renderer_free(renderer);
        cvol_image_free(words);
        cvol_image_free(floats);
        cvol_array_free(array);
        free(volume.data);
    }
}

/* For any number of samples between pixels, and of pixels between samples. */
static void test_far_and_near(void **state)
{
    (void)state;
    static const double zooms[] = {1e-6, 1e-3, 0.01, 0.02, 0.1, 30, 1000};
    cvol_volume volume = make_volume(0, 1);
    cvol_array *array = make_array(&volume, 1, 8);
    for (size_t z = 0; z < sizeof zooms / sizeof *zooms; z++)
        for (int lines = 1; lines <= 40; lines += 39) {
            cvol_render_options options = support_square(40, CVOL_MODE_COMPOSITE, 40, 30);
            options.camera.roll_deg = 20;
            options.camera.zoom = zooms[z];
            options.height = lines;
            options.shading.on = lines > 1 && z % 2;
            cvol_image *image = support_sheet(context, array, solid, 2, &options);
            assert_true(zooms[z] > 0.03 || support_pixel(image, 0, 0)[0] == 0);
            assert_true(zooms[z] < 20 || support_pixel(image, 20, lines / 2)[0] > 0);
            cvol_image_free(image);
        }
    cvol_array_free(array);
    free(volume.data);
}

/* A volume that is bright along one edge: rays that pass it have a short way through it, and no
 * face makes it thicker. */
static void test_bright_edge(void **state)
{
    (void)state;
    static const cvol_transfer_point points[] = {{12, 0.35, 0.2, 0.45, 0},
                                                 {65, 0.9, 0.5, 0.4, 0.85}};
    cvol_volume volume = support_volume(40, 40, 20, CVOL_FLOAT32);
    for (size_t z = 0; z < 20; z++)
        ((float *)volume.data)[support_index(&volume, 39, 39, z)] = 63;
    cvol_array *array = support_compress(context, &volume, 16, 80);
    for (int azimuth = 15; azimuth < 360; azimuth += 90) {
        const cvol_render_options options = support_square(80, CVOL_MODE_COMPOSITE, azimuth, 20);
        const double db = compare(array, &volume, points, options, CVOL_RAY_ORDER_IMAGE);
        if (test_verbose() || !(db >= 50))
            print_message("edge, azimuth %d: %.2f dB\n", azimuth, db);
        assert_true(db >= 50);
    }
    cvol_array_free(array);
    free(volume.data);
}

/* Each pixel has its own place, and sixteen consecutive ones are a square. */
static void test_squares(void **state)
{
    (void)state;
    enum { WIDTH = 48, HEIGHT = 20, FLOATS = 5 };
    const cvol_intermediate image = {.width = WIDTH, .height = HEIGHT, .down = CVOL_SQUARE},
                            lines = {.width = WIDTH, .height = HEIGHT, .down = 1};
    static uint8_t taken[FLOATS * WIDTH * HEIGHT];
    for (long j = 0; j < HEIGHT; j++)
        for (long i = 0; i < WIDTH; i++) {
            for (int k = 0; k < FLOATS; k++) {
                const size_t at = cvol_pixel_place(&image, FLOATS, k, i, j);
                assert_true(at < sizeof taken && !taken[at]++);
                assert_int_equal(cvol_pixel_place(&lines, FLOATS, k, i, j),
                                 (j * FLOATS + k) * WIDTH + i);
            }
            const size_t corner = cvol_pixel_place(&image, FLOATS, 2, i / 4 * 4, j / 4 * 4);
            assert_int_equal(corner % CVOL_GROUP, 0);
            assert_int_equal(cvol_pixel_place(&image, FLOATS, 2, i, j),
                             corner + (size_t)(4 * (j % 4) + i % 4));
        }
}

/* A wall that is oblique to the rays: adjacent pixels reach it in different slices, and few slices
 * are evaluated for pixels that do not reach it there. Squares take 265 multiply-adds per pixel;
 * rows of sixteen pixels would take 429. */
static void test_image_order_wall(void **state)
{
    (void)state;
    static const cvol_transfer_point points[] = {{40, 0.9, 0.5, 0.2, 0}, {60, 1, 0.9, 0.6, 1}};
    cvol_volume volume = support_volume(64, 64, 64, CVOL_FLOAT32);
    for (size_t z = 0; z < 64; z++)
        for (size_t y = 0; y < 64; y++)
            for (size_t x = 0; x < 64; x++)
                ((float *)volume.data)[support_index(&volume, x, y, z)] =
                    (float)(50 + 10 * fmax(-4, fmin(4, (double)y - (double)x)));
    cvol_array *array = support_compress(context, &volume, 16, 80);
    cvol_render_options options = support_square(128, CVOL_MODE_COMPOSITE, 0, 0);
    options.sheet.ray_order = CVOL_RAY_ORDER_IMAGE;
    cvol_renderer *renderer;
    cvol_image *image;
    uint64_t count;
    assert_int_equal(cvol_image_create(context, &image, 128, 128), CVOL_OK);
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    support_set_transfer(context, renderer, points, 2);
    assert_int_equal(cvol_renderer_sheet_multiply_adds(context, renderer, image, &options, &count),
                     CVOL_OK);
    if (test_verbose())
        print_message("%.1f multiply-adds a pixel\n", (double)count / (128 * 128));
    assert_true(count < 320 * 128 * 128);
    cvol_renderer_free(renderer);
    cvol_image_free(image);
    cvol_array_free(array);
    free(volume.data);
}

/* If samples are nearly exact, also rays that hardly move within the slices have midpoints. */
static void test_nearly_exact(void **state)
{
    (void)state;
    cvol_volume volume = make_volume(0, 1);
    cvol_array *array = support_compress(context, &volume, 16, 80);
    const cvol_render_options options = support_square(120, CVOL_MODE_COMPOSITE, 10, 8);
    const double db = compare(array, &volume, solid, options, CVOL_RAY_ORDER_AUTO);
    if (test_verbose() || !(db >= 50))
        print_message("nearly exact: %.2f dB\n", db);
    assert_true(db >= 50);
    cvol_array_free(array);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_close_to_rays),        TEST(test_lit_close_to_rays),
        TEST(test_same_for_any_threads), TEST(test_object_order_is_unchanged),
        TEST(test_int16_blocks),         TEST(test_far_and_near),
        TEST(test_automatic_order),      TEST(test_bright_edge),
        TEST(test_nearly_exact),         TEST(test_squares),
        TEST(test_image_order_wall)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
