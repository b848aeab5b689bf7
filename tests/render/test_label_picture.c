/* Pictures of labels: their shape, coloured by depth (cvol/look.h). */
#include "test.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cvol/look.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

enum { SIDE = 40, PLATE = 6, ROD = 2, LEFT = 1, RIGHT = 9, LABELS = 9, SIZE = 160 };

/* Components that no mixture of two other colours gives. */
static const double colours[3 * LABELS] = {1, 0.2, 0.2, 0.2, 1, 0.2, 0, 0, 0, 0, 0,   0,   0, 0,
                                           0, 1,   0.2, 1,   0, 0,   0, 0, 0, 0, 0.2, 0.2, 1};

/* Seen from the front, -y: above, a plate of one sample; a rod of one sample in front of a ball
 * whose halves have labels that are far apart. */
static cvol_volume make_scene(void)
{
    cvol_volume volume = support_volume(SIDE, SIDE, SIDE, CVOL_UINT8);
    uint8_t *data = volume.data;
    for (size_t z = 0; z < SIDE; z++)
        for (size_t y = 0; y < SIDE; y++)
            for (size_t x = 0; x < SIDE; x++) {
                const double square = pow((double)x - 19.5, 2) + pow((double)y - 22.5, 2) +
                                      pow((double)z - 14.5, 2);
                uint8_t *to = &data[support_index(&volume, x, y, z)];
                if (square < 121)
                    *to = x < 20 ? LEFT : RIGHT;
                if (z > 28 && z < 37 && y == 20 && x > 3 && x < 36)
                    *to = PLATE;
                if (y == 4 && z == 14)
                    *to = ROD;
            }
    return volume;
}

/* The label whose colour a pixel has, at any brightness; 0 if none. */
static int label_of(const float *pixel)
{
    for (int label = 1; label <= LABELS; label++) {
        const double *c = colours + 3 * (label - 1);
        const double most = (double)fmaxf(pixel[0], fmaxf(pixel[1], pixel[2]));
        double worst = 0;
        for (int k = 0; k < 3; k++)
            worst = fmax(worst, fabs((double)pixel[k] / most - c[k]));
        if (worst < 0.01)
            return label;
    }
    return 0;
}

static cvol_image *draw(const cvol_volume *labels, cvol_engine engine,
                        const cvol_render_options *options)
{
    cvol_volume *mask;
    cvol_array *array = NULL;
    cvol_renderer *renderer;
    cvol_transfer *transfer;
    cvol_image *image;
    assert_int_equal(cvol_labels_create_mask(context, &mask, labels), CVOL_OK);
    assert_int_equal(cvol_labels_create_mask_transfer(context, &transfer), CVOL_OK);
    if (engine == CVOL_ENGINE_SHEET)
        array = support_compress(context, mask, 8, 50);
    const cvol_source source = {
        .size = sizeof source, .array = array, .volume = array ? NULL : mask};
    assert_int_equal(cvol_renderer_create(context, &renderer, engine, &source), CVOL_OK);
    assert_int_equal(cvol_renderer_set_transfer(context, renderer, transfer), CVOL_OK);
    assert_int_equal(cvol_image_create_float(context, &image, options->width, options->height),
                     CVOL_OK);
    assert_int_equal(cvol_image_add_depth(context, image), CVOL_OK);
    assert_int_equal(cvol_renderer_render(context, renderer, image, options), CVOL_OK);
    assert_int_equal(
        cvol_image_colour_labels(context, image, labels, colours, LABELS, NULL, options), CVOL_OK);
    cvol_renderer_free(renderer);
    cvol_transfer_free(transfer);
    cvol_array_free(array);
    cvol_volume_free(mask);
    return image;
}

