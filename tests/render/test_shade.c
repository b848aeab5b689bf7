/* Light: pictures of the sheet engine against those of the ray engine, and options without effect.
 */
#include "test.h"

#include "cvol/codec.h"
#include "cvol/look.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

/* ---- pictures -------------------------------------------------------------------------------- */

static cvol_array *compress(const cvol_volume *volume, int block, int lapped, double fill)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array;
    options.block = block;
    options.lapped = lapped;
    options.target = CVOL_TARGET_PSNR;
    options.target_value = 80;
    options.has_fill = fill > 0;
    options.fill = fill;
    if (cvol_compress(context, &array, NULL, volume->data, &volume->grid, &options))
        fail_msg("%s", cvol_context_message(context));
    return array;
}

static cvol_render_options request(int size, double azimuth, double elevation, double zoom)
{
    cvol_render_options options = support_square(size, CVOL_MODE_COMPOSITE, azimuth, elevation);
    options.camera.zoom = zoom;
    options.shading.on = 1;
    return options;
}

/* Both engines' pictures of the decoded samples. Samples marked in `mask` have no value. */
static double compare(int *most, const cvol_array *array, const uint8_t *mask,
                      const cvol_transfer_point *points, size_t count, cvol_render_options options)
{
    const cvol_grid *grid = cvol_array_grid(array);
    cvol_volume volume = support_volume(grid->dims[0], grid->dims[1], grid->dims[2], CVOL_FLOAT32);
    cvol_renderer *renderer;
    volume.grid = *grid;
    assert_int_equal(cvol_array_evaluate_box(context, volume.data, array,
                                             (const size_t[3]){0, 0, 0}, grid->dims),
                     CVOL_OK);
    cvol_image *sheet = support_sheet(context, array, points, count, &options);
    options.step_voxels = 0.25;
    assert_int_equal(cvol_renderer_create(context, &renderer, CVOL_ENGINE_RAY,
                                          CVOL_SOURCE(.volume = &volume, .mask = mask)),
                     CVOL_OK);
    if (points)
        support_set_transfer(context, renderer, points, count);
    cvol_image *ray = support_picture(context, renderer, &options);
    const double psnr = support_psnr(sheet, ray);
    *most = support_difference(sheet, ray);
    cvol_renderer_free(renderer);
    cvol_image_free(sheet);
    cvol_image_free(ray);
    free(volume.data);
    return psnr;
}

static void expect(const char *what, int k, double psnr, int most, double least_psnr, int largest)
{
    if (test_verbose())
        print_message("%s %d: %.1f dB, off by %d\n", what, k, psnr, most);
    if (!(psnr >= least_psnr) || most > largest)
        fail_msg("%s %d: %.1f dB, off by %d; expected %.1f and %d", what, k, psnr, most, least_psnr,
                 largest);
}

/* ---- against the ray engine ------------------------------------------------------------------ */

static const double views[][3] = {{0, 0, 1},     {90, 0, 1},    {0, 90, 1},   {30, 20, 1},
                                  {200, -35, 2}, {45, 45, 0.6}, {300, 10, 4}, {135, -80, 1}};
enum { VIEWS = sizeof views / sizeof *views };

static void test_views(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(50, 41, 47);
    const double spacings[2][3] = {{1, 1, 1}, {1, 1.7, 0.6}};
    for (int s = 0; s < 2; s++) {
        memcpy(volume.grid.spacing, spacings[s], sizeof volume.grid.spacing);
        cvol_array *arrays[2] = {compress(&volume, 16, 0, 0), compress(&volume, 16, 1, 0)};
        for (int k = s; k < 2 * VIEWS; k += 3) {
            const double *v = views[k / 2];
            cvol_render_options options = request(v[2] < 1 ? 40 : 100, v[0], v[1], v[2]);
            int most;
            if (k % 3 == 1) {
                options.shading.light[0] = 1;
                options.shading.light[1] = -0.5;
                options.shading.shininess = 30;
            }
            if (k % 5 == 3)
                options.shading.gradient_opacity = 3;
            const double psnr = compare(&most, arrays[k % 2], NULL, support_blob_points,
                                        SUPPORT_BLOB_POINTS, options);
            expect(s ? "anisotropic" : "view", k, psnr, most, 44, 24);
        }
        cvol_array_free(arrays[0]);
        cvol_array_free(arrays[1]);
    }
    free(volume.data);
}

