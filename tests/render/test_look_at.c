/* Cameras that look at another point than the volume's centre: every engine's picture is then a
 * part of a larger one, and in perspective that of an eye at a given place. CVOL_TEST_VERBOSE=1
 * prints the measurements. */
#include "test.h"

#include "render/view/camera.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

#define LARGE 96
#define SMALL 40

static const double views[][2] = {{0, 0}, {30, 20}, {135, 60}, {250, -40}};
#define VIEWS (sizeof views / sizeof *views)

typedef struct input {
    cvol_volume volume;
    cvol_array *array;
} input;

static input make(void)
{
    input s = {.volume = support_blobs(37, 30, 33)};
    s.volume.grid.spacing[2] = 1.3;
    s.array = support_compress(context, &s.volume, 16, 75);
    return s;
}

static void release(input *s)
{
    cvol_array_free(s->array);
    free(s->volume.data);
}

static cvol_renderer *create(const input *s, cvol_engine engine)
{
    cvol_renderer *out;
    int code = engine == CVOL_ENGINE_SHEET ? cvol_renderer_create(context, &out, CVOL_ENGINE_SHEET,
                                                                  CVOL_SOURCE(.array = s->array))
               : engine == CVOL_ENGINE_RAY ? cvol_renderer_create(context, &out, CVOL_ENGINE_RAY,
                                                                  CVOL_SOURCE(.volume = &s->volume))
               : engine == CVOL_ENGINE_SPLAT
                   ? cvol_renderer_create(context, &out, CVOL_ENGINE_SPLAT,
                                          CVOL_SOURCE(.array = s->array))
               : engine == CVOL_ENGINE_TRANSFORM
                   ? cvol_renderer_create(context, &out, CVOL_ENGINE_TRANSFORM,
                                          CVOL_SOURCE(.array = s->array))
                   : cvol_renderer_create(context, &out, CVOL_ENGINE_FOURIER,
                                          CVOL_SOURCE(.array = s->array, .rho = 0));
    assert_int_equal(code, CVOL_OK);
    if (engine != CVOL_ENGINE_FOURIER)
        support_set_transfer(context, out, support_blob_points, SUPPORT_BLOB_POINTS);
    return out;
}

static cvol_image *draw(cvol_renderer *renderer, const cvol_render_options *options, int with_depth)
{
    cvol_image *image;
    assert_int_equal(cvol_image_create(context, &image, options->width, options->height), CVOL_OK);
    if (with_depth)
        assert_int_equal(cvol_image_add_depth(context, image), CVOL_OK);
    if (cvol_renderer_render(context, renderer, image, options))
        fail_msg("%s", cvol_context_message(context));
    return image;
}

