/* Depths and opacities of pictures: against geometry, and the sheet engine against the ray engine.
 * CVOL_TEST_VERBOSE=1 prints the measurements. */
#include "test.h"

#include <unistd.h>

#include "support.h"
#include "support_context.h"
#include "support_render.h"

#define SIZE 64
#define PIXELS (SIZE * SIZE)

static const cvol_transfer_point soft[] = {{4, 0.1, 0.2, 1, 0}, {14, 1, 0.6, 0.1, 0.25}};
static const cvol_transfer_point solid[] = {{3, 0.1, 0.2, 1, 0}, {4, 1, 0.6, 0.1, 1}};

/* ---- a ball ---------------------------------------------------------------------------------- */

static const double middle[3] = {17.3, 20.9, 16.2};

/* Samples that hold the depth within a ball of radius 15. */
static cvol_volume ball(void)
{
    cvol_volume volume = support_volume(35, 41, 28, CVOL_FLOAT32);
    volume.grid.spacing[2] = 1.25;
    for (size_t z = 0; z < 28; z++)
        for (size_t y = 0; y < 41; y++)
            for (size_t x = 0; x < 35; x++)
                ((float *)volume.data)[support_index(&volume, x, y, z)] =
                    (float)(15 - hypot(hypot((double)x - middle[0], (double)y - middle[1]),
                                       1.25 * (double)z - middle[2]));
    return volume;
}

typedef struct input {
    cvol_volume volume;
    cvol_array *array;
    cvol_renderer *sheet, *ray;
} input;

static input make(void)
{
    input s = {.volume = ball()};
    s.array = support_compress(context, &s.volume, 16, 75);
    assert_int_equal(
        cvol_renderer_create(context, &s.sheet, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = s.array)),
        CVOL_OK);
    assert_int_equal(
        cvol_renderer_create(context, &s.ray, CVOL_ENGINE_RAY, CVOL_SOURCE(.volume = &s.volume)),
        CVOL_OK);
    return s;
}

static void release(input *s)
{
    cvol_renderer_free(s->sheet);
    cvol_renderer_free(s->ray);
    cvol_array_free(s->array);
    free(s->volume.data);
}

static cvol_image *draw(cvol_renderer *renderer, const cvol_transfer_point *points,
                        const cvol_render_options *options, int with_depth)
{
    cvol_image *image;
    support_set_transfer(context, renderer, points, 2);
    assert_int_equal(cvol_image_create_float(context, &image, options->width, options->height),
                     CVOL_OK);
    if (with_depth)
        assert_int_equal(cvol_image_add_depth(context, image), CVOL_OK);
    assert_int_equal(cvol_renderer_render(context, renderer, image, options), CVOL_OK);
    return image;
}

/* The distance of the ball of this radius from the plane at which depths begin; infinity if the ray
 * misses it. The camera is the parallel one, without roll. */
static double ball_depth(const cvol_render_options *options, int i, int j, double radius)
{
    const double extent[3] = {34, 40, 27 * 1.25}, turn = 3.14159265358979323846 / 180;
    const double a = options->camera.azimuth_deg * turn, e = options->camera.elevation_deg * turn;
    const double eye[3] = {cos(e) * sin(a), -cos(e) * cos(a), sin(e)};
    const double right[3] = {cos(a), sin(a), 0};
    const double up[3] = {-sin(e) * sin(a), sin(e) * cos(a), cos(e)};
    const double diagonal = hypot(hypot(extent[0], extent[1]), extent[2]);
    const double pixel = diagonal / options->camera.zoom / SIZE;
    const double u = (i + 0.5 - SIZE / 2.0) * pixel, v = (SIZE / 2.0 - j - 0.5) * pixel;
    double along = 0, square = 0;
    for (int k = 0; k < 3; k++) {
        const double from = extent[k] / 2 + u * right[k] + v * up[k] - middle[k];
        along += from * eye[k];
        square += from * from;
    }
    const double root = along * along - square + radius * radius;
    return root > 0 ? along - sqrt(root) + diagonal / 2 : INFINITY;
}

