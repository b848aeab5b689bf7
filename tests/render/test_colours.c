/* Pictures of RGB and RGBA samples: their shape, coloured by the samples along rays
 * (cvol/look.h). */
#include "test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cvol/look.h"
#include "random.h"
#include "support.h"
#include "support_context.h"
#include "support_render.h"

enum { SIDE = 24, SIZE = 64, COMPONENTS = 4 };

/* Steps of the reference, in samples. */
#define STEP 0.125

static const double pure[3 * COMPONENTS] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};

typedef struct colour_case {
    cvol_volume components[COMPONENTS];
    const cvol_volume *volumes[COMPONENTS];
    cvol_array *arrays[COMPONENTS];
    cvol_colour_source source;
    cvol_array *array; /* the shape */
    cvol_volume *volume;
    cvol_transfer *transfer;
    cvol_colours *colours;
} colour_case;

/* Three blobs in random places and colours, in the dark; alpha has blobs of its own. */
static void fill(colour_case *c, random_state *random, size_t count)
{
    double middle[3][3], strength[COMPONENTS][3];
    for (int b = 0; b < 3; b++)
        for (int a = 0; a < 3; a++)
            middle[b][a] = 6 + (SIDE - 13) * (random_signed(random) + 1) / 2;
    for (size_t k = 0; k < count; k++)
        for (int b = 0; b < 3; b++)
            strength[k][b] = 120 * (random_signed(random) + 1);
    for (size_t k = 0; k < count; k++) {
        c->components[k] = support_volume(SIDE, SIDE, SIDE, CVOL_UINT8);
        uint8_t *to = c->components[k].data;
        for (size_t i = 0; i < (size_t)SIDE * SIDE * SIDE; i++) {
            const double at[3] = {(double)(i % SIDE), (double)(i / SIDE % SIDE),
                                  (double)(i / SIDE / SIDE)};
            double most = 0;
            for (int b = 0; b < 3; b++) {
                double square = 0;
                for (int a = 0; a < 3; a++)
                    square += pow(at[a] - middle[b][a], 2);
                most = fmax(most, strength[k][b] * fmin(1, 1.6 * exp(-square / 24)));
            }
            to[i] = (uint8_t)(most + 0.5);
        }
        c->volumes[k] = &c->components[k];
    }
}

static void make(colour_case *c, random_state *random, size_t count, int is_sheet, int by_range)
{
    *c = (colour_case){.array = NULL};
    fill(c, random, count);
    for (size_t k = 0; k < count && is_sheet; k++)
        c->arrays[k] = support_compress(context, &c->components[k], 8, 60);
    c->source = (cvol_colour_source){.size = sizeof c->source,
                                     .arrays = is_sheet ? (const cvol_array *const *)c->arrays
                                                        : NULL,
                                     .volumes = is_sheet ? NULL : c->volumes,
                                     .rgb = pure,
                                     .count = count,
                                     .has_alpha = count == COMPONENTS,
                                     .range = {0, 255},
                                     .by_range = by_range};
    assert_int_equal(cvol_colours_create(context, &c->colours, &c->array, &c->volume, &c->source),
                     CVOL_OK);
    assert_int_equal(cvol_colours_create_transfer(context, &c->transfer, c->colours), CVOL_OK);
}

/* Red, green and blue of the volumes. */
static void use_volumes(colour_case *c)
{
    c->source = (cvol_colour_source){.size = sizeof c->source,
                                     .volumes = c->volumes,
                                     .rgb = pure,
                                     .count = 3,
                                     .range = {0, 255}};
    assert_int_equal(cvol_colours_create(context, &c->colours, &c->array, &c->volume, &c->source),
                     CVOL_OK);
    assert_int_equal(cvol_colours_create_transfer(context, &c->transfer, c->colours), CVOL_OK);
}

