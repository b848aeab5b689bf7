/* Pictures of floats: every engine's bytes are its rounded floats, over any background; files of 16
 * bits and of floats store them; windows change grey levels. */
#include "test.h"

#include <unistd.h>

#include "random.h"
#include "support_context.h"
#include "support_render.h"

#define ENGINES 5
#define SIZE 61

static const char *const names[ENGINES] = {"sheet", "ray", "splat", "transform", "fourier"};

/* The same blobs, for every engine. */
typedef struct subject {
    cvol_volume volume;
    cvol_array *array;
    cvol_renderer *renderer;
} subject;

static void open_source(subject *s, int engine)
{
    s->volume = support_blobs(25, 31, 28);
    s->array = support_compress(context, &s->volume, 16, 60);
    s->renderer = NULL;
    switch (engine) {
    case 0:
        assert_int_equal(cvol_renderer_create(context, &s->renderer, CVOL_ENGINE_SHEET,
                                              CVOL_SOURCE(.array = s->array)),
                         CVOL_OK);
        break;
    case 1:
        assert_int_equal(cvol_renderer_create(context, &s->renderer, CVOL_ENGINE_RAY,
                                              CVOL_SOURCE(.volume = &s->volume)),
                         CVOL_OK);
        break;
    case 2:
        assert_int_equal(cvol_renderer_create(context, &s->renderer, CVOL_ENGINE_SPLAT,
                                              CVOL_SOURCE(.array = s->array)),
                         CVOL_OK);
        break;
    case 3:
        assert_int_equal(cvol_renderer_create(context, &s->renderer, CVOL_ENGINE_TRANSFORM,
                                              CVOL_SOURCE(.array = s->array)),
                         CVOL_OK);
        break;
    default:
        assert_int_equal(cvol_renderer_create(context, &s->renderer, CVOL_ENGINE_FOURIER,
                                              CVOL_SOURCE(.array = s->array, .rho = 0)),
                         CVOL_OK);
    }
    if (engine < 4)
        support_set_transfer(context, s->renderer, support_blob_points, SUPPORT_BLOB_POINTS);
}

static void close_source(subject *s)
{
    cvol_renderer_free(s->renderer);
    cvol_array_free(s->array);
    free(s->volume.data);
}

static cvol_mode first_mode(int engine)
{
    return engine == 4 ? CVOL_MODE_XRAY : CVOL_MODE_COMPOSITE;
}

static cvol_mode last_mode(int engine)
{
    return engine < 2 ? CVOL_MODE_MIP : first_mode(engine);
}

static cvol_image *floats_of(const subject *s, const cvol_render_options *options)
{
    cvol_image *image;
    assert_int_equal(cvol_image_create_float(context, &image, options->width, options->height),
                     CVOL_OK);
    assert_int_equal(cvol_renderer_render(context, s->renderer, image, options), CVOL_OK);
    return image;
}

/* The pixel of straight alpha over a background. */
static double over(const uint8_t pixel[4], int channel, double background)
{
    const double alpha = pixel[3] / 255.0;
    return pixel[channel] * alpha + 255 * background * (1 - alpha);
}

