/* Annotations: round lengths and their units, a bar of the stated length, letters that are legible
 * on any background, and pictures of any size. */
#include "test.h"

#include "cvol/annotate.h"
#include "image/font.h"
#include "random.h"
#include "render/view/camera.h"
#include "support.h"
#include "support_context.h"

static void test_round_lengths(void **state)
{
    (void)state;
    random_state r = {5};
    for (int attempt = 0; attempt < 2000; attempt++) {
        const double most = pow(10, 12 * random_signed(&r)), length = cvol_length_round(most);
        const double digit = length / pow(10, floor(log10(length) + 1e-9));
        assert_true(length <= most * (1 + 1e-6) && length > most / 2.6);
        assert_true(fabs(digit - 1) < 1e-9 || fabs(digit - 2) < 1e-9 || fabs(digit - 5) < 1e-9);
    }
    assert_true(fabs(cvol_length_round(50) - 50) < 1e-9);
    assert_true(fabs(cvol_length_round(0.002) - 0.002) < 1e-12);
}

static void test_length_texts(void **state)
{
    (void)state;
    static const struct {
        double length;
        const char *unit, *text;
    } cases[] = {{20, "mm", "20 mm"},      {5000, "um", "5 mm"}, {500, "um", "500 µm"},
                 {0.05, "mm", "50 µm"},    {1000, "mm", "1 m"},  {0.5, "um", "500 nm"},
                 {20, "", "20"},           {0.5, "", "0.5"},     {3, "parsec", "3 parsec"},
                 {2000, "nm", "2 µm"},     {2, "cm", "2 cm"},    {0.1, "m", "100 mm"},
                 {0.001, "nm", "0.001 nm"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[64];
        cvol_length_format(text, sizeof text, cases[i].length, cases[i].unit);
        assert_string_equal(text, cases[i].text);
    }
    char tiny[4];
    cvol_length_format(tiny, sizeof tiny, 20, "mm");
    assert_int_equal(strlen(tiny), 3);
}

static double width_of(const char *text, double height)
{
    cvol_font *font;
    assert_int_equal(cvol_font_open(context, &font, height), CVOL_OK);
    const double width = cvol_text_width(font, text);
    cvol_font_free(font);
    return width;
}

static void test_text_widths(void **state)
{
    (void)state;
    assert_true(width_of("", 12) <= 0);
    assert_true(width_of("i", 12) < width_of("m", 12));
    assert_true(fabs(width_of("2500 HU", 24) - 2 * width_of("2500 HU", 12)) < 1e-4);
    assert_true(width_of("AV", 12) <
                width_of("A", 12) + width_of("V", 12)); /* they move together */
    for (char figure[2] = "0"; *figure <= '9'; ++*figure)
        assert_true(fabs(width_of(figure, 12) - width_of("0", 12)) < 1e-6);
    assert_true(width_of("\xe4\xb8\xad\xff\xf0", 12) > 0); /* unknown, and cut short */
}

/* The sum of the shares of pixels that a text covers in a black picture of SIDE x SIDE. */
enum { SIDE = 300 };

static double cover_of(const char *text, double x, double y, double height)
{
    cvol_image *image;
    cvol_font *font;
    double sum = 0;
    const cvol_pen pen = {.rgb = {1, 1, 1}, .opacity = 1, .ground_opacity = 0.5f};
    assert_int_equal(cvol_image_create_float(context, &image, SIDE, SIDE), CVOL_OK);
    assert_int_equal(cvol_font_open(context, &font, height), CVOL_OK);
    cvol_text_draw(image, font, text, x, y, &pen);
    for (int i = 0; i < SIDE * SIDE; i++)
        sum += image->values[4 * i];
    cvol_font_free(font);
    cvol_image_free(image);
    return sum;
}

/* Letters cover an area that grows with the square of their height and does not depend on the place
 * within a pixel; outside the picture they are cut. All letters of the font are drawn, at any size.
 */
static void test_letters(void **state)
{
    (void)state;
    const double one = cover_of("I", 100, 200, 40), twice = cover_of("I", 100, 200, 80);
    assert_true(one > 40 * 40 * 0.05 && one < 40 * 40 * 0.5);
    assert_true(fabs(twice / one - 4) < 0.02);
    assert_true(fabs(cover_of("I", 100.4, 200, 40) / one - 1) < 0.01);
    assert_true(cover_of("mm", -1000, 100, 40) <= 0 && cover_of("mm", 10, 1000, 40) <= 0);
    assert_true(cover_of("m", -20, 100, 40) > 0);
    for (int code = 0x20; code < 0x2270; code++) {
        const char text[4] = {(char)(0xe0 | code >> 12), (char)(0x80 | (code >> 6 & 0x3f)),
                              (char)(0x80 | (code & 0x3f)), 0};
        const char two[3] = {(char)(0xc0 | code >> 6), (char)(0x80 | (code & 0x3f)), 0};
        const char single[2] = {(char)code, 0};
        (void)cover_of(code < 0x80 ? single : code < 0x800 ? two : text, 20, 30, 10);
        code += code == 0x400 ? 0x1c00 : 0;
    }
    (void)cover_of("\xc3\x85\xc2\xb5\xce\xa9", -200, 280, 1024);
}

/* ---- pictures ----------------------------------------------------------------------------- */

static cvol_image *annotated(const cvol_annotation *of, const double *ground)
{
    cvol_image *image;
    const cvol_render_options *options = of->options;
    assert_int_equal(cvol_image_create_float(context, &image, options->width, options->height),
                     CVOL_OK);
    for (int i = 0; i < 4 * options->width * options->height && ground; i++)
        image->values[i] = i % 4 == 3 ? 1 : (float)ground[i % 4];
    assert_int_equal(cvol_image_annotate(context, image, of), CVOL_OK);
    return image;
}

static cvol_annotation make(const cvol_grid *grid, const cvol_render_options *options,
                            const cvol_transfer *transfer)
{
    return (cvol_annotation){.size = sizeof(cvol_annotation),
                             .grid = grid,
                             .options = options,
                             .transfer = transfer,
                             .range = {-3, 1000},
                             .rescale = {1, 0},
                             .value_unit = "HU"};
}

static cvol_transfer *some_transfer(void)
{
    const cvol_transfer_point points[] = {
        {-200, 1, 0, 0, 0}, {300, 0, 1, 0, 0.4}, {900, 0, 0, 1, 0.1}};
    cvol_transfer *transfer;
    assert_int_equal(cvol_transfer_create(context, &transfer, points, 3), CVOL_OK);
    return transfer;
}

/* The longest run of ink in the lower left quarter is the bar. */
static int longest_run(const cvol_image *image, float ink)
{
    int longest = 0;
    for (int y = image->height / 2; y < image->height; y++)
        for (int x = 0, run = 0; x < image->width / 2; x++) {
            const float *v = image->values + 4 * (x + image->width * y);
            run = fabsf(v[0] - ink) < 0.2f && fabsf(v[1] - ink) < 0.2f ? run + 1 : 0;
            longest = run > longest ? run : longest;
        }
    return longest;
}

static void test_scale_bar(void **state)
{
    (void)state;
    random_state r = {9};
    static const double black[3] = {0, 0, 0}, white[3] = {1, 1, 1};
    for (int attempt = 0; attempt < 30; attempt++) {
        cvol_grid grid = cvol_grid_make(10 + random_below(&r, 300), 10 + random_below(&r, 300),
                                        10 + random_below(&r, 300), CVOL_UINT8);
        cvol_render_options options = cvol_render_options_defaults();
        const int bright = attempt % 2;
        for (int a = 0; a < 3; a++)
            grid.spacing[a] = pow(10, 2 * random_signed(&r));
        options.width = 256 + (int)random_below(&r, 600);
        options.height = 256 + (int)random_below(&r, 600);
        options.camera = (cvol_camera){.azimuth_deg = 300 * random_signed(&r)};
        options.camera.elevation_deg = 90 * random_signed(&r);
        options.camera.zoom = pow(4, random_signed(&r));
        memcpy(options.background, bright ? white : black, sizeof white);
        cvol_view view;
        assert_int_equal(cvol_view_make(context, &view, &grid, &options), CVOL_OK);
        const cvol_annotation of = make(&grid, &options, NULL);
        cvol_image *image = annotated(&of, options.background);
        const double wanted = cvol_length_round(0.25 * options.width * view.pixel) / view.pixel;
        const int length = longest_run(image, bright ? 0.06f : 0.97f);
        if (fabs(length - wanted) > 5)
            fail_msg("trial %d: a bar of %d pixels, must be %g", attempt, length, wanted);
        cvol_image_free(image);
    }
}

/* Any size, any mode, any volume: nothing is drawn outside, and every pixel is valid. */
/* A patient is measured in millimetres if the file states no unit; the text says that it is an
 * assumption. Other volumes get the number alone. */
static void test_assumed_unit(void **state)
{
    (void)state;
    cvol_render_options options = cvol_render_options_defaults();
    options.width = options.height = 200;
    cvol_grid grid = cvol_grid_make(100, 90, 80, CVOL_UINT8);
    cvol_transfer *transfer = some_transfer();
    const cvol_annotation of = make(&grid, &options, transfer);
    for (int space = 0; space < 3; space++) {
        grid.space = (cvol_space)space;
        grid.unit[0] = 0;
        cvol_image *without = annotated(&of, NULL);
        snprintf(grid.unit, sizeof grid.unit, "%s", space ? "mm (assumed)" : "");
        cvol_image *with = annotated(&of, NULL);
        assert_memory_equal(without->values, with->values, 4 * 200 * 200 * sizeof(float));
        snprintf(grid.unit, sizeof grid.unit, "mm");
        cvol_image *known = annotated(&of, NULL);
        assert_memory_not_equal(without->values, known->values, 4 * 200 * 200 * sizeof(float));
        cvol_image_free(without);
        cvol_image_free(with);
        cvol_image_free(known);
    }
    cvol_transfer_free(transfer);
}

/* The scale bar has 0.05 of a unit, and the colours end at 1.5. */
static void test_locale(void **state)
{
    (void)state;
    cvol_render_options options = cvol_render_options_defaults();
    options.width = options.height = 200;
    cvol_grid grid = cvol_grid_make(100, 90, 80, CVOL_FLOAT32);
    for (int a = 0; a < 3; a++)
        grid.spacing[a] = 0.002;
    snprintf(grid.unit, sizeof grid.unit, "parsec");
    cvol_transfer *transfer = some_transfer();
    cvol_annotation of = make(&grid, &options, transfer);
    of.rescale[0] = 1.5 / 255;
    cvol_image *with_points = annotated(&of, NULL);
    char *before = support_locale_with_comma();
    cvol_image *same = annotated(&of, NULL);
    support_locale_restore(before);
    assert_memory_equal(with_points->values, same->values, 4 * 200 * 200 * sizeof(float));
    cvol_image_free(with_points);
    cvol_image_free(same);
    cvol_transfer_free(transfer);
}

static void test_any_picture(void **state)
{
    (void)state;
    static const int sizes[][2] = {{1, 1},   {1, 300},    {300, 1},   {16, 16},
                                   {64, 48}, {2048, 100}, {100, 700}, {1024, 1024}};
    cvol_transfer *transfer = some_transfer();
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++)
        for (int kind = 0; kind < 12; kind++) {
            cvol_grid grid = cvol_grid_make(1 + (size_t)kind, 7, 9, CVOL_UINT8);
            cvol_render_options options = cvol_render_options_defaults();
            options.width = sizes[k][0];
            options.height = sizes[k][1];
            options.mode = kind % 2 ? CVOL_MODE_MIP : CVOL_MODE_COMPOSITE;
            options.camera.elevation_deg = 30 * (kind % 4);
            grid.space = (cvol_space)(kind % 3);
            snprintf(grid.unit, sizeof grid.unit, "%s", kind % 5 ? "mm" : "");
            cvol_annotation of = make(&grid, &options, kind % 4 ? transfer : NULL);
            of.mirrored = kind % 2;
            of.transparent = kind > 6;
            of.rescale[0] = kind == 10 ? -2 : 1;
            if (kind == 3)
                of.range[0] = of.range[1];
            if (kind == 5)
                of.range[0] = NAN;
            cvol_image *image = annotated(&of, of.transparent ? NULL : options.background);
            for (int i = 0; i < 4 * options.width * options.height; i++)
                if (!(image->values[i] >= -1e-6f && image->values[i] <= 1 + 1e-6f))
                    fail_msg("%d x %d, kind %d: pixel %d has %g", options.width, options.height,
                             kind, i / 4, image->values[i]);
            cvol_image_free(image);
        }
    cvol_transfer_free(transfer);
}