/* A ball with a soft face, behind which it is opaque. */
static cvol_volume ball(size_t nx, size_t ny, size_t nz, double radius)
{
    cvol_volume volume = support_volume(nx, ny, nz, CVOL_FLOAT32);
    for (size_t z = 0; z < nz; z++)
        for (size_t y = 0; y < ny; y++)
            for (size_t x = 0; x < nx; x++) {
                const double dx = (double)x - 0.49 * (double)nx, dy = (double)y - 0.5 * (double)ny;
                const double r = hypot(hypot(dx, dy), (double)z - 0.51 * (double)nz);
                ((float *)volume.data)[support_index(&volume, x, y, z)] =
                    (float)(200 / (1 + exp((r - radius) / 2)));
            }
    return volume;
}

static const cvol_transfer_point skin[] = {
    {90, .9, .8, .7, 0}, {110, .9, .8, .7, .9}, {200, .9, .8, .7, .9}};

/* A surface that passes from block to block shows no seams: pictures have no edges that the
 * reference lacks. */
static void test_no_seams(void **state)
{
    (void)state;
    cvol_volume volume = ball(70, 66, 75, 27);
    for (int lapped = 0; lapped < 2; lapped++) {
        cvol_array *array = compress(&volume, 16, lapped, 0);
        for (int k = 0; k < 4; k++) {
            const double angles[4][2] = {{0, 0}, {45, 35}, {45, 0}, {200, -70}};
            int most;
            const double psnr = compare(&most, array, NULL, skin, 3,
                                        request(150, angles[k][0], angles[k][1], 4));
            expect(lapped ? "lapped ball" : "ball", k, psnr, most, 48, 5);
        }
        cvol_array_free(array);
    }
    free(volume.data);
}

static const cvol_transfer_point fog[] = {{0, .2, .5, 1, .03}, {60, 1, .6, .1, .1}};

static void test_shapes(void **state)
{
    (void)state;
    const size_t shapes[][3] = {{1, 30, 30}, {30, 1, 30}, {30, 30, 1}, {17, 33, 5}, {20, 34, 2}};
    for (int k = 0; k < 5; k++) {
        cvol_volume volume = support_blobs(shapes[k][0], shapes[k][1], shapes[k][2]);
        cvol_array *array = compress(&volume, 16, 1, 0);
        for (int v = k % 2; v < VIEWS; v += 2) {
            int most;
            const double psnr = compare(&most, array, NULL, fog, 2,
                                        request(60, views[v][0], views[v][1], 1));
            expect("shape", 10 * k + v, psnr, most, 44, 30);
        }
        cvol_array_free(array);
        free(volume.data);
    }
}

/* Samples without a value make no rims: the two engines agree next to them too. */
/* Where noise disturbs a gentle slope the gradient turns, while values and opacity hardly change.
 */
static void test_turning_light(void **state)
{
    (void)state;
    random_state r = {12};
    cvol_volume volume = support_volume(40, 36, 32, CVOL_FLOAT32);
    for (size_t i = 0; i < cvol_grid_samples(&volume.grid); i++)
        ((float *)volume.data)[i] = (float)(60 + 2 * (double)(i % 40) + 3 * random_signed(&r));
    cvol_array *array = compress(&volume, 16, 0, 0);
    static const cvol_transfer_point mist[] = {{0, .9, .8, .7, .05}, {200, .9, .7, .6, .15}};
    for (int k = 0; k < 3; k++) {
        int most;
        const double psnr = compare(&most, array, NULL, mist, 2, request(96, 30, 10, 1 << k));
        expect("noise", k, psnr, most, 43.5, 14);
    }
    cvol_array_free(array);
    free(volume.data);
}

static void test_void(void **state)
{
    (void)state;
    cvol_volume volume = ball(50, 41, 47, 18);
    const size_t count = 50 * 41 * 47;
    uint8_t *mask = calloc(count, 1);
    for (size_t i = 0; i < count; i++) {
        const double x = (double)(i % 50) - 33, y = (double)(i / 50 % 41) - 11;
        mask[i] = hypot(hypot(x, y), (double)(i / (50 * 41)) - 24) < 12;
        if (mask[i])
            ((float *)volume.data)[i] = 1e35f;
    }
    cvol_array *array = compress(&volume, 16, 1, 1e35);
    for (int k = 0; k < VIEWS; k++) {
        int most;
        const double psnr = compare(&most, array, mask, skin, 3,
                                    request(90, views[k][0], views[k][1], 1));
        expect("void", k, psnr, most, 35, 100);
    }
    cvol_array_free(array);
    free(mask);
    free(volume.data);
}

