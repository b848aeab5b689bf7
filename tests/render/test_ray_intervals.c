/* The ray engine integrates transfer functions that change within a step: against closed forms for
 * a ramp seen along its rise, and against short steps for random functions on random volumes. The
 * seed is printed. CVOL_TEST_VERBOSE=1 prints the measurements. */
#include "test.h"

#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

#define SEED 20261126

/* ---- a ramp ---------------------------------------------------------------------------------- */

enum { SIDE = 5, LONG = 24 };

/* The value of a sample is its index along y. */
static cvol_volume ramp(void)
{
    cvol_volume volume = support_volume(SIDE, LONG, SIDE, CVOL_FLOAT32);
    for (size_t z = 0; z < SIDE; z++)
        for (size_t y = 0; y < LONG; y++)
            for (size_t x = 0; x < SIDE; x++)
                ((float *)volume.data)[support_index(&volume, x, y, z)] = (float)y;
    return volume;
}

/* The ray in the middle of the picture, along y or against it. */
typedef struct seen {
    double rgb[3], opacity, depth;
} seen;

static seen look(const cvol_transfer_point *points, size_t count, double step, int backward,
                 int is_lit)
{
    cvol_volume volume = ramp();
    cvol_renderer *renderer;
    cvol_image *image;
    cvol_render_options options = support_square(3, CVOL_MODE_COMPOSITE, backward ? 180 : 0, 0);
    options.step_voxels = step;
    options.shading.on = is_lit;
    options.shading.ambient = 1;
    options.shading.diffuse = options.shading.specular = 0;
    assert_int_equal(
        cvol_renderer_create(context, &renderer, CVOL_ENGINE_RAY, CVOL_SOURCE(.volume = &volume)),
        CVOL_OK);
    support_set_transfer(context, renderer, points, count);
    assert_int_equal(cvol_image_create_float(context, &image, 3, 3), CVOL_OK);
    assert_int_equal(cvol_image_add_depth(context, image), CVOL_OK);
    assert_int_equal(cvol_renderer_render(context, renderer, image, &options), CVOL_OK);
    const float *v = image->values + (ptrdiff_t)4 * 4;
    const seen out = {{v[0], v[1], v[2]}, v[3], image->depth[4]};
    cvol_image_free(image);
    cvol_renderer_free(renderer);
    free(volume.data);
    return out;
}

static void expect(const char *what, double step, double is, double expected)
{
    if (test_verbose() || !(fabs(is - expected) <= 1e-3))
        print_message("%s, step %g: %.5f, expected %.5f\n", what, step, is, expected);
    assert_true(fabs(is - expected) <= 1e-3);
}

static const double steps[] = {0.25, 0.5, 1, 0.77};
enum { STEPS = sizeof steps / sizeof *steps };

/* Opacity rises linearly to P and falls again: the mean of -log(1 - opacity) over both sides is
 * 1 + q log q / (1 - q), q = 1 - P. */
static void test_thin_peak(void **state)
{
    (void)state;
    const double places[] = {10.31, 10.5, 11, 1.2}, widths[] = {0.05, 0.3, 1.7};
    const double peaks[] = {0.3, 0.95, 1};
    for (int k = 0; k < 4 * 3 * 3; k++) {
        const double at = places[k % 4], half = widths[k / 4 % 3] / 2, peak = peaks[k / 12];
        const cvol_transfer_point points[] = {
            {at - half, 1, 1, 1, 0}, {at, 1, 1, 1, peak}, {at + half, 1, 1, 1, 0}};
        const double q = 1 - peak, mean = 1 + (q > 0 ? q * log(q) / (1 - q) : 0);
        for (int s = 0; s < STEPS; s++)
            for (int way = 0; way < 4; way++) {
                const seen is = look(points, 3, steps[s], way % 2, way / 2);
                expect("peak", steps[s], is.opacity, 1 - exp(-2 * half * mean));
                expect("peak's colour", steps[s], is.rgb[1], is.opacity);
            }
    }
}

/* Two layers between jumps, red and blue. */
static void test_jumps(void **state)
{
    (void)state;
    const double from = 7.3, middle = 9.77, to = 12.61;
    const double opacity = 0.5, other = 0.2;
    const cvol_transfer_point points[] = {{from, 1, 0, 0, 0},         {from, 1, 0, 0, opacity},
                                          {middle, 1, 0, 0, opacity}, {middle, 0, 0, 1, other},
                                          {to, 0, 0, 1, other},       {to, 0, 0, 1, 0}};
    const double red = 1 - pow(1 - opacity, middle - from), blue = 1 - pow(1 - other, to - middle);
    for (int s = 0; s < STEPS; s++)
        for (int way = 0; way < 4; way++) {
            const seen is = look(points, 6, steps[s], way % 2, way / 2);
            expect("red", steps[s], is.rgb[0], way % 2 ? (1 - blue) * red : red);
            expect("blue", steps[s], is.rgb[2], way % 2 ? blue : (1 - red) * blue);
            expect("both", steps[s], is.opacity, 1 - (1 - red) * (1 - blue));
        }
}

/* A colour that changes within a step, in a dense layer: the integral of c k exp(-k s). */
static void test_colour(void **state)
{
    (void)state;
    const double from = 5.4, width = 1.3, opacity = 0.9, k = -log(1 - opacity);
    const cvol_transfer_point points[] = {{from, 1, 0, 0, 0},
                                          {from, 1, 0, 0, opacity},
                                          {from + width, 0, 1, 0, opacity},
                                          {from + width, 0, 1, 0, 0}};
    const double left = exp(-k * width), behind = (1 - left * (1 + k * width)) / (k * width);
    for (int s = 0; s < STEPS; s++)
        for (int way = 0; way < 2; way++) {
            const seen is = look(points, 4, steps[s], way, 0);
            expect("far colour", steps[s], is.rgb[way ? 0 : 1], behind);
            expect("near colour", steps[s], is.rgb[way ? 1 : 0], 1 - left - behind);
        }
}