static void check_view(const subject *s, const char *name, const cvol_render_options *asked)
{
    static const double grounds[3][3] = {{0, 0, 0}, {1, 1, 1}, {0.2, 0.9, 0.5}};
    cvol_image *floats = floats_of(s, asked), *flat, *straight;
    assert_int_equal(cvol_image_create(context, &flat, SIZE, SIZE), CVOL_OK);
    assert_int_equal(cvol_image_create(context, &straight, SIZE, SIZE), CVOL_OK);
    assert_int_equal(cvol_image_flatten(context, straight, floats, NULL), CVOL_OK);
    for (int g = 0; g < 3; g++) {
        cvol_render_options options = *asked;
        memcpy(options.background, grounds[g], sizeof grounds[g]);
        cvol_image *bytes = support_picture(context, s->renderer, &options);
        assert_int_equal(cvol_image_flatten(context, flat, floats, grounds[g]), CVOL_OK);
        int most = support_difference(bytes, flat);
        double far = 0;
        for (size_t i = 0; i < 4 * SIZE * SIZE; i += 4)
            for (int c = 0; c < 3; c++)
                far = fmax(far, fabs(over(straight->rgba + i, c, grounds[g][c]) -
                                     bytes->rgba[i + (size_t)c]));
        if (most > 1 || far > 1.6)
            fail_msg("engine %s, mode %d, ground %d: rounded apart by %d, with alpha by %g", name,
                     (int)asked->mode, g, most, far);
        cvol_image_free(bytes);
    }
    cvol_image_free(floats);
    cvol_image_free(flat);
    cvol_image_free(straight);
}

static void test_engines(void **state)
{
    (void)state;
    for (int engine = 0; engine < ENGINES; engine++) {
        subject s;
        open_source(&s, engine);
        for (int mode = (int)first_mode(engine); mode <= (int)last_mode(engine); mode++) {
            const cvol_render_options options = support_square(SIZE, (cvol_mode)mode, 35, 25);
            check_view(&s, names[engine], &options);
        }
        close_source(&s);
    }
}

static void test_threads(void **state)
{
    (void)state;
    for (int engine = 0; engine < ENGINES; engine++) {
        subject s;
        open_source(&s, engine);
        const cvol_render_options options = support_square(SIZE, first_mode(engine), 35, 25);
        cvol_context_set_threads(context, 1);
        cvol_image *one = floats_of(&s, &options);
        cvol_context_set_threads(context, 3);
        cvol_image *three = floats_of(&s, &options);
        assert_memory_equal(one->values, three->values, 4 * sizeof(float) * SIZE * SIZE);
        cvol_image_free(one);
        cvol_image_free(three);
        close_source(&s);
    }
}

/* A quarter of the range is four times as steep; the samples' own range changes nothing. */
static void test_window(void **state)
{
    (void)state;
    for (int engine = 0; engine < ENGINES; engine++) {
        if (engine == 2 || engine == 3)
            continue;
        subject s;
        double range[2];
        open_source(&s, engine);
        assert_int_equal(cvol_renderer_get_range(context, range, s.renderer), CVOL_OK);
        cvol_render_options options = support_square(SIZE, CVOL_MODE_XRAY, 35, 25);
        cvol_image *plain = floats_of(&s, &options);
        memcpy(options.window, range, sizeof range);
        cvol_image *same = floats_of(&s, &options);
        options.window[0] = range[0] + (range[1] - range[0]) / 8;
        options.window[1] = options.window[0] + (range[1] - range[0]) / 4;
        cvol_image *steep = floats_of(&s, &options);
        cvol_image *bytes = support_picture(context, s.renderer, &options);
        for (size_t i = 0; i < 4 * SIZE * SIZE; i++) {
            if (fabsf(plain->values[i] - same->values[i]) > 1e-6f)
                fail_msg("engine %s: own range, %zu: %g, %g", names[engine], i, plain->values[i],
                         same->values[i]);
            const float wanted = i % 4 == 3 ? plain->values[i]
                                            : 4 * plain->values[i] - 0.5f * plain->values[i | 3];
            if (fabsf(wanted - steep->values[i]) > 1e-5f)
                fail_msg("engine %s: window, %zu: %g, %g", names[engine], i, wanted,
                         steep->values[i]);
            const float level = i % 4 == 3 ? 1 : fminf(fmaxf(steep->values[i], 0), 1);
            assert_true(fabsf(level * 255 - bytes->rgba[i]) < 0.51f);
        }
        options.window[1] = options.window[0];
        assert_int_equal(cvol_renderer_render(context, s.renderer, bytes, &options),
                         CVOL_ERROR_ARGUMENT);
        options.window[1] = NAN;
        assert_int_equal(cvol_renderer_render(context, s.renderer, bytes, &options),
                         CVOL_ERROR_ARGUMENT);
        cvol_image_free(plain);
        cvol_image_free(same);
        cvol_image_free(steep);
        cvol_image_free(bytes);
        close_source(&s);
    }
}