/* Surfaces lie between slices as they do between steps: no grain. */
static void test_surfaces(void **state)
{
    (void)state;
    cvol_volume volume = ball(58, 51, 47, 19), blobs = support_blobs(45, 50, 40);
    for (int k = 0; k < 2 * VIEWS; k = support_next(k)) {
        cvol_volume *of = k % 2 ? &volume : &blobs;
        const double *v = views[k / 2];
        of->grid.spacing[1] = k % 3 ? 1 : 1.4;
        cvol_array *array = compress(of, 16, k / 2 % 2, 0);
        cvol_render_options options = request(100, v[0], v[1], v[2]);
        options.mode = CVOL_MODE_ISO;
        options.surface.value = k % 2 ? 100 : 45;
        options.shading.on = 0;
        int most;
        const double psnr = compare(&most, array, NULL, NULL, 0, options);
        expect(k % 2 ? "ball's surface" : "surface", k, psnr, most, 30, 255);
        cvol_array_free(array);
    }
    free(volume.data);
    free(blobs.data);
}

/* A surface whose value every sample exceeds is the volume's face; a value above all samples has no
 * surface. */
static void test_surface_beyond_range(void **state)
{
    (void)state;
    cvol_volume volume = support_volume(20, 20, 20, CVOL_FLOAT32);
    for (int i = 0; i < 20 * 20 * 20; i++)
        ((float *)volume.data)[i] = 5;
    cvol_array *array = compress(&volume, 16, 1, 0);
    cvol_render_options options = request(60, 0, 0, 1);
    options.mode = CVOL_MODE_ISO;
    options.shading.ambient = 1;
    options.shading.diffuse = options.shading.specular = 0;
    options.surface.colour[0] = 0.5;
    options.surface.value = 4;
    cvol_image *image = support_sheet(context, array, NULL, 0, &options);
    assert_in_range(support_pixel(image, 30, 30)[0], 127, 128);
    cvol_image_free(image);
    options.surface.value = 6;
    image = support_sheet(context, array, NULL, 0, &options);
    assert_int_equal(support_pixel(image, 30, 30)[0], 0);
    cvol_image_free(image);
    cvol_array_free(array);
    free(volume.data);
}

static void test_minimum(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(40, 34, 45);
    for (int i = 0; i < 40 * 34 * 45; i++)
        ((float *)volume.data)[i] *= -1;
    cvol_array *array = compress(&volume, 16, 1, 0);
    for (int k = 0; k < VIEWS; k++) {
        cvol_render_options options = request(90, views[k][0], views[k][1], views[k][2]);
        options.mode = CVOL_MODE_MIN;
        options.background[0] = options.background[1] = options.background[2] = 1;
        int most;
        const double psnr = compare(&most, array, NULL, NULL, 0, options);
        expect("minimum", k, psnr, most, 30, 255);
    }
    cvol_array_free(array);
    free(volume.data);
}

/* Opaque faces of the volume, from all sides: beyond them samples repeat, also for gradients. */
static void test_faces(void **state)
{
    (void)state;
    static const cvol_transfer_point opaque[] = {{-9, .4, .2, .15, .9}, {9, 1, 1, 1, .95}};
    const size_t n[3] = {48, 45, 41};
    cvol_volume volume = support_volume(n[0], n[1], n[2], CVOL_FLOAT32);
    for (size_t i = 0; i < n[0] * n[1] * n[2]; i++) {
        const double x = (double)(i % n[0]), y = (double)(i / n[0] % n[1]),
                     z = (double)(i / n[0] / n[1]);
        ((float *)volume.data)[i] = (float)(sin(.3 * x + .5) + cos(.27 * y + .3) + sin(.35 * z) +
                                            sin(.2 * (x + y + z)));
    }
    for (int lapped = 0; lapped < 2; lapped++) {
        cvol_array *array = compress(&volume, 16, lapped, 0);
        for (int azimuth = 0; azimuth < 360; azimuth += 23) {
            const cvol_render_options options = request(96, azimuth, 20, 1);
            const double db = support_sheet_db(context, array, &volume, opaque, 2, options);
            if (db < 30)
                fail_msg("lapped %d, azimuth %d: %.1f dB", lapped, azimuth, db);
        }
        cvol_array_free(array);
    }
    free(volume.data);
}

