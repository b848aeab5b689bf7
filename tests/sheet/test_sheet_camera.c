/* The sheet engine with clips and in perspective, against the ray engine with the same camera. Each
 * floor is the measured PSNR minus about 1.5 dB. CVOL_TEST_VERBOSE=1 prints the measurements. */
#include "test.h"

#include "support.h"
#include "support_context.h"
#include "support_lapped.h"
#include "support_render.h"

/* Waves that fill the volume, so that cuts are visible. */
static cvol_volume waves(size_t nx, size_t ny, size_t nz)
{
    cvol_volume volume = support_volume(nx, ny, nz, CVOL_FLOAT32);
    for (size_t z = 0; z < nz; z++)
        for (size_t y = 0; y < ny; y++)
            for (size_t x = 0; x < nx; x++)
                ((float *)volume.data)[support_index(&volume, x, y, z)] =
                    (float)(50 + 30 * sin(0.4 * (double)x + 0.1 * (double)y) +
                            20 * cos(0.3 * (double)z - 0.2 * (double)y));
    return volume;
}

static const cvol_transfer_point soft[] = {{0, 0.1, 0.2, 1, 0.02}, {100, 1, 0.6, 0.1, 0.15}};
static const cvol_transfer_point solid[] = {{0, 0.1, 0.2, 1, 1}, {100, 1, 0.6, 0.1, 1}};

typedef struct input {
    cvol_volume volume;
    cvol_array *array;
} input;

static input make(int lapped)
{
    input s = {.volume = waves(37, 45, 41)};
    s.volume.grid.spacing[2] = 1.3;
    if (lapped) {
        s.array = support_lapped(context, s.volume.data, s.volume.grid.dims, 0, 0.01, 1, 7);
        s.volume.grid.spacing[2] = 1;
    } else {
        s.array = support_compress(context, &s.volume, 16, 80);
    }
    return s;
}

static void release(input *s)
{
    cvol_array_free(s->array);
    free(s->volume.data);
}

/* Tests if all pixels around belong to the volume, or none. At a silhouette, or that of a cut, one
 * engine's pixels are one or the other, the other engine's are not. */
static int is_uniform(const cvol_image *image, int i, int j)
{
    const int reach = 3;
    int empty = 0, count = 0;
    for (int y = j - reach; y <= j + reach; y++)
        for (int x = i - reach; x <= i + reach; x++)
            if (x >= 0 && y >= 0 && x < image->width && y < image->height) {
                const uint8_t *p = support_pixel(image, x, y);
                empty += p[0] == 0 && p[1] == 255 && p[2] == 0;
                count++;
            }
    return empty == 0 || empty == count;
}

static cvol_render_options request(cvol_mode mode, double azimuth, double elevation)
{
    cvol_render_options options = support_square(72, mode, azimuth, elevation);
    options.background[1] = 1; /* no sample has this green, also in the grey modes */
    return options;
}

static double compare(const input *s, const cvol_transfer_point *points,
                      cvol_render_options options)
{
    cvol_image *sheet = support_sheet(context, s->array, points, 2, &options);
    options.step_voxels = 0.25;
    cvol_image *ray = support_ray(context, &s->volume, points, 2, &options);
    int inside = 0;
    for (int j = 0; j < ray->height; j++)
        for (int i = 0; i < ray->width; i++) {
            if (!is_uniform(ray, i, j))
                memcpy(sheet->rgba + 4 * (j * ray->width + i), support_pixel(ray, i, j), 4);
            else
                inside += support_pixel(ray, i, j)[1] != 255;
        }
    const double db = support_psnr(sheet, ray);
    cvol_image_free(sheet);
    cvol_image_free(ray);
    assert_true(inside > 10);
    return db;
}

static void expect(const input *s, const cvol_transfer_point *points,
                   const cvol_render_options *options, double floor_db, const char *what)
{
    const double db = compare(s, points, *options);
    if (test_verbose() || !(db >= floor_db))
        print_message("%s mode %d azimuth %g elevation %g roll %g fov %g%s: %.2f dB\n", what,
                      (int)options->mode, options->camera.azimuth_deg,
                      options->camera.elevation_deg, options->camera.roll_deg,
                      options->camera.fov_deg, points == solid ? " solid" : "", db);
    assert_true(db >= floor_db);
}