/* Pixels first .. first + SMALL - 1 of a large picture. */
static cvol_image *crop(const cvol_image *large, int left, int top)
{
    cvol_image *out;
    assert_int_equal(cvol_image_create(context, &out, SMALL, SMALL), CVOL_OK);
    if (large->depth)
        assert_int_equal(cvol_image_add_depth(context, out), CVOL_OK);
    for (int j = 0; j < SMALL; j++) {
        const size_t from = (size_t)(top + j) * LARGE + (size_t)left, to = (size_t)j * SMALL;
        memcpy(out->rgba + 4 * to, large->rgba + 4 * from, (size_t)4 * SMALL);
        if (large->depth)
            memcpy(out->depth + to, large->depth + from, SMALL * sizeof *out->depth);
    }
    return out;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Differences of depths: half of them are at most out[0], 19 of 20 at most out[1], all at most
 * out[2]. *alone counts those that only one picture has. */
static void compare_depths(double out[3], int *alone, const cvol_image *a, const cvol_image *b)
{
    static double apart[LARGE * LARGE];
    int count = 0;
    *alone = 0;
    for (int at = 0; at < a->width * a->height; at++)
        if (isfinite(a->depth[at]) && isfinite(b->depth[at]))
            apart[count++] = fabs((double)a->depth[at] - (double)b->depth[at]);
        else
            *alone += isfinite(a->depth[at]) || isfinite(b->depth[at]);
    assert_true(count > 50);
    qsort(apart, (size_t)count, sizeof *apart, by_size);
    out[0] = apart[count / 2];
    out[1] = apart[count * 19 / 20];
    out[2] = apart[count - 1];
}

/* ---- in parallel projection ------------------------------------------------------------------ */

/* This number of pixels to the right, upwards, and towards the eye. */
static void look(cvol_render_options *options, const cvol_grid *grid, const double pixels[3])
{
    cvol_view view;
    assert_int_equal(cvol_view_make(context, &view, grid, options), CVOL_OK);
    for (int a = 0; a < 3; a++)
        options->camera.look_at[a] = view.pixel *
                                     (pixels[0] * view.right[a] + pixels[1] * view.up[a] +
                                      pixels[2] * view.eye[a]);
}

static void expect_part(const input *s, cvol_engine engine, const cvol_render_options *whole,
                        const int at[3])
{
    const int deep = (engine == CVOL_ENGINE_SHEET || engine == CVOL_ENGINE_RAY) &&
                     whole->mode == CVOL_MODE_COMPOSITE;
    cvol_renderer *renderer = create(s, engine);
    cvol_render_options part = *whole;
    part.width = part.height = SMALL;
    part.camera.zoom *= (double)LARGE / SMALL;
    look(&part, &s->volume.grid, (double[3]){at[0], at[1], at[2]});
    cvol_image *large = draw(renderer, whole, deep);
    cvol_image *is = draw(renderer, &part, deep);
    cvol_image *shall = crop(large, (LARGE - SMALL) / 2 + at[0], (LARGE - SMALL) / 2 - at[1]);
    const int most = support_difference(is, shall);
    double apart[3] = {0};
    int alone = 0;
    if (deep)
        compare_depths(apart, &alone, is, shall);
    if (test_verbose())
        print_message("engine %d, mode %d, azimuth %g, moved by %d %d %d: %d levels, depths by %g, "
                      "%g, %g, %d alone\n",
                      (int)engine, (int)whole->mode, whole->camera.azimuth_deg, at[0], at[1], at[2],
                      most, apart[0], apart[1], apart[2], alone);
    /* Rays of engine sheet begin at the picture's edge: at outlines within the volume, those of the
     * part may reach either side. */
    assert_true(most <= 1 && alone <= 2);
    assert_true(engine == CVOL_ENGINE_SHEET ? apart[0] < 0.1 && apart[1] < 1.5 : apart[2] < 1e-4);
    cvol_image_free(large);
    cvol_image_free(is);
    cvol_image_free(shall);
    cvol_renderer_free(renderer);
}

static void test_parts(void **state)
{
    (void)state;
    static const int moves[VIEWS][3] = {{12, 0, 0}, {-7, 19, 40}, {20, -11, -90}, {-25, 26, 3}};
    input s = make();
    for (size_t v = 0; v < VIEWS; v++)
        for (int engine = CVOL_ENGINE_SHEET; engine <= CVOL_ENGINE_FOURIER; engine++) {
            cvol_render_options options = support_square(LARGE, CVOL_MODE_COMPOSITE, views[v][0],
                                                         views[v][1]);
            options.background[2] = 0.5;
            options.camera.roll_deg = 35 * (double)v;
            options.camera.zoom = engine == CVOL_ENGINE_FOURIER && v % 2 ? 6 : 1.2;
            if (engine == CVOL_ENGINE_FOURIER)
                options.mode = CVOL_MODE_XRAY;
            expect_part(&s, (cvol_engine)engine, &options, moves[v]);
        }
    release(&s);
}

/* Projections, also in the data's own units. */
static void test_projections(void **state)
{
    (void)state;
    input s = make();
    cvol_renderer *renderer = create(&s, CVOL_ENGINE_FOURIER);
    cvol_render_options options = support_square(LARGE, CVOL_MODE_XRAY, 30, 20);
    double rotation[1][4];
    cvol_camera_get_rotation(rotation[0], &options.camera);
    static float large[LARGE * LARGE], part[LARGE * LARGE];
    assert_int_equal(
        cvol_renderer_project(context, renderer, large, &options, (const double(*)[4])rotation, 1),
        CVOL_OK);
    look(&options, &s.volume.grid, (double[3]){9, -14, 5});
    assert_int_equal(
        cvol_renderer_project(context, renderer, part, &options, (const double(*)[4])rotation, 1),
        CVOL_OK);
    int inside = 0;
    for (int j = 14; j < LARGE; j++)
        for (int i = 0; i + 9 < LARGE; i++) {
            const float is = part[(j - 14) * LARGE + i], shall = large[j * LARGE + i + 9];
            inside += shall > 1;
            assert_true(fabsf(is - shall) < 0.02f);
        }
    assert_true(inside > 500);
    cvol_renderer_free(renderer);
    release(&s);
}

/* ---- in perspective -------------------------------------------------------------------------- */

/* The picture of an eye at the place from which it looks. */
static void test_perspective(void **state)
{
    (void)state;
    static const double looks[VIEWS][3] = {{5, 0, 0}, {-3, 8, 11}, {0, -20, 4}, {10, 6, -9}};
    input s = make();
    for (size_t v = 0; v < VIEWS; v++) {
        cvol_render_options options = support_square(64, CVOL_MODE_COMPOSITE, views[v][0],
                                                     views[v][1]);
        options.background[2] = 0.5;
        options.camera.fov_deg = 40 + 15 * (double)v;
        options.camera.zoom = 1.4;
        memcpy(options.camera.look_at, looks[v], sizeof looks[v]);
        cvol_view view;
        cvol_render_options placed = options;
        assert_int_equal(cvol_view_make(context, &view, &s.volume.grid, &options), CVOL_OK);
        placed.camera.placed = 1;
        for (int a = 0; a < 3; a++) {
            assert_true(fabs(view.centre[a] - view.extent[a] / 2 - looks[v][a]) < 1e-9);
            placed.camera.eye[a] = looks[v][a] + view.distance * view.eye[a];
        }
        cvol_image *by_rays = NULL;
        for (int engine = CVOL_ENGINE_RAY; engine >= CVOL_ENGINE_SHEET; engine--) {
            cvol_renderer *renderer = create(&s, (cvol_engine)engine);
            cvol_image *is = draw(renderer, &options, 1), *shall = draw(renderer, &placed, 1);
            double apart[3];
            int alone;
            compare_depths(apart, &alone, is, shall);
            assert_true(support_difference(is, shall) <= 1);
            assert_true(apart[2] < 0.001 && !alone);
            if (!by_rays) {
                by_rays = is;
            } else {
                const double db = support_psnr(is, by_rays);
                if (test_verbose())
                    print_message("perspective, view %zu: %.2f dB of rays\n", v, db);
                assert_true(db >= 30);
                cvol_image_free(is);
            }
            cvol_image_free(shall);
            cvol_renderer_free(renderer);
        }
        cvol_image_free(by_rays);
    }
    release(&s);
}

static void test_nothing_is_visible_far_away(void **state)
{
    (void)state;
    input s = make();
    for (int engine = CVOL_ENGINE_SHEET; engine <= CVOL_ENGINE_FOURIER; engine++)
        for (int zoomed = 0; zoomed < 2; zoomed++) {
            cvol_renderer *renderer = create(&s, (cvol_engine)engine);
            cvol_render_options options = support_square(SMALL, CVOL_MODE_COMPOSITE, 30, 20);
            options.mode = engine == CVOL_ENGINE_FOURIER ? CVOL_MODE_XRAY : CVOL_MODE_COMPOSITE;
            options.camera.zoom = zoomed ? 20 : 1;
            options.background[1] = 1;
            for (int a = 0; a < 3; a++)
                options.camera.look_at[a] = a == 1 ? 40000 : -40000;
            for (int perspective = 0; perspective < (engine <= CVOL_ENGINE_RAY ? 2 : 1);
                 perspective++) {
                options.camera.fov_deg = 50 * perspective;
                cvol_image *image = draw(renderer, &options, 0);
                for (int at = 0; at < SMALL * SMALL; at++)
                    assert_true(!image->rgba[4 * at] && image->rgba[4 * at + 1] == 255);
                cvol_image_free(image);
            }
            cvol_renderer_free(renderer);
        }
    release(&s);
}

static void test_invalid_requests(void **state)
{
    (void)state;
    const double bad[] = {NAN, INFINITY, -INFINITY, 1e300, -13001};
    const cvol_grid grid = cvol_grid_make(4, 5, 13, CVOL_UINT8); /* diagonal 13 */
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        for (int fov = 0; fov <= 60; fov += 60) {
            cvol_render_options options = cvol_render_options_defaults();
            cvol_view view;
            options.camera.fov_deg = fov;
            options.camera.look_at[k % 3] = bad[k];
            assert_int_equal(cvol_view_make(context, &view, &grid, &options), CVOL_ERROR_ARGUMENT);
            assert_non_null(strstr(cvol_context_message(context), "look_at"));
        }
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_parts),
        TEST(test_projections),
        TEST(test_perspective),
        TEST(test_nothing_is_visible_far_away),
        TEST(test_invalid_requests),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