/* ---- pixels ------------------------------------------------------------------------------- */

/* Rounded alpha, and colour over it, are right over black and over white. */
static void test_straight(void **state)
{
    (void)state;
    random_state r = {7};
    cvol_image *floats, *bytes;
    assert_int_equal(cvol_image_create_float(context, &floats, 100, 100), CVOL_OK);
    assert_int_equal(cvol_image_create(context, &bytes, 100, 100), CVOL_OK);
    for (size_t i = 0; i < 10000; i++) {
        float *v = floats->values + 4 * i;
        v[3] = (float)pow(fabs(random_signed(&r)), 3);
        for (int c = 0; c < 3; c++)
            v[c] = v[3] * (float)fabs(random_signed(&r));
    }
    assert_int_equal(cvol_image_flatten(context, bytes, floats, NULL), CVOL_OK);
    for (size_t i = 0; i < 10000; i++) {
        const float *v = floats->values + 4 * i;
        for (int c = 0; c < 3; c++) {
            assert_true(fabs(over(bytes->rgba + 4 * i, c, 0) - 255 * (double)v[c]) <= 0.51);
            assert_true(fabs(over(bytes->rgba + 4 * i, c, 1) - 255 * (double)(v[c] + 1 - v[3])) <=
                        1.01);
        }
    }
    cvol_image_free(floats);
    cvol_image_free(bytes);
}

static void test_refusals(void **state)
{
    (void)state;
    cvol_image *floats, *bytes, *other;
    cvol_image_difference difference;
    cvol_picture *picture;
    const double black[3] = {0, 0, 0};
    const cvol_picture_options options = cvol_picture_options_defaults();
    assert_int_equal(cvol_image_create_float(context, &floats, 4, 3), CVOL_OK);
    assert_int_equal(cvol_image_create(context, &bytes, 4, 3), CVOL_OK);
    assert_int_equal(cvol_image_create(context, &other, 3, 4), CVOL_OK);
    cvol_image *none;
    assert_int_equal(cvol_image_create_float(context, &none, 0, 3), CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_image_flatten(context, other, floats, black), CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_image_flatten(context, floats, floats, black), CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_image_flatten(context, bytes, bytes, black), CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_image_write_png(context, floats, "none.png"), CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_image_write_png16(context, bytes, black, 0, "none.png"),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_image_write_pfm(context, bytes, black, 0, "none.pfm"),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_image_compare(context, &difference, floats, bytes), CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_picture_compress(context, &picture, floats, &options),
                     CVOL_ERROR_ARGUMENT);
    assert_int_not_equal(access("none.png", F_OK), 0);
    cvol_image_free(floats);
    cvol_image_free(bytes);
    cvol_image_free(other);
}

static void test_mirror(void **state)
{
    (void)state;
    for (int width = 1; width <= 4; width++) {
        cvol_image *floats, *bytes;
        assert_int_equal(cvol_image_create_float(context, &floats, width, 2), CVOL_OK);
        assert_int_equal(cvol_image_create(context, &bytes, width, 2), CVOL_OK);
        for (int i = 0; i < 8 * width; i++) {
            floats->values[i] = (float)i;
            bytes->rgba[i] = (uint8_t)i;
        }
        cvol_image_mirror(floats);
        cvol_image_mirror(bytes);
        for (int y = 0; y < 2; y++)
            for (int x = 0; x < width; x++)
                for (int c = 0; c < 4; c++) {
                    const int at = 4 * (x + width * y) + c;
                    const int from = 4 * (width - 1 - x + width * y) + c;
                    assert_int_equal(bytes->rgba[at], from);
                    assert_true(fabsf(floats->values[at] - (float)from) < 0.5f);
                }
        cvol_image_free(floats);
        cvol_image_free(bytes);
    }
}