static void expect_all(const input *s, cvol_render_options options, const double floors_db[4],
                       const char *what)
{
    options.mode = CVOL_MODE_COMPOSITE;
    expect(s, soft, &options, floors_db[0], what);
    expect(s, solid, &options, floors_db[1], what);
    options.mode = CVOL_MODE_XRAY;
    expect(s, soft, &options, floors_db[2], what);
    options.mode = CVOL_MODE_MIP;
    expect(s, soft, &options, floors_db[3], what);
}

static const double views[][2] = {{0, 0}, {30, 20}, {135, 60}, {45, 35.2644}, {250, -40}};
#define VIEWS (sizeof views / sizeof *views)

/* ---- clips ----------------------------------------------------------------------------------- */

static cvol_clip box(void)
{
    return (cvol_clip){.axes = 7, .from = {5.3, -2, 11.6}, .to = {30.2, 28.8, 35.1}};
}

static cvol_clip oblique(void)
{
    return (cvol_clip){.planes = 2, .plane = {{1, -2, 0.7, -4.4}, {-0.3, 0.2, 1, -11}}};
}

static void test_clips(void **state)
{
    (void)state;
    static const double floors_db[4] = {41, 48, 58, 41.5};
    for (int lapped = 0; lapped < 2; lapped++) {
        input s = make(lapped);
        for (size_t v = (size_t)lapped; v < VIEWS; v += 1 + (size_t)lapped) {
            cvol_render_options options = request(CVOL_MODE_COMPOSITE, views[v][0], views[v][1]);
            options.clip = box();
            expect_all(&s, options, floors_db, "box");
            options.clip = oblique();
            expect_all(&s, options, floors_db, "planes");
            options.camera.zoom = 0.4;
            expect(&s, soft, &options, floors_db[0], "planes, from afar");
        }
        release(&s);
    }
}

/* A clip of the whole volume changes nothing. */
static void test_clips_of_all(void **state)
{
    (void)state;
    input s = make(0);
    for (size_t v = 0; v < VIEWS; v++) {
        cvol_render_options options = request(CVOL_MODE_COMPOSITE, views[v][0], views[v][1]);
        cvol_image *all = support_sheet(context, s.array, soft, 2, &options);
        options.clip = (cvol_clip){.axes = 5, .from = {-3, 0, 0}, .to = {36, 0, INFINITY}};
        cvol_image *clipped = support_sheet(context, s.array, soft, 2, &options);
        assert_int_equal(support_difference(all, clipped), 0);
        cvol_image_free(all);
        cvol_image_free(clipped);
    }
    release(&s);
}

static void expect_refused(input *s, const cvol_render_options *options, const char *word)
{
    cvol_renderer *renderer;
    cvol_image *image;
    assert_int_equal(cvol_image_create(context, &image, options->width, options->height), CVOL_OK);
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = s->array)),
        CVOL_OK);
    support_set_transfer(context, renderer, soft, 2);
    assert_int_equal(cvol_renderer_render(context, renderer, image, options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), word));
    cvol_renderer_free(renderer);
    cvol_image_free(image);
}

static void test_invalid_requests(void **state)
{
    (void)state;
    input s = make(0);
    const cvol_render_options good = request(CVOL_MODE_COMPOSITE, 0, 0);
    cvol_render_options bad;
#define REFUSE(set, word) \
    bad = good;           \
    set;                  \
    expect_refused(&s, &bad, word)
    REFUSE((bad.clip = (cvol_clip){.axes = 1, .from = {4}, .to = {4}}), "clip of x");
    REFUSE((bad.clip = (cvol_clip){.axes = 2, .from = {0, 50}, .to = {0, 60}}), "leaves no part");
    REFUSE((bad.clip = (cvol_clip){.axes = 1, .from = {NAN}, .to = {4}}), "clip of x");
    REFUSE((bad.clip = (cvol_clip){.planes = 1}), "clipping plane");
    REFUSE((bad.clip = (cvol_clip){.planes = 7}), "7 clipping planes");
    REFUSE(bad.camera.fov_deg = 0.5, "field of view");
    REFUSE(bad.camera.fov_deg = 151, "field of view");
    REFUSE(bad.camera.placed = 1, "field of view");
    bad.camera.fov_deg = 60;
    expect_refused(&s, &bad, "two places");
    bad.camera.eye[0] = 1;
    bad.camera.up[0] = 1;
    expect_refused(&s, &bad, "up is");
    release(&s);
}