/* Every pixel has the colour of one label, and each label its whole extent. */
static void test_colours(void **state)
{
    (void)state;
    cvol_volume volume = make_scene();
    for (int engine = 0; engine < 2; engine++)
        for (int lit = 0; lit < 2; lit++) {
            cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, 0, 0);
            size_t pixels[LABELS + 1] = {0}, all = 0;
            options.camera.zoom = 1.7;
            options.step_voxels = 0.125; /* engine ray */
            if (lit)
                cvol_render_options_set_studio(&options);
            cvol_image *image = draw(&volume, engine ? CVOL_ENGINE_SHEET : CVOL_ENGINE_RAY,
                                     &options);
            for (size_t i = 0; i < (size_t)SIZE * SIZE; i++) {
                const float *pixel = image->values + 4 * i;
                if (!(pixel[3] > 0.5f))
                    continue;
                pixels[label_of(pixel)]++;
                all++;
            }
            /* A sample is SIZE 1.7 / (40 sqrt 3) = 3.9 pixels wide. */
            const double sample = SIZE * 1.7 / (SIDE * sqrt(3)), area = sample * sample;
            if (test_verbose())
                for (int label = 0; label <= LABELS; label++)
                    printf("engine %d, lit %d, label %d: %.1f samples\n", engine, lit, label,
                           (double)pixels[label] / area);
            assert_true(pixels[0] <= all / 100);
            assert_true(pixels[3] + pixels[4] + pixels[5] + pixels[7] + pixels[8] == 0);
            assert_true((double)pixels[PLATE] > 0.85 * 31 * 8 * area);
            assert_true((double)pixels[ROD] > 0.4 * 40 * area);
            for (int k = 0; k < 2; k++)
                assert_true(fabs((double)pixels[k ? LEFT : RIGHT] / area - 180) < 18);
            cvol_image_free(image);
        }
    free(volume.data);
}

/* At coarse levels the shape is blurred beyond the labels; no pixel has a colour that is no
 * label's.
 */
static void test_levels(void **state)
{
    (void)state;
    cvol_volume volume = make_scene();
    for (int k = 0; k < 8; k++) {
        cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, 20, 10);
        options.level = k % 4;
        options.camera.fov_deg = k < 4 ? 0 : 60;
        cvol_image *image = draw(&volume, CVOL_ENGINE_SHEET, &options);
        size_t others = 0, all = 0;
        for (size_t i = 0; i < (size_t)SIZE * SIZE; i++) {
            const float *pixel = image->values + 4 * i;
            all += pixel[3] > 0.01f;
            others += pixel[3] > 0.01f && !label_of(pixel);
        }
        if (test_verbose())
            printf("level %d: %zu of %zu\n", options.level, others, all);
        assert_true(all > SIZE * SIZE / 20 && others == 0);
        cvol_image_free(image);
    }
    free(volume.data);
}

/* A faint picture without depths, in rows of a larger one. */
static cvol_image *colour_faint(const cvol_volume *labels, const cvol_render_options *options)
{
    cvol_image *image;
    const size_t count = (size_t)options->width * (size_t)options->height;
    assert_int_equal(cvol_image_create_float(context, &image, options->width, options->height),
                     CVOL_OK);
    assert_int_equal(cvol_image_add_depth(context, image), CVOL_OK);
    for (size_t i = 0; i < 4 * count; i++)
        image->values[i] = 0.125f;
    for (size_t i = 0; i < count; i++)
        image->depth[i] = INFINITY;
    assert_int_equal(
        cvol_image_colour_labels(context, image, labels, colours, LABELS, NULL, options), CVOL_OK);
    return image;
}

/* Many rays without a depth skip blocks without labels: they find the labels that few rays find,
 * which skip none. */
static void test_skipped_blocks(void **state)
{
    enum { ROWS = 10 };
    (void)state;
    random_state random = {77};
    for (int round = 0; round < 12; round++) {
        const size_t n[3] = {1 + random_below(&random, 60), 1 + random_below(&random, 60),
                             1 + random_below(&random, 60)};
        cvol_volume volume = support_volume(n[0], n[1], n[2], CVOL_UINT8);
        const size_t count = n[0] * n[1] * n[2];
        const uint32_t some = 1 + random_below(&random, 40);
        for (size_t i = 0; i < some; i++)
            ((uint8_t *)volume.data)[random_below(&random, (uint32_t)count)] =
                (uint8_t)(1 + random_below(&random, LABELS));
        cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, 30.0 * round,
                                                     17.0 * round - 80);
        options.camera.fov_deg = round % 2 ? 40 : 0;
        cvol_image *whole = colour_faint(&volume, &options);
        size_t coloured = 0;
        for (int first = 0; first < SIZE; first += ROWS) {
            options.height = ROWS;
            options.rows = (cvol_rows){first, SIZE};
            cvol_image *part = colour_faint(&volume, &options);
            const float *same = whole->values + 4 * (size_t)first * SIZE;
            for (size_t i = 0; i < (size_t)4 * ROWS * SIZE; i++) {
                coloured += part->values[i] < 0.125f && part->values[i | 3] > 0;
                assert_true(!(part->values[i] < same[i]) && !(part->values[i] > same[i]));
            }
            cvol_image_free(part);
        }
        assert_true(coloured > 0);
        cvol_image_free(whole);
        free(volume.data);
    }
}