static void test_ball(void **state)
{
    (void)state;
    input s = make();
    static const double views[][2] = {{0, 0}, {30, 20}, {135, 60}, {250, -40}};
    for (size_t v = 0; v < 4; v++)
        for (int engine = 0; engine < 2; engine++) {
            cvol_render_options options = support_square(SIZE, CVOL_MODE_ISO, views[v][0],
                                                         views[v][1]);
            options.camera.zoom = 1.5;
            options.surface.value = 3;
            cvol_image *image = draw(engine ? s.ray : s.sheet, solid, &options, 1);
            double most = 0;
            int inside = 0, outside = 0;
            for (int at = 0; at < PIXELS; at++) {
                const double is = image->depth[at];
                /* Near its silhouette a ray may hit or miss the ball by rounding, and the depth is
                 * steep. */
                const double least = ball_depth(&options, at % SIZE, at / SIZE, 9.5),
                             hit = ball_depth(&options, at % SIZE, at / SIZE, 12),
                             miss = ball_depth(&options, at % SIZE, at / SIZE, 12.5);
                if (isfinite(least)) {
                    assert_true(isfinite(is));
                    most = fmax(most, fabs(is - hit));
                    inside++;
                } else if (isinf(miss)) {
                    assert_true(isinf(is) && is > 0);
                    outside++;
                }
            }
            if (test_verbose())
                print_message("view %zu engine %d: %g, %d inside\n", v, engine, most, inside);
            assert_true(most < 0.15 && inside > 400 && outside > 500);
            cvol_image_free(image);
        }
    release(&s);
}

/* ---- against the ray engine ------------------------------------------------------------------ */

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Half of the pixels differ by less than `median` samples, and 0.95 of them by less than `most`; in
 * few pixels only one engine has a depth. */
static void expect(input *s, const cvol_transfer_point *points, cvol_render_options options,
                   double median, double most, const char *what)
{
    static double differences[PIXELS];
    cvol_image *sheet = draw(s->sheet, points, &options, 1);
    options.step_voxels = 0.125;
    cvol_image *ray = draw(s->ray, points, &options, 1);
    size_t count = 0, alone = 0;
    for (int at = 0; at < PIXELS; at++) {
        if (isfinite(sheet->depth[at]) && isfinite(ray->depth[at]))
            differences[count++] = fabs((double)sheet->depth[at] - (double)ray->depth[at]);
        else
            alone += isfinite(sheet->depth[at]) || isfinite(ray->depth[at]);
    }
    qsort(differences, count, sizeof *differences, by_size);
    const double is[2] = {differences[count / 2], differences[count * 19 / 20]};
    if (test_verbose() || !(is[0] < median && is[1] < most && 10 * alone < count))
        print_message("%s, azimuth %g, mode %d%s: median %g, most %g, %zu of %zu alone\n", what,
                      options.camera.azimuth_deg, (int)options.mode,
                      points == solid ? " solid" : "", is[0], is[1], alone, count);
    assert_true(is[0] < median && is[1] < most && 10 * alone < count && count > 300);
    cvol_image_free(sheet);
    cvol_image_free(ray);
}

static void test_against_rays(void **state)
{
    (void)state;
    input s = make();
    static const double views[][2] = {{0, 0}, {30, 20}, {135, 60}, {250, -40}};
    for (size_t v = 0; v < 4; v++) {
        cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, views[v][0],
                                                     views[v][1]);
        options.camera.zoom = 1.5;
        expect(&s, soft, options, 0.1, 1, "parallel");
        expect(&s, solid, options, 0.1, 0.5, "parallel");
        options.shading.on = 1;
        expect(&s, soft, options, 0.1, 1, "lit");
        options.shading.on = 0;
        options.clip = (cvol_clip){
            .axes = 1, .from = {8.4}, .to = {24.2}, .planes = 1, .plane = {{0.2, 0.3, 1, -6}}};
        expect(&s, solid, options, 0.2, 0.6, "clipped");
        options.camera.fov_deg = 60;
        expect(&s, soft, options, 0.15, 1, "clipped, perspective");
        options.mode = CVOL_MODE_ISO;
        options.surface.value = 3;
        expect(&s, soft, options, 0.12, 0.5, "clipped, perspective");
    }
    release(&s);
}

/* with the picture */