/* ---- perspective ----------------------------------------------------------------------------- */

static void test_perspective(void **state)
{
    (void)state;
    static const double floors_db[4] = {38.5, 35.5, 35.5, 32.8};
    static const double fovs[] = {15, 45, 100};
    for (int lapped = 0; lapped < 2; lapped++) {
        input s = make(lapped);
        for (size_t v = 0; v < VIEWS; v++)
            for (size_t f = v % 2; f < 3; f += 2 - v % 2) {
                cvol_render_options options = request(CVOL_MODE_COMPOSITE, views[v][0],
                                                      views[v][1]);
                options.camera.fov_deg = fovs[f];
                options.camera.roll_deg = 20 * (double)v;
                options.camera.zoom = v % 3 ? 1.6 : 0.7;
                if (lapped)
                    options.clip = oblique();
                expect_all(&s, options, floors_db, "perspective");
            }
        release(&s);
    }
}

static void test_from_inside(void **state)
{
    (void)state;
    static const double floors_db[4] = {39.8, 38.4, 57, 46};
    static const double eyes[][6] = {{0, 0, 0, 0, 1, 0},      {3.2, -4, 5, 20, 15, -20},
                                     {-17, 0, 0, 0, 0, 0},    {0, 5, -20, 1, 4, 30},
                                     {18, 22, 26, -2, 1, -3}, {0, 0, 0, 1, 1, 1}};
    input s = make(0);
    for (size_t k = 0; k < sizeof eyes / sizeof *eyes; k++) {
        cvol_render_options options = request(CVOL_MODE_COMPOSITE, 0, 0);
        options.camera.fov_deg = k % 2 ? 120 : 75;
        options.camera.placed = 1;
        memcpy(options.camera.eye, eyes[k], sizeof options.camera.eye);
        memcpy(options.camera.look_at, eyes[k] + 3, sizeof options.camera.look_at);
        expect_all(&s, options, floors_db, "inside");
    }
    release(&s);
}

/* If another axis becomes the main one for some pixels, or for all, the picture hardly changes. */
static void test_pictures_change_continuously(void **state)
{
    (void)state;
    input s = make(0);
    static const double pairs[][4] = {{44.99, 10, 45.01, 10},
                                      {20, 44.99, 20, 45.01},
                                      {30, 20, 30.02, 20},
                                      {60, 35.25, 60.02, 35.26}};
    for (size_t k = 0; k < 4; k++)
        for (int fov = 0; fov < 2; fov++) {
            cvol_image *images[2];
            for (int side = 0; side < 2; side++) {
                cvol_render_options options = request(CVOL_MODE_COMPOSITE, pairs[k][2 * side],
                                                      pairs[k][2 * side + 1]);
                options.camera.fov_deg = fov ? 60 : 2;
                images[side] = support_sheet(context, s.array, soft, 2, &options);
            }
            for (int i = 0; i < 72 * 72; i++) /* the silhouette may move by a pixel */
                if (!is_uniform(images[0], i % 72, i / 72))
                    memcpy(images[0]->rgba + 4 * i, images[1]->rgba + 4 * i, 4);
            const double db = support_psnr(images[0], images[1]);
            if (test_verbose())
                print_message("pair %zu fov %d: %.2f dB\n", k, fov, db);
            assert_true(db >= 45);
            cvol_image_free(images[0]);
            cvol_image_free(images[1]);
        }
    release(&s);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_clips),       TEST(test_clips_of_all), TEST(test_invalid_requests),
        TEST(test_perspective), TEST(test_from_inside),  TEST(test_pictures_change_continuously),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