static void end(colour_case *c)
{
    cvol_colours_free(c->colours);
    cvol_transfer_free(c->transfer);
    cvol_array_free(c->array);
    cvol_volume_free(c->volume);
    for (size_t k = 0; k < COMPONENTS; k++) {
        cvol_array_free(c->arrays[k]);
        free(c->components[k].data);
    }
}

static cvol_image *draw(const colour_case *c, const cvol_render_options *options)
{
    cvol_renderer *renderer;
    cvol_image *image;
    assert_int_equal(cvol_renderer_create(context, &renderer,
                                          c->array ? CVOL_ENGINE_SHEET : CVOL_ENGINE_RAY,
                                          CVOL_SOURCE(.array = c->array, .volume = c->volume)),
                     CVOL_OK);
    assert_int_equal(cvol_renderer_set_transfer(context, renderer, c->transfer), CVOL_OK);
    assert_int_equal(cvol_image_create_float(context, &image, options->width, options->height),
                     CVOL_OK);
    assert_int_equal(cvol_image_add_depth(context, image), CVOL_OK);
    assert_int_equal(cvol_renderer_render(context, renderer, image, options), CVOL_OK);
    cvol_renderer_free(renderer);
    return image;
}

/* A component at a place, linear between samples, 0 to 1. */
static double component_at(const cvol_volume *v, const double place[3])
{
    double sum = 0;
    for (int k = 0; k < 8; k++) {
        double weight = 1;
        size_t at[3];
        for (int a = 0; a < 3; a++) {
            const double low = fmin(floor(place[a]), SIDE - 2), part = place[a] - low;
            at[a] = (size_t)low + (size_t)(k >> a & 1);
            weight *= k >> a & 1 ? part : 1 - part;
        }
        sum += weight * ((const uint8_t *)v->data)[support_index(v, at[0], at[1], at[2])];
    }
    return sum / 255;
}

/* Sums at which the shape is 0 and 255, of 1 for all components at their full value: of the least
 * sums, which are 0, and of the largest (cvol_colours). */
static void find_ends(double ends[2], const colour_case *c)
{
    const size_t count = (size_t)SIDE * SIDE * SIDE;
    ends[0] = c->source.has_alpha ? 0 : 0.02;
    ends[1] = c->source.has_alpha ? 1 : 0.5;
    if (c->source.has_alpha || c->source.by_range)
        return;
    cvol_volume sums = support_volume(SIDE, SIDE, SIDE, CVOL_UINT16);
    cvol_histogram histogram;
    cvol_transfer *fitted;
    double window[2];
    for (size_t i = 0; i < count; i++) {
        double sum = 0;
        for (size_t k = 0; k < c->source.count; k++)
            sum += ((const uint8_t *)c->components[k].data)[i] / (255. * (double)c->source.count);
        ((uint16_t *)sums.data)[i] = (uint16_t)(65535 * sum + 0.5);
    }
    assert_int_equal(cvol_volume_compute_histogram(context, &histogram, &sums), CVOL_OK);
    cvol_histogram_get_window(window, &histogram);
    assert_int_equal(cvol_transfer_create_named(context, &fitted, "auto", &histogram), CVOL_OK);
    ends[0] = 0.02 * window[1];
    for (size_t i = 1; i < cvol_transfer_count(fitted); i++)
        if (cvol_transfer_point_at(fitted, i).opacity > 0) {
            ends[0] = fmax(ends[0],
                           fmin(cvol_transfer_point_at(fitted, i - 1).value, 0.3 * window[1]));
            break;
        }
    ends[1] = (ends[0] + 0.48 * window[1]) / 65535;
    ends[0] /= 65535;
    cvol_transfer_free(fitted);
    free(sums.data);
}

/* The opacity of a sum, of 1 for all components at their full value, over a part of a sample. */
static double opacity_of(const colour_case *c, const double ends[2], double sum, double part)
{
    const cvol_transfer_point low = cvol_transfer_point_at(c->transfer, 0),
                              high = cvol_transfer_point_at(c->transfer, 1);
    const double value = 255 * (sum - ends[0]) / (ends[1] - ends[0]),
                 share = fmin(fmax((value - low.value) / (high.value - low.value), 0), 1);
    return 1 - pow(1 - share * high.opacity, part);
}