/* The shape is above one half where a sample has a label, and only there. */
static void test_shape(void **state)
{
    (void)state;
    const uint64_t seed = 33;
    random_state random = {seed};
    for (int round = 0; round < 20; round++) {
        const size_t n[3] = {1 + random_below(&random, 20), 1 + random_below(&random, 20),
                             1 + random_below(&random, 20)};
        cvol_volume volume = support_volume(n[0], n[1], n[2], CVOL_UINT8);
        uint8_t *labels = volume.data;
        const uint32_t rarity = 1 + random_below(&random, 8);
        cvol_volume *mask;
        for (size_t i = 0; i < n[0] * n[1] * n[2]; i++)
            labels[i] = random_below(&random, rarity) ? 0
                                                      : (uint8_t)(1 + random_below(&random, 255));
        assert_int_equal(cvol_labels_create_mask(context, &mask, &volume), CVOL_OK);
        for (size_t i = 0; i < n[0] * n[1] * n[2]; i++)
            if ((((const uint8_t *)mask->data)[i] > 127) != (labels[i] != 0))
                fail_msg("seed %llu, round %d: sample %zu", (unsigned long long)seed, round, i);
        cvol_volume_free(mask);
        free(volume.data);
    }
}

/* A plate in front of another one, both of FRONT samples: a translucent picture has the mean of
 * their colours, by what each hides. */
static void test_translucent(void **state)
{
    enum { FRONT = 8 };
    (void)state;
    cvol_volume volume = support_volume(SIDE, SIDE, SIDE, CVOL_UINT8);
    for (size_t z = 0; z < SIDE; z++)
        for (size_t y = 10; y < 10 + 2 * FRONT; y++)
            for (size_t x = 0; x < SIDE; x++)
                ((uint8_t *)volume.data)[support_index(&volume, x, y, z)] = y < 10 + FRONT ? LEFT
                                                                                           : RIGHT;
    static const double scales[] = {0.002, 0.01, 0.05};
    for (int k = 0; k < 3; k++) {
        cvol_transfer *opaque, *transfer;
        const cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, 0, 0);
        cvol_image *image;
        assert_int_equal(cvol_labels_create_mask_transfer(context, &opaque), CVOL_OK);
        assert_int_equal(cvol_transfer_create_adjusted(context, &transfer, opaque, NULL, scales[k]),
                         CVOL_OK);
        assert_int_equal(cvol_image_create_float(context, &image, SIZE, SIZE), CVOL_OK);
        assert_int_equal(cvol_image_add_depth(context, image), CVOL_OK);
        for (size_t i = 0; i < (size_t)4 * SIZE * SIZE; i++)
            image->values[i] = 1;
        assert_int_equal(
            cvol_image_colour_labels(context, image, &volume, colours, LABELS, transfer, &options),
            CVOL_OK);
        const double front = 1 - pow(1e-3, scales[k] * FRONT), behind = (1 - front) * front,
                     share = front / (front + behind);
        const float *pixel = image->values + 4 * (size_t)(SIZE / 2 * SIZE + SIZE / 2);
        for (int c = 0; c < 3; c++) {
            const double mean = share * colours[3 * (LEFT - 1) + c] +
                                (1 - share) * colours[3 * (RIGHT - 1) + c];
            if (test_verbose())
                printf("scale %g, component %d: %.4f, must be %.4f\n", scales[k], c,
                       (double)pixel[c], mean);
            assert_true(fabs((double)pixel[c] - mean) < 0.02);
        }
        cvol_image_free(image);
        cvol_transfer_free(opaque);
        cvol_transfer_free(transfer);
    }
    free(volume.data);
}

static void test_refused(void **state)
{
    (void)state;
    cvol_volume volume = support_volume(4, 4, 4, CVOL_INT16);
    cvol_volume *mask;
    cvol_image *image;
    const cvol_render_options options = support_square(8, CVOL_MODE_COMPOSITE, 0, 0);
    assert_int_equal(cvol_labels_create_mask(context, &mask, &volume), CVOL_ERROR_ARGUMENT);
    assert_null(mask);
    assert_int_equal(cvol_image_create_float(context, &image, 8, 8), CVOL_OK);
    assert_int_equal(cvol_image_colour_labels(context, image, &volume, colours, 1, NULL, &options),
                     CVOL_ERROR_ARGUMENT);
    cvol_image_free(image);
    free(volume.data);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_colours),        TEST(test_levels),
                                       TEST(test_skipped_blocks), TEST(test_shape),
                                       TEST(test_translucent),    TEST(test_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