/* A surface is opaque at any step, at its place; a layer of opacity one half hides one half after
 * one sample. */
static void test_depth(void **state)
{
    (void)state;
    for (int s = 0; s < STEPS; s++) {
        double depth[3];
        for (int k = 0; k < 3; k++) {
            const double at = k == 1 ? 9.2 : 5.15, opacity = k == 2 ? 0.5 : 1;
            const cvol_transfer_point points[] = {{at, 1, 1, 1, 0}, {at, 1, 1, 1, opacity}};
            const seen is = look(points, 2, steps[s], 0, 0);
            depth[k] = is.depth;
            expect("surface", steps[s], is.opacity, 1);
        }
        expect("distance of surfaces", steps[s], depth[1] - depth[0], 9.2 - 5.15);
        expect("depth within a layer", steps[s], depth[2] - depth[0], 1);
    }
}

/* More points than an interval is divided at: stripes, of which a half is opaque. */
static void test_many_points(void **state)
{
    (void)state;
    enum { STRIPES = 400, COUNT = 4 * STRIPES };
    static cvol_transfer_point points[COUNT];
    for (int k = 0; k < STRIPES; k++) {
        const double at = 8 + 4.0 * k / STRIPES, end = at + 2.0 / STRIPES;
        points[4 * k] = (cvol_transfer_point){at, 1, 1, 1, 0};
        points[4 * k + 1] = (cvol_transfer_point){at, 1, 1, 1, 0.4};
        points[4 * k + 2] = (cvol_transfer_point){end, 1, 1, 1, 0.4};
        points[4 * k + 3] = (cvol_transfer_point){end, 1, 1, 1, 0};
    }
    for (int s = 0; s < STEPS; s++) {
        const seen is = look(points, COUNT, steps[s], s % 2, 0);
        /* Equal parts sample the stripes: their share may be a part more or less. */
        if (steps[s] < 0.5)
            expect("stripes", steps[s], is.opacity, 1 - pow(0.6, 2));
        assert_true(fabs(is.opacity - (1 - pow(0.6, 2))) < 0.05);
    }
}

/* ---- short steps ----------------------------------------------------------------------------- */

static cvol_volume waves(random_state *r)
{
    cvol_volume volume = support_volume(30, 27, 33, CVOL_FLOAT32);
    double k[3][4];
    for (int w = 0; w < 3; w++)
        for (int a = 0; a < 4; a++)
            k[w][a] = (a < 3 ? 0.3 : 3) * random_signed(r);
    for (size_t z = 0; z < 33; z++)
        for (size_t y = 0; y < 27; y++)
            for (size_t x = 0; x < 30; x++) {
                double value = 0;
                for (int w = 0; w < 3; w++)
                    value += sin(k[w][0] * (double)x + k[w][1] * (double)y + k[w][2] * (double)z +
                                 k[w][3]);
                ((float *)volume.data)[support_index(&volume, x, y, z)] = (float)(20 * value);
            }
    return volume;
}

/* Points in order; some are jumps, some very near. */
static size_t make_points(cvol_transfer_point *points, random_state *r)
{
    const size_t count = 3 + (size_t)random_below(r, 7);
    double value = -50;
    for (size_t i = 0; i < count; i++) {
        const double gaps[4] = {0, 0.5, 4, 25};
        value += gaps[random_below(r, 4)] * fabs(random_signed(r));
        points[i] = (cvol_transfer_point){value, fabs(random_signed(r)), fabs(random_signed(r)),
                                          fabs(random_signed(r)),
                                          random_below(r, 3) ? pow(fabs(random_signed(r)), 2) : 0};
    }
    points[0].opacity = points[count - 1].opacity = 0;
    return count;
}

static void test_short_steps(void **state)
{
    (void)state;
    enum { CASES = 40 };
    double worst = 99, sum = 0;
    int cases = 0;
    print_message("seed %d\n", SEED);
    for (int k = 0; k < CASES; k++) {
        random_state r = {SEED + (uint64_t)k};
        cvol_volume volume = waves(&r);
        cvol_transfer_point points[16];
        const size_t count = make_points(points, &r);
        cvol_render_options options = support_square(
            40, CVOL_MODE_COMPOSITE, 180 * random_signed(&r), 90 * random_signed(&r));
        options.camera.zoom = 1.5;
        options.shading.on = k % 3 == 2;
        options.step_voxels = 0.25;
        cvol_image *image = support_ray(context, &volume, points, count, &options);
        options.step_voxels = 0.02;
        cvol_image *fine = support_ray(context, &volume, points, count, &options);
        const double db = support_psnr(image, fine);
        if (test_verbose() || db < 52)
            print_message("%d: %.2f dB\n", k, db);
        worst = fmin(worst, db);
        sum += db;
        cases++;
        cvol_image_free(image);
        cvol_image_free(fine);
        free(volume.data);
    }
    print_message("%d cases: worst %.2f dB, mean %.2f dB\n", cases, worst, sum / cases);
    assert_true(worst >= 52 && sum / cases >= 62);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_thin_peak),   cmocka_unit_test(test_jumps),
        cmocka_unit_test(test_colour),      cmocka_unit_test(test_depth),
        cmocka_unit_test(test_many_points), cmocka_unit_test(test_short_steps),
    };
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
