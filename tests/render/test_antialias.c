/* Pictures of surfaces: a pixel is the mean of four rays. */
#include "test.h"

#include "support.h"
#include "support_context.h"
#include "support_render.h"

#define SIZE 60

static cvol_volume make_ball(void)
{
    cvol_volume volume = support_volume(32, 32, 32, CVOL_FLOAT32);
    for (size_t z = 0; z < 32; z++)
        for (size_t y = 0; y < 32; y++)
            for (size_t x = 0; x < 32; x++)
                ((float *)volume.data)[support_index(&volume, x, y, z)] =
                    (float)(20 -
                            hypot(hypot((double)x - 15.5, (double)y - 15.5), (double)z - 15.5));
    return volume;
}

static cvol_render_options request(int width, int height, double oversample)
{
    cvol_render_options options = support_square(width, CVOL_MODE_ISO, 30, 20);
    options.height = height;
    options.oversample = oversample;
    options.surface.value = 8;
    return options;
}

static cvol_image *draw(cvol_renderer *renderer, const cvol_render_options *options, int floats)
{
    cvol_image *image;
    const int code = floats
                         ? cvol_image_create_float(context, &image, options->width, options->height)
                         : cvol_image_create(context, &image, options->width, options->height);
    assert_int_equal(code, CVOL_OK);
    assert_int_equal(cvol_image_add_depth(context, image), CVOL_OK);
    if (cvol_renderer_render(context, renderer, image, options))
        fail_msg("%s", cvol_context_message(context));
    return image;
}

/* The means of `by` x `by` pixels. */
static cvol_image *shrink(const cvol_image *image, int by)
{
    cvol_image *out;
    assert_int_equal(cvol_image_create(context, &out, image->width / by, image->height / by),
                     CVOL_OK);
    for (int y = 0; y < out->height; y++)
        for (int x = 0; x < out->width; x++)
            for (int c = 0; c < 4; c++) {
                int sum = 0;
                for (int k = 0; k < by * by; k++)
                    sum +=
                        image->rgba[4 * ((y * by + k / by) * image->width + x * by + k % by) + c];
                out->rgba[4 * (y * out->width + x) + c] = (uint8_t)((sum + by * by / 2) /
                                                                    (by * by));
            }
    return out;
}

/* The engines, of the same ball. */
typedef struct engines {
    cvol_volume volume;
    cvol_array *array;
    cvol_renderer *of[2];
} engines;

static engines make_engines(void)
{
    engines out = {.volume = make_ball()};
    out.array = support_compress(context, &out.volume, 16, 90);
    assert_int_equal(cvol_renderer_create(context, &out.of[0], CVOL_ENGINE_SHEET,
                                          CVOL_SOURCE(.array = out.array)),
                     CVOL_OK);
    assert_int_equal(cvol_renderer_create(context, &out.of[1], CVOL_ENGINE_RAY,
                                          CVOL_SOURCE(.volume = &out.volume)),
                     CVOL_OK);
    return out;
}

static void free_engines(engines *e)
{
    cvol_renderer_free(e->of[0]);
    cvol_renderer_free(e->of[1]);
    cvol_array_free(e->array);
    free(e->volume.data);
}

/* Against 16 rays per pixel: with one, outlines have stairs. */
static void test_outlines(void **state)
{
    (void)state;
    engines e = make_engines();
    for (int engine = 0; engine < 2; engine++) {
        const cvol_render_options many = request(4 * SIZE, 4 * SIZE, 1),
                                  few = request(SIZE, SIZE, 1), usual = request(SIZE, SIZE, 0);
        cvol_image *fine = draw(e.of[engine], &many, 0), *right = shrink(fine, 4),
                   *stairs = draw(e.of[engine], &few, 0), *smooth = draw(e.of[engine], &usual, 0);
        const double before = support_psnr(right, stairs), now = support_psnr(right, smooth);
        if (test_verbose())
            print_message("engine %d: %.1f dB, one ray %.1f\n", engine, now, before);
        assert_true(now >= before + 5);
        cvol_image_free(fine);
        cvol_image_free(right);
        cvol_image_free(stairs);
        cvol_image_free(smooth);
    }
    free_engines(&e);
}

/* Bytes and floats show the same, over any background, and depths end where the surface covers half
 * a pixel. */
static void test_kinds(void **state)
{
    (void)state;
    engines e = make_engines();
    for (int run = 0; run < 4; run++) {
        const int engine = run / 2;
        static const double grounds[2][3] = {{0, 0, 0}, {0.2, 0.5, 0.8}};
        const double *ground = grounds[run % 2];
        cvol_render_options options = request(SIZE, SIZE, 0);
        memcpy(options.background, ground, sizeof options.background);
        options.shading.ambient = 1; /* brighter than white */
        cvol_image *bytes = draw(e.of[engine], &options, 0),
                   *floats = draw(e.of[engine], &options, 1);
        int partial = 0;
        for (int i = 0; i < SIZE * SIZE; i++) {
            const float covered = floats->values[4 * i + 3];
            for (int c = 0; c < 3; c++) {
                const double value = floats->values[4 * i + c] + (1 - covered) * ground[c];
                assert_true(fabs(bytes->rgba[4 * i + c] - 255 * value) <= 1.01);
            }
            assert_true(bytes->depth[i] <= floats->depth[i] && floats->depth[i] <= bytes->depth[i]);
            if (covered < 0.3)
                assert_true(isinf(bytes->depth[i]));
            if (covered > 0.7)
                assert_true(isfinite(bytes->depth[i]));
            partial += covered > 0.1 && covered < 0.9;
        }
        assert_true(partial > 40);
        cvol_image_free(bytes);
        cvol_image_free(floats);
    }
    free_engines(&e);
}

/* Pictures too large for twice the pixels have one ray for each. */
static void test_largest(void **state)
{
    (void)state;
    engines e = make_engines();
    const cvol_render_options wide = request(20000, 2, 0), one = request(20000, 2, 1);
    cvol_image *a = draw(e.of[0], &wide, 0), *b = draw(e.of[0], &one, 0);
    assert_int_equal(support_difference(a, b), 0);
    cvol_image_free(a);
    cvol_image_free(b);
    free_engines(&e);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_outlines), TEST(test_kinds), TEST(test_largest)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