/* Differences of a millionth of the visible values have no direction: their light is that of a
 * surface that faces the eye. */
static void test_flat_matter(void **state)
{
    (void)state;
    static const cvol_transfer_point even[] = {{0, .5, .5, .5, 1}, {255, .5, .5, .5, 1}};
    random_state r = {7};
    cvol_volume volume = support_volume(32, 32, 32, CVOL_FLOAT32);
    for (int i = 0; i < 32 * 32 * 32; i++)
        ((float *)volume.data)[i] = 100 + 1e-4f * (float)random_signed(&r);
    cvol_array *array = compress(&volume, 16, 0, 0);
    for (int engine = 0; engine < 2; engine++) {
        const cvol_render_options options = request(40, 10, 10, 2);
        cvol_image *image = engine ? support_ray(context, &volume, even, 2, &options)
                                   : support_sheet(context, array, even, 2, &options);
        /* ambient and diffuse, and the highlight: (0.1 + 0.7) 0.5 + 0.2 */
        for (int i = 8; i < 32; i++)
            assert_in_range(support_pixel(image, i, 20)[0], 151, 155);
        cvol_image_free(image);
    }
    cvol_array_free(array);
    free(volume.data);
}

/* Light does not depend on the unit of the values: pictures of densities of 1e-24 are those of the
 * same numbers of 1 or of 1e20. */
static void test_units(void **state)
{
    (void)state;
    static const double units[] = {0x1p-80, 0x1p-52, 0x1p66, 0x1p90};
    static const cvol_engine engines[] = {CVOL_ENGINE_SHEET, CVOL_ENGINE_RAY, CVOL_ENGINE_SPLAT};
    cvol_volume volume = support_blobs(24, 26, 22);
    cvol_image *first[6] = {NULL};
    for (int u = -1; u < 4; u++) {
        const double unit = u < 0 ? 1 : units[u];
        cvol_volume scaled = support_volume(24, 26, 22, CVOL_FLOAT32);
        cvol_transfer_point points[SUPPORT_BLOB_POINTS];
        for (int i = 0; i < 24 * 26 * 22; i++)
            ((float *)scaled.data)[i] = (float)(unit * (double)((float *)volume.data)[i]);
        for (int i = 0; i < SUPPORT_BLOB_POINTS; i++) {
            points[i] = support_blob_points[i];
            points[i].value *= unit;
        }
        cvol_array *array = compress(&scaled, 16, 0, 0);
        for (int k = 0; k < 6; k++) {
            cvol_render_options options = request(40, 30, 20, 1);
            cvol_renderer *renderer;
            const cvol_engine engine = engines[k / 2];
            if (k % 2 && engine == CVOL_ENGINE_SPLAT)
                options.shading.gradient_opacity = 5 * unit;
            else if (k % 2)
                options.mode = CVOL_MODE_ISO;
            else if (engine != CVOL_ENGINE_SPLAT)
                cvol_render_options_set_studio(&options);
            options.surface.value = 45 * unit;
            const cvol_source source = {.size = sizeof source,
                                        .array = engine == CVOL_ENGINE_RAY ? NULL : array,
                                        .volume = engine == CVOL_ENGINE_RAY ? &scaled : NULL};
            assert_int_equal(cvol_renderer_create(context, &renderer, engine, &source), CVOL_OK);
            support_set_transfer(context, renderer, points, SUPPORT_BLOB_POINTS);
            cvol_image *image = support_picture(context, renderer, &options);
            cvol_renderer_free(renderer);
            if (u < 0) {
                first[k] = image;
                continue;
            }
            if (support_difference(image, first[k]) > 1)
                fail_msg("picture %d in units of %g: off by %d", k, unit,
                         support_difference(image, first[k]));
            cvol_image_free(image);
        }
        cvol_array_free(array);
        free(scaled.data);
    }
    for (int k = 0; k < 6; k++)
        cvol_image_free(first[k]);
    free(volume.data);
}