/* The colour bar shows the function's own colours. */
static void test_colours(void **state)
{
    (void)state;
    cvol_transfer *transfer = some_transfer();
    cvol_grid grid = cvol_grid_make(20, 20, 20, CVOL_UINT8);
    cvol_render_options options = cvol_render_options_defaults();
    const cvol_annotation of = make(&grid, &options, transfer);
    cvol_image *image = annotated(&of, options.background);
    int red = 0, green = 0, blue = 0;
    for (int i = 0; i < 512 * 512; i++) {
        const float *v = image->values + 4 * i;
        red += v[0] > 0.95f && v[1] < 0.05f && v[2] < 0.05f;
        green += v[1] > 0.95f && v[0] < 0.05f && v[2] < 0.05f;
        blue += v[2] > 0.95f && v[1] < 0.05f && v[0] < 0.05f;
    }
    assert_true(red > 10 && green > 10 && blue > 10);
    cvol_image_free(image);
    cvol_transfer_free(transfer);
}

/* Ranges that begin at 1,000,000 and at 1,000,001 have other labels. */
static void test_narrow_range(void **state)
{
    (void)state;
    cvol_render_options options = cvol_render_options_defaults();
    options.mode = CVOL_MODE_MIP;
    options.width = options.height = 200;
    cvol_grid grid = cvol_grid_make(20, 20, 20, CVOL_FLOAT64);
    cvol_annotation of = make(&grid, &options, NULL);
    of.range[0] = 1e6;
    of.range[1] = 1e6 + 1;
    cvol_image *one = annotated(&of, NULL);
    of.range[0] = 1e6 + 1;
    of.range[1] = 1e6 + 2;
    cvol_image *other = annotated(&of, NULL);
    assert_memory_not_equal(one->values, other->values, 4 * 200 * 200 * sizeof(float));
    cvol_image_free(one);
    cvol_image_free(other);
}

static void test_refusals(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(20, 20, 20, CVOL_UINT8);
    cvol_render_options options = cvol_render_options_defaults();
    const cvol_annotation of = make(&grid, &options, NULL);
    cvol_image *bytes, *small;
    assert_int_equal(cvol_image_create(context, &bytes, 512, 512), CVOL_OK);
    assert_int_equal(cvol_image_create_float(context, &small, 511, 512), CVOL_OK);
    assert_int_equal(cvol_image_annotate(context, bytes, &of), CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_image_annotate(context, small, &of), CVOL_ERROR_ARGUMENT);
    options.camera.zoom = 0;
    assert_int_equal(cvol_image_annotate(context, small, &of), CVOL_ERROR_ARGUMENT);
    cvol_image_free(bytes);
    cvol_image_free(small);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_round_lengths, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_length_texts, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_text_widths, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_letters, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_scale_bar, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_assumed_unit, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_locale, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_any_picture, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_colours, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_narrow_range, context_setup, context_teardown),
        cmocka_unit_test_setup_teardown(test_refusals, context_setup, context_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