/* The mean colour of a ray along y through (x, z), in double precision; returns the opacity. */
static double reference(double rgb[3], const colour_case *c, const double ends[2], double x,
                        double z)
{
    const size_t coloured = c->source.count - (size_t)c->source.has_alpha;
    double sum = 0, left = 1;
    memset(rgb, 0, 3 * sizeof *rgb);
    for (double y = 0; y <= SIDE - 1; y += STEP) {
        const double place[3] = {x, y, z};
        double own[3] = {0}, value = 0;
        for (size_t k = 0; k < coloured; k++) {
            const double component = component_at(&c->components[k], place);
            value += component / (double)coloured;
            for (int i = 0; i < 3; i++)
                own[i] += component * pure[3 * k + (size_t)i];
        }
        if (c->source.has_alpha)
            value = component_at(&c->components[coloured], place);
        const double opacity = opacity_of(c, ends, value, STEP),
                     share = fmax(value - ends[0], 0) / (1.5 * (ends[1] - ends[0])),
                     weight = left * opacity * (c->source.has_alpha ? 1 : pow(fmin(share, 1), 2));
        for (int i = 0; i < 3; i++)
            rgb[i] += weight * own[i];
        sum += weight;
        left *= 1 - opacity;
    }
    for (int i = 0; i < 3 && sum > 0; i++)
        rgb[i] /= sum;
    return 1 - left;
}

/* Without light, pixels have the mean colours of their rays. */
static void check_case(uint64_t seed, size_t count, int is_sheet, int by_range)
{
    colour_case c;
    cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, 0, 0);
    random_state random = {seed};
    double worst = 0, error = 0;
    size_t pixels = 0;
    options.camera.zoom = 1.6;
    make(&c, &random, count, is_sheet, by_range);
    cvol_image *image = draw(&c, &options);
    assert_int_equal(cvol_image_colour_components(context, image, c.colours, c.transfer, &options),
                     CVOL_OK);
    double ends[2];
    find_ends(ends, &c);
    const double pixel = (SIDE - 1) * sqrt(3) / (1.6 * SIZE);
    for (int j = 0; j < SIZE; j++)
        for (int i = 0; i < SIZE; i++) {
            const float *is = image->values + 4 * (size_t)(j * SIZE + i);
            const double x = (SIDE - 1) / 2. + (i + 0.5 - SIZE / 2.) * pixel,
                         z = (SIDE - 1) / 2. + (SIZE / 2. - j - 0.5) * pixel;
            double rgb[3];
            if (x < 0.5 || z < 0.5 || x > SIDE - 1.5 || z > SIDE - 1.5 ||
                reference(rgb, &c, ends, x, z) < 0.3 || !(is[3] > 0.3f))
                continue;
            for (int k = 0; k < 3; k++) {
                const double off = fabs((double)(is[k] / is[3]) - rgb[k]);
                worst = fmax(worst, off);
                error += off * off;
            }
            pixels++;
        }
    error = sqrt(error / (3. * (double)pixels));
    if (test_verbose() || worst > 0.03 || error > 0.008)
        printf("seed %llu, %zu components, %s, by range %d: worst %.4f, rms %.4f of %zu pixels\n",
               (unsigned long long)seed, count, is_sheet ? "sheet" : "ray", by_range, worst, error,
               pixels);
    assert_true(pixels > 100);
    assert_true(worst <= 0.03 && error <= 0.008);
    cvol_image_free(image);
    end(&c);
}

static void test_mean_colours(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 3; seed++)
        for (size_t count = 3; count <= COMPONENTS; count++)
            for (int how = 0; how < 3;
                 how++) /* the distribution after compression is another one */
                check_case(seed, count, how == 2, how > 0);
}