/* Engine sheet refuses ranges that single precision does not hold, rather than draw nothing. */
static void test_units_beyond(void **state)
{
    (void)state;
    static const struct {
        double unit;
        int code;
    } cases[] = {{1e-34, CVOL_ERROR_UNSUPPORTED},
                 {1e-28, CVOL_OK},
                 {1e30, CVOL_OK},
                 {1e35, CVOL_ERROR_UNSUPPORTED}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        cvol_volume volume = support_blobs(16, 16, 16);
        for (int k = 0; k < 16 * 16 * 16; k++)
            ((float *)volume.data)[k] *= (float)cases[i].unit;
        cvol_compress_options options = cvol_compress_options_defaults();
        cvol_array *array;
        cvol_renderer *renderer;
        options.lossless = 1;
        assert_int_equal(cvol_compress(context, &array, NULL, volume.data, &volume.grid, &options),
                         CVOL_OK);
        assert_int_equal(cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET,
                                              CVOL_SOURCE(.array = array)),
                         cases[i].code);
        cvol_renderer_free(renderer);
        cvol_array_free(array);
        free(volume.data);
    }
}

/* ---- options without effect ------------------------------------------------------------------ */

/* Ambient light alone shows no relief. */
static void test_ambient_alone(void **state)
{
    (void)state;
    cvol_volume volume = support_blobs(40, 36, 44);
    cvol_array *array = compress(&volume, 16, 1, 0);
    for (int k = 0; k < VIEWS; k++) {
        cvol_render_options options = request(90, views[k][0], views[k][1], views[k][2]);
        options.shading.ambient = 1;
        options.shading.diffuse = options.shading.specular = 0;
        options.sheet.ray_order = k % 2 ? CVOL_RAY_ORDER_OBJECT : CVOL_RAY_ORDER_IMAGE;
        cvol_image *lit = support_sheet(context, array, support_blob_points, SUPPORT_BLOB_POINTS,
                                        &options);
        options.shading.on = 0;
        cvol_image *plain = support_sheet(context, array, support_blob_points, SUPPORT_BLOB_POINTS,
                                          &options);
        /* Lit image-order rays have more parts. */
        const int most = options.sheet.ray_order == CVOL_RAY_ORDER_OBJECT ? 1 : 4;
        if (support_difference(lit, plain) > most)
            fail_msg("view %d: off by %d", k, support_difference(lit, plain));
        cvol_image_free(lit);
        cvol_image_free(plain);
    }
    cvol_array_free(array);
    free(volume.data);
}

static void test_same_for_any_threads(void **state)
{
    (void)state;
    cvol_volume volume = ball(50, 60, 55, 20);
    for (int lapped = 0; lapped < 2; lapped++) {
        cvol_array *array = compress(&volume, 16, lapped, 0);
        for (int k = 3; k < 6; k++) {
            const cvol_render_options options = request(230, views[k][0], views[k][1], 1);
            cvol_context_set_threads(context, 1);
            cvol_image *one = support_sheet(context, array, skin, 3, &options);
            cvol_context_set_threads(context, 3);
            cvol_image *three = support_sheet(context, array, skin, 3, &options);
            cvol_context_set_threads(context, 0);
            assert_int_equal(support_difference(one, three), 0);
            cvol_image_free(one);
            cvol_image_free(three);
        }
        cvol_array_free(array);
    }
    free(volume.data);
}

/* A renderer that alternates between lit and unlit pictures draws each as if it were the first. */
static void test_rotated_views(void **state)
{
    (void)state;
    cvol_volume volume = ball(40, 36, 44, 15);
    cvol_array *array = compress(&volume, 16, 1, 0);
    cvol_renderer *renderer;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)),
        CVOL_OK);
    support_set_transfer(context, renderer, skin, 3);
    for (int k = 0; k < 4; k++) {
        cvol_render_options options = request(k > 1 ? 60 : 90, 30 * k, 20, 1);
        options.shading.on = k % 2;
        cvol_image *again = support_picture(context, renderer, &options);
        cvol_image *first = support_sheet(context, array, skin, 3, &options);
        assert_int_equal(support_difference(first, again), 0);
        cvol_image_free(first);
        cvol_image_free(again);
    }
    cvol_renderer_free(renderer);
    cvol_array_free(array);
    free(volume.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_views),
        cmocka_unit_test(test_no_seams),
        cmocka_unit_test(test_shapes),
        cmocka_unit_test(test_turning_light),
        cmocka_unit_test(test_void),
        cmocka_unit_test(test_ambient_alone),
        cmocka_unit_test(test_same_for_any_threads),
        cmocka_unit_test(test_rotated_views),
        cmocka_unit_test(test_surfaces),
        cmocka_unit_test(test_surface_beyond_range),
        cmocka_unit_test(test_faces),
        cmocka_unit_test(test_flat_matter),
        cmocka_unit_test(test_units),
        cmocka_unit_test(test_units_beyond),
        cmocka_unit_test(test_minimum),
    };
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