/* ---- files -------------------------------------------------------------------------------- */

static void test_pfm(void **state)
{
    (void)state;
    cvol_image *image;
    assert_int_equal(cvol_image_create_float(context, &image, 3, 2), CVOL_OK);
    for (int i = 0; i < 24; i++)
        image->values[i] = i % 4 == 3 ? 0.5f : (float)i / 7 - 1;
    const double ground[3] = {0, 0.5, 1};
    char path[] = "/tmp/cvol-pfm-XXXXXX";
    const int fd = mkstemp(path);
    assert_true(fd >= 0);
    close(fd);
    for (int grey = 0; grey < 2; grey++) {
        assert_int_equal(cvol_image_write_pfm(context, image, ground, grey, path), CVOL_OK);
        FILE *file = fopen(path, "rb");
        char head[16];
        const size_t size = strlen("PF\n3 2\n-1.0\n");
        assert_int_equal(fread(head, 1, size, file), size);
        assert_memory_equal(head, grey ? "Pf\n3 2\n-1.0\n" : "PF\n3 2\n-1.0\n", size);
        const int channels = grey ? 1 : 3;
        for (int y = 1; y >= 0; y--)
            for (int x = 0; x < 3; x++)
                for (int c = 0; c < channels; c++) {
                    uint8_t bytes[4];
                    float value;
                    assert_int_equal(fread(bytes, 1, 4, file), 4);
                    const uint32_t bits = (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 |
                                          (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
                    memcpy(&value, &bits, sizeof value);
                    const float wanted = image->values[4 * (x + 3 * y) + c] +
                                         0.5f * (float)ground[c];
                    assert_true(fabsf(value - wanted) < 1e-6f);
                }
        assert_int_equal(fgetc(file), EOF);
        fclose(file);
    }
    unlink(path);
    cvol_image_free(image);
}

/* Reads the file as bytes: this rounds 16 bits to 8. */
static void test_png16(void **state)
{
    (void)state;
    cvol_image *image, *back;
    assert_int_equal(cvol_image_create_float(context, &image, 16, 16), CVOL_OK);
    for (int i = 0; i < 256; i++) {
        float *v = image->values + 4 * i;
        v[3] = (float)(i % 16) / 15;
        for (int c = 0; c < 3; c++)
            v[c] = v[3] * (float)((i * (c + 3)) % 256) / 255;
    }
    const double ground[3] = {1, 1, 1};
    char path[] = "/tmp/cvol-png-XXXXXX";
    const int fd = mkstemp(path);
    assert_true(fd >= 0);
    close(fd);
    for (int kind = 0; kind < 3; kind++) {
        const double *over_what = kind == 2 ? NULL : ground;
        assert_int_equal(cvol_image_write_png16(context, image, over_what, kind == 1, path),
                         CVOL_OK);
        assert_int_equal(cvol_image_read_png(context, &back, path), CVOL_OK);
        for (int i = 0; i < 256; i++)
            for (int c = 0; c < 4; c++) {
                const float *v = image->values + 4 * i, a = v[3];
                const float p = v[kind == 1 ? 0 : c], straight = a > 0 ? v[c] / a : 0;
                const float wanted = c == 3      ? (kind == 2 ? a : 1)
                                     : kind == 2 ? straight
                                                 : p + 1 - a;
                assert_true(fabsf(255 * wanted - back->rgba[4 * i + c]) < 0.51f);
            }
        cvol_image_free(back);
    }
    unlink(path);
    cvol_image_free(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_engines, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_threads, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_window, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_straight, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_refusals, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_mirror, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_pfm, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_png16, context_setup, context_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