/* With light, in any view, engine sheet is near engine ray; and bricks that are kept, and the
 * number of threads, change nothing. */
static void test_engines_and_threads(void **state)
{
    (void)state;
    for (uint64_t seed = 11; seed < 13; seed++) {
        cvol_image *images[3];
        for (int run = 0; run < 3; run++) {
            random_state random = {seed};
            colour_case c;
            cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE,
                                                         40. * (double)seed, 25);
            cvol_render_options_set_studio(&options);
            options.camera.fov_deg = seed % 2 ? 40 : 0;
            make(&c, &random, 3, run > 0, 1);
            cvol_context_set_threads(context, run == 2 ? 1 : 2);
            for (int again = 0; again < 1 + (run == 2); again++) {
                images[run] = draw(&c, &options);
                assert_int_equal(cvol_image_colour_components(context, images[run], c.colours,
                                                              c.transfer, &options),
                                 CVOL_OK);
                if (run == 2 && !again)
                    cvol_image_free(images[run]);
            }
            end(&c);
        }
        double error = 0;
        for (size_t i = 0; i < (size_t)4 * SIZE * SIZE; i++) {
            const double off = (double)(images[0]->values[i] - images[1]->values[i]);
            error += off * off / (4. * SIZE * SIZE);
            assert_true(images[1]->values[i] <= images[2]->values[i] &&
                        images[1]->values[i] >= images[2]->values[i]);
        }
        if (test_verbose() || 10 * log10(1 / error) < 45)
            printf("seed %llu: %.1f dB\n", (unsigned long long)seed, 10 * log10(1 / error));
        assert_true(10 * log10(1 / error) >= 45);
        for (int run = 0; run < 3; run++)
            cvol_image_free(images[run]);
    }
}

/* The bricks at the faces, and volumes of one slice, have all their samples. */
static void test_shapes(void **state)
{
    (void)state;
    static const size_t dims[][3] = {{70, 33, 65}, {40, 40, 1}, {1, 33, 33}, {64, 64, 64}};
    for (size_t d = 0; d < sizeof dims / sizeof *dims; d++) {
        colour_case c = {.array = NULL};
        const size_t *n = dims[d];
        for (size_t k = 0; k < 3; k++) {
            static const uint8_t values[3] = {200, 100, 50};
            c.components[k] = support_volume(n[0], n[1], n[2], CVOL_UINT8);
            memset(c.components[k].data, values[k], n[0] * n[1] * n[2]);
            c.volumes[k] = &c.components[k];
        }
        use_volumes(&c);
        cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, 30, 50);
        cvol_image *image = draw(&c, &options);
        assert_int_equal(
            cvol_image_colour_components(context, image, c.colours, c.transfer, &options), CVOL_OK);
        for (size_t i = 0; i < (size_t)SIZE * SIZE; i++) {
            const float *is = image->values + 4 * i;
            for (int k = 0; k < 3 && is[3] > 0.1f; k++)
                assert_true(fabs((double)(is[k] / is[3]) - (k ? k > 1 ? 50 : 100 : 200) / 255.) <
                            0.004);
        }
        cvol_image_free(image);
        end(&c);
    }
}