static void test_picture_is_the_same(void **state)
{
    (void)state;
    input s = make();
    for (int kind = 0; kind < 4; kind++) {
        cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, 30, 20);
        options.mode = kind == 3 ? CVOL_MODE_ISO : CVOL_MODE_COMPOSITE;
        options.surface.value = 3;
        options.shading.on = kind == 1;
        options.camera.fov_deg = kind == 2 ? 50 : 0;
        cvol_context_set_threads(context, 1);
        cvol_image *plain = draw(s.sheet, soft, &options, 0);
        cvol_image *one = draw(s.sheet, soft, &options, 1);
        cvol_context_set_threads(context, 3);
        cvol_image *three = draw(s.sheet, soft, &options, 1);
        assert_memory_equal(plain->values, one->values, 4 * PIXELS * sizeof(float));
        assert_memory_equal(one->values, three->values, 4 * PIXELS * sizeof(float));
        assert_memory_equal(one->depth, three->depth, PIXELS * sizeof(float));
        cvol_image_mirror(three);
        for (int at = 0; at < PIXELS; at++)
            assert_memory_equal(&one->depth[at],
                                &three->depth[at / SIZE * SIZE + SIZE - 1 - at % SIZE],
                                sizeof(float));
        cvol_image_free(plain);
        cvol_image_free(one);
        cvol_image_free(three);
    }
    release(&s);
}

static void expect_file(const char *path, const float *expected, int step, int clamped)
{
    float row[SIZE];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    char head[16] = {0};
    assert_int_equal(fread(head, 1, 14, file), 14);
    assert_string_equal(head, "Pf\n64 64\n-1.0\n");
    for (int j = SIZE - 1; j >= 0; j--) {
        assert_int_equal(fread(row, sizeof *row, SIZE, file), SIZE);
        for (int i = 0; i < SIZE; i++) {
            float v = expected[(j * SIZE + i) * step];
            if (clamped)
                v = fminf(fmaxf(v, 0), 1);
            assert_true(row[i] <= v && row[i] >= v);
        }
    }
    fclose(file);
}

static void test_files(void **state)
{
    (void)state;
    input s = make();
    char path[] = "/tmp/cvol-depth-XXXXXX";
    const int descriptor = mkstemp(path);
    assert_true(descriptor >= 0);
    close(descriptor);
    const cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, 30, 20);
    cvol_image *image = draw(s.sheet, soft, &options, 1);
    assert_int_equal(cvol_image_write_depth(context, image, path), CVOL_OK);
    expect_file(path, image->depth, 1, 0);
    assert_int_equal(cvol_image_write_opacity(context, image, path), CVOL_OK);
    expect_file(path, image->values + 3, 4, 1);
    unlink(path);
    cvol_image_free(image);
    assert_int_equal(cvol_image_create(context, &image, 8, 8), CVOL_OK);
    assert_int_equal(cvol_image_write_depth(context, image, path), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "no depths"));
    assert_int_equal(cvol_image_write_opacity(context, image, path), CVOL_ERROR_ARGUMENT);
    cvol_image_free(image);
    release(&s);
}

static void test_engines_without_depth(void **state)
{
    (void)state;
    input s = make();
    cvol_renderer *splat;
    cvol_image *image;
    cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, 30, 20);
    assert_int_equal(
        cvol_renderer_create(context, &splat, CVOL_ENGINE_SPLAT, CVOL_SOURCE(.array = s.array)),
        CVOL_OK);
    support_set_transfer(context, splat, soft, 2);
    assert_int_equal(cvol_image_create(context, &image, SIZE, SIZE), CVOL_OK);
    assert_int_equal(cvol_image_add_depth(context, image), CVOL_OK);
    assert_int_equal(cvol_renderer_render(context, splat, image, &options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "has no depths"));
    options.mode = CVOL_MODE_MIP;
    assert_int_equal(cvol_renderer_render(context, s.ray, image, &options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "composite or iso"));
    cvol_image_free(image);
    cvol_renderer_free(splat);
    release(&s);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_ball),  TEST(test_against_rays),          TEST(test_picture_is_the_same),
        TEST(test_files), TEST(test_engines_without_depth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