/* All pixels of a cube of one colour have its hue, at its silhouette in perspective, too. */
static void test_hue(void **state)
{
    (void)state;
    enum { CUBE = 40, PIXELS = 160 };
    static const uint8_t values[3] = {230, 30, 20};
    colour_case c = {.array = NULL};
    for (size_t k = 0; k < 3; k++) {
        c.components[k] = support_volume(CUBE, CUBE, CUBE, CVOL_UINT8);
        memset(c.components[k].data, values[k], (size_t)CUBE * CUBE * CUBE);
        c.arrays[k] = support_compress(context, &c.components[k], 8, 60);
    }
    c.source = (cvol_colour_source){.size = sizeof c.source,
                                    .arrays = (const cvol_array *const *)c.arrays,
                                    .rgb = pure,
                                    .count = 3,
                                    .range = {0, 255}};
    assert_int_equal(cvol_colours_create(context, &c.colours, &c.array, &c.volume, &c.source),
                     CVOL_OK);
    assert_int_equal(cvol_colours_create_transfer(context, &c.transfer, c.colours), CVOL_OK);
    for (int view = 0; view < 3; view++) {
        cvol_render_options options = support_square(PIXELS, CVOL_MODE_COMPOSITE, 30 + 50 * view,
                                                     20);
        options.camera.fov_deg = 60;
        cvol_image *image = draw(&c, &options);
        assert_int_equal(
            cvol_image_colour_components(context, image, c.colours, c.transfer, &options), CVOL_OK);
        for (size_t i = 0; i < (size_t)PIXELS * PIXELS; i++) {
            const float *is = image->values + 4 * i;
            assert_true(!(is[3] > 0.01f) || is[1] < 0.2f * is[0] + 1e-4f);
        }
        cvol_image_free(image);
    }
    end(&c);
}

/* Pictures do not depend on the unit of length. */
static void test_spacing(void **state)
{
    (void)state;
    static const double spacings[] = {1, 1e-7, 1e10};
    cvol_image *images[3];
    for (int k = 0; k < 3; k++) {
        colour_case c = {.array = NULL};
        random_state random = {3};
        fill(&c, &random, 3);
        for (int i = 0; i < 3; i++)
            for (int a = 0; a < 3; a++)
                c.components[i].grid.spacing[a] = spacings[k];
        use_volumes(&c);
        cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, 30, 20);
        images[k] = draw(&c, &options);
        assert_int_equal(
            cvol_image_colour_components(context, images[k], c.colours, c.transfer, &options),
            CVOL_OK);
        end(&c);
    }
    for (int k = 1; k < 3; k++)
        for (size_t i = 0; i < (size_t)4 * SIZE * SIZE; i++)
            assert_true(fabsf(images[k]->values[i] - images[0]->values[i]) < 0.01f);
    for (int k = 0; k < 3; k++)
        cvol_image_free(images[k]);
}

static void expect_refused(cvol_colour_source source, const char *message)
{
    cvol_colours *colours;
    cvol_array *array;
    cvol_volume *volume;
    assert_int_equal(cvol_colours_create(context, &colours, &array, &volume, &source),
                     CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), message));
    assert_true(!colours && !array && !volume);
}

static void test_errors(void **state)
{
    (void)state;
    colour_case c;
    random_state random = {1};
    make(&c, &random, 3, 0, 0);
    cvol_colour_source source = c.source;
    source.count = 5;
    expect_refused(source, "5 are given");
    source = c.source;
    source.range[1] = source.range[0];
    expect_refused(source, "from 0 to 0");
    source = c.source;
    source.volumes = NULL;
    expect_refused(source, "arrays or volumes");
    cvol_volume other = support_volume(3, 3, 3, CVOL_UINT8);
    const cvol_volume *mixed[2] = {&c.components[0], &other};
    source = c.source;
    source.volumes = mixed;
    source.count = 2;
    expect_refused(source, "component 1 has 3 x 3 x 3 samples");
    cvol_image *image;
    cvol_render_options options = support_square(SIZE, CVOL_MODE_COMPOSITE, 0, 0);
    assert_int_equal(cvol_image_create_float(context, &image, SIZE, SIZE), CVOL_OK);
    assert_int_equal(cvol_image_colour_components(context, image, c.colours, c.transfer, &options),
                     CVOL_ERROR_ARGUMENT);
    cvol_image_free(image);
    free(other.data);
    end(&c);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)
    const struct CMUnitTest tests[] = {TEST(test_mean_colours), TEST(test_engines_and_threads),
                                       TEST(test_shapes),       TEST(test_hue),
                                       TEST(test_spacing),      TEST(test_errors)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
