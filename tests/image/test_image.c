/* Pictures: PNG round trips, PNGs of every kind, broken PNGs, and differences against a direct
 * computation. */
#include "test.h"

#include <png.h>
#include <zlib.h>

#include "cvol/image.h"
#include "random.h"
#include "support.h"
#include "support_files.h"

static cvol_image *random_image(int width, int height, uint64_t seed)
{
    cvol_image *image;
    assert_int_equal(cvol_image_create(context, &image, width, height), CVOL_OK);
    random_state r = {seed};
    for (size_t i = 0; i < 4 * (size_t)width * (size_t)height; i++)
        image->rgba[i] = (uint8_t)random_below(&r, 256);
    return image;
}

static void make_opaque(cvol_image *image)
{
    for (size_t i = 0; i < (size_t)image->width * (size_t)image->height; i++)
        image->rgba[4 * i + 3] = 255;
}

static void expect_error(int code)
{
    cvol_image nothing, *image = &nothing;
    assert_int_equal(cvol_image_read_png(context, &image, file_path), code);
    assert_null(image);
    assert_non_null(strstr(cvol_context_message(context), file_path));
}

/* ---- PNG --------------------------------------------------------------------------------- */

static void expect_equal(const cvol_image *image)
{
    cvol_image *back;
    assert_int_equal(cvol_image_read_png(context, &back, file_path), CVOL_OK);
    assert_int_equal(back->width, image->width);
    assert_int_equal(back->height, image->height);
    assert_memory_equal(back->rgba, image->rgba, 4 * (size_t)image->width * (size_t)image->height);
    cvol_image_free(back);
}

/* Every compression level gives the same pixels; level 6 gives the same file. */
static void check_in_memory(const cvol_image *image, const unsigned char *file, size_t file_size)
{
    for (int level = CVOL_PNG_QUICK; level <= 9; level++) {
        void *bytes;
        size_t size;
        assert_int_equal(cvol_image_encode_png(context, image, level, &bytes, &size), CVOL_OK);
        if (level == 6) {
            assert_int_equal(size, file_size);
            assert_memory_equal(bytes, file, size);
        }
        support_write(file_path, bytes, size);
        free(bytes);
        expect_equal(image);
    }
}

/* Byte 25 of a PNG is its colour type: 2 RGB, 6 RGBA. */
static void check_round_trip(cvol_image *image, int colour_type)
{
    assert_int_equal(cvol_image_write_png(context, image, file_path), CVOL_OK);
    size_t size;
    unsigned char *file = support_read(file_path, &size);
    assert_int_equal(file[25], colour_type);
    expect_equal(image);
    check_in_memory(image, file, size);
    free(file);
    assert_int_equal(support_folder_count(folder), 1);
}

static void test_round_trip(void **state)
{
    (void)state;
    const int sizes[][2] = {{1, 1}, {1, 300}, {300, 1}, {37, 23}, {256, 64}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        cvol_image *image = random_image(sizes[i][0], sizes[i][1], i);
        image->rgba[3] = 7;
        check_round_trip(image, PNG_COLOR_TYPE_RGB_ALPHA);
        make_opaque(image);
        check_round_trip(image, PNG_COLOR_TYPE_RGB);
        cvol_image_free(image);
    }
}

/* A PNG of any kind by libpng itself: `rows` holds its rows packed, one after the other. */
static void write_any(const char *path, int width, int height, int depth, int colour_type,
                      int interlace, uint8_t *rows)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, file);
    png_set_IHDR(png, info, (png_uint_32)width, (png_uint_32)height, depth, colour_type, interlace,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (colour_type == PNG_COLOR_TYPE_PALETTE) {
        const png_color palette[4] = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {9, 8, 7}};
        const png_byte alpha[2] = {255, 77};
        png_set_PLTE(png, info, palette, 4);
        png_set_tRNS(png, info, alpha, 2, NULL);
    }
    png_write_info(png, info);
    int passes = png_set_interlace_handling(png);
    size_t stride = png_get_rowbytes(png, info);
    for (int pass = 0; pass < passes; pass++)
        for (int j = 0; j < height; j++)
            png_write_row(png, rows + (size_t)j * stride);
    png_write_end(png, NULL);
    png_destroy_write_struct(&png, &info);
    fclose(file);
}

static void expect_pixels(const uint8_t *rgba, size_t count)
{
    cvol_image *image;
    int code = cvol_image_read_png(context, &image, file_path);
    assert_string_equal(cvol_context_message(context), "");
    assert_int_equal(code, CVOL_OK);
    assert_int_equal((size_t)image->width * (size_t)image->height, count);
    assert_memory_equal(image->rgba, rgba, 4 * count);
    cvol_image_free(image);
}

static void test_every_kind_is_read(void **state)
{
    (void)state;
    write_any(file_path, 4, 1, 2, PNG_COLOR_TYPE_PALETTE, PNG_INTERLACE_NONE, (uint8_t[]){0x1b});
    expect_pixels((uint8_t[]){255, 0, 0, 255, 0, 255, 0, 77, 0, 0, 255, 255, 9, 8, 7, 255}, 4);
    write_any(file_path, 2, 2, 1, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, (uint8_t[]){0x80, 0x40});
    expect_pixels((uint8_t[]){255, 255, 255, 255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255, 255},
                  4);
    write_any(file_path, 2, 1, 16, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
              (uint8_t[]){0x80, 0x80, 0xff, 0xff});
    expect_pixels((uint8_t[]){128, 128, 128, 255, 255, 255, 255, 255}, 2);
    write_any(file_path, 2, 1, 8, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_INTERLACE_NONE,
              (uint8_t[]){5, 6, 7, 8});
    expect_pixels((uint8_t[]){5, 5, 5, 6, 7, 7, 7, 8}, 2);
    write_any(file_path, 1, 1, 16, PNG_COLOR_TYPE_RGB_ALPHA, PNG_INTERLACE_NONE,
              (uint8_t[]){1, 1, 2, 2, 3, 3, 4, 4});
    expect_pixels((uint8_t[]){1, 2, 3, 4}, 1);
    cvol_image *image = random_image(19, 21, 5);
    write_any(file_path, 19, 21, 8, PNG_COLOR_TYPE_RGB_ALPHA, PNG_INTERLACE_ADAM7, image->rgba);
    expect_pixels(image->rgba, 19 * 21);
    cvol_image_free(image);
}

static void test_every_truncation_fails(void **state)
{
    (void)state;
    cvol_image *image = random_image(9, 11, 1);
    assert_int_equal(cvol_image_write_png(context, image, file_path), CVOL_OK);
    cvol_image_free(image);
    size_t size;
    unsigned char *file = support_read(file_path, &size);
    for (size_t length = 0; length < size; length++) {
        support_write(file_path, file, length);
        expect_error(CVOL_ERROR_FORMAT);
    }
    free(file);
}

/* Any changed byte: an error or a picture, never a crash. */
static void test_damage_does_not_crash(void **state)
{
    (void)state;
    cvol_image *image = random_image(9, 11, 1), *back;
    assert_int_equal(cvol_image_write_png(context, image, file_path), CVOL_OK);
    cvol_image_free(image);
    size_t size;
    unsigned char *file = support_read(file_path, &size);
    for (size_t i = 0; i < size; i++) {
        file[i] ^= 0x11;
        support_write(file_path, file, size);
        if (!cvol_image_read_png(context, &back, file_path))
            cvol_image_free(back);
        else
            assert_null(back);
        file[i] ^= 0x11;
    }
    free(file);
}

static void test_no_png(void **state)
{
    (void)state;
    expect_error(CVOL_ERROR_IO);
    support_write_text(file_path, "");
    expect_error(CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context), "is empty"));
    support_write_text(file_path, "GIF89a, or anything else that is long enough");
    expect_error(CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context), "is not a PNG file"));
    char *path = file_path;
    file_path = folder;
    expect_error(CVOL_ERROR_IO);
    file_path = path;
}

static void put_u32(uint8_t *out, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        out[i] = (uint8_t)(value >> (24 - 8 * i));
}

/* A PNG whose header states this size, without data. */
static void write_claim(const char *path, uint32_t width, uint32_t height)
{
    /* Signature; length, name, 13 bytes and checksum of IHDR; an empty IDAT. */
    uint8_t file[8 + 25 + 12] = {0x89, 'P', 'N', 'G', 13, 10, 26, 10, 0, 0, 0, 13};
    memcpy(file + 12, "IHDR", 4);
    put_u32(file + 16, width);
    put_u32(file + 20, height);
    file[24] = 8;
    file[25] = PNG_COLOR_TYPE_RGB_ALPHA;
    put_u32(file + 29, (uint32_t)crc32(0, file + 12, 17));
    memcpy(file + 37, "IDAT", 4);
    put_u32(file + 41, (uint32_t)crc32(0, file + 37, 4));
    support_write(path, file, sizeof file);
}

static void test_sizes_are_limited(void **state)
{
    (void)state;
    write_claim(file_path, 40000, 1);
    expect_error(CVOL_ERROR_LIMIT);
    write_claim(file_path, 1, 40000);
    expect_error(CVOL_ERROR_LIMIT);
    write_claim(file_path, 30000, 30000);
    expect_error(CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context), "30000 x 30000"));
    write_claim(file_path, 0, 10);
    expect_error(CVOL_ERROR_FORMAT);
    cvol_context_set_limit_bytes(context, 1000);
    write_claim(file_path, 40, 40);
    expect_error(CVOL_ERROR_LIMIT);
}

static void test_write_failures_leave_nothing(void **state)
{
    (void)state;
    cvol_image *image = random_image(8, 8, 2);
    char *missing = support_path(folder, "no/such/folder.png");
    assert_int_equal(cvol_image_write_png(context, image, missing), CVOL_ERROR_IO);
    assert_int_equal(cvol_image_write_png(context, image, folder), CVOL_ERROR_IO);
    assert_int_equal(support_folder_count(folder), 0);
    void *bytes;
    size_t size;
    for (int level = -2; level <= 10; level += 12) {
        assert_int_equal(cvol_image_encode_png(context, image, level, &bytes, &size),
                         CVOL_ERROR_ARGUMENT);
        assert_null(bytes);
        assert_non_null(strstr(cvol_context_message(context), "must be 0 to 9, or -1"));
    }
    image->width = 0;
    assert_int_equal(cvol_image_write_png(context, image, file_path), CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_image_encode_png(context, image, 6, &bytes, &size), CVOL_ERROR_ARGUMENT);
    free(missing);
    cvol_image_free(image);
}

static void test_create(void **state)
{
    (void)state;
    cvol_image *image;
    const int bad[][2] = {{0, 1}, {1, 0}, {-1, 5}, {CVOL_IMAGE_SIZE_MAX + 1, 1}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_int_equal(cvol_image_create(context, &image, bad[i][0], bad[i][1]),
                         CVOL_ERROR_ARGUMENT);
        assert_null(image);
    }
    assert_int_equal(cvol_image_create(context, &image, 3, 2), CVOL_OK);
    for (int i = 0; i < 24; i++)
        assert_int_equal(image->rgba[i], 0);
    cvol_image_free(image);
    cvol_image_free(NULL);
}

/* ---- differences ------------------------------------------------------------------------- */

/* One window of one channel, by the definition, in two passes. */
static double naive_window(const cvol_image *a, const cvol_image *b, int x, int y, int wx, int wy,
                           int channel)
{
    double n = wx * wy, ma = 0, mb = 0, va = 0, vb = 0, cab = 0;
    for (int pass = 0; pass < 2; pass++)
        for (int j = y; j < y + wy; j++)
            for (int i = x; i < x + wx; i++) {
                double p = a->rgba[4 * (j * a->width + i) + channel];
                double q = b->rgba[4 * (j * b->width + i) + channel];
                if (pass == 0) {
                    ma += p / n;
                    mb += q / n;
                } else if (n > 1) {
                    va += (p - ma) * (p - ma) / (n - 1);
                    vb += (q - mb) * (q - mb) / (n - 1);
                    cab += (p - ma) * (q - mb) / (n - 1);
                }
            }
    double c1 = 2.55 * 2.55, c2 = 7.65 * 7.65;
    return (2 * ma * mb + c1) * (2 * cab + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
}

static double naive_ssim(const cvol_image *a, const cvol_image *b)
{
    int wx = a->width < 7 ? a->width : 7, wy = a->height < 7 ? a->height : 7, count = 0;
    double sum = 0;
    for (int c = 0; c < 3; c++)
        for (int y = 0; y + wy <= a->height; y++)
            for (int x = 0; x + wx <= a->width; x++, count++)
                sum += naive_window(a, b, x, y, wx, wy, c);
    return sum / count;
}

static void test_ssim_equals_naive(void **state)
{
    (void)state;
    const int sizes[][2] = {{40, 31}, {7, 7}, {8, 7}, {1, 1}, {3, 20}, {20, 2}, {6, 6}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        cvol_image *a = random_image(sizes[i][0], sizes[i][1], 10 + i);
        cvol_image *b = random_image(sizes[i][0], sizes[i][1], 90 + i);
        for (size_t k = 0; k < 4 * (size_t)(a->width * a->height); k++)
            b->rgba[k] = (uint8_t)((3 * a->rgba[k] + b->rgba[k]) / 4);
        cvol_image_difference d, one;
        assert_int_equal(cvol_image_compare(context, &d, a, b), CVOL_OK);
        assert_true(fabs(d.ssim - naive_ssim(a, b)) < 1e-9);
        cvol_context_set_threads(context, 1);
        assert_int_equal(cvol_image_compare(context, &one, a, b), CVOL_OK);
        assert_memory_equal(&d, &one, sizeof d);
        cvol_context_set_threads(context, 3);
        cvol_image_free(a);
        cvol_image_free(b);
    }
}

static void test_known_values(void **state)
{
    (void)state;
    cvol_image *a, *b;
    cvol_image_create(context, &a, 10, 10);
    cvol_image_create(context, &b, 10, 10);
    cvol_image_difference d;
    assert_int_equal(cvol_image_compare(context, &d, a, b), CVOL_OK);
    assert_true(isinf(d.psnr_db) && isinf(d.psnr_foreground_db) && d.rmse == 0);
    assert_true(d.ssim == 1 && d.foreground_pixels == 0 && d.max_abs_error == 0);
    b->rgba[4 * 17 + 1] = 30;
    b->rgba[4 * 18 + 2] = 2;   /* not above 2: no foreground */
    b->rgba[4 * 19 + 3] = 200; /* alpha does not count */
    a->rgba[4 * 20] = b->rgba[4 * 20] = 3;
    assert_int_equal(cvol_image_compare(context, &d, a, b), CVOL_OK);
    assert_true(fabs(d.rmse - sqrt(904.0 / 300)) < 1e-12);
    assert_true(fabs(d.psnr_db - 10 * log10(65025 * 300 / 904.0)) < 1e-9);
    assert_true(fabs(d.psnr_foreground_db - 10 * log10(65025 * 6 / 900.0)) < 1e-9);
    assert_int_equal(d.foreground_pixels, 2);
    assert_true(d.max_abs_error == 30);
    cvol_image_free(a);
    cvol_image_free(b);
}

static void test_sizes_must_agree(void **state)
{
    (void)state;
    cvol_image *a = random_image(10, 12, 0), *b = random_image(12, 10, 0);
    cvol_image_difference d;
    assert_int_equal(cvol_image_compare(context, &d, a, b), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "10 x 12 and 12 x 10"));
    cvol_image_free(a);
    cvol_image_free(b);
}

static void test_light_adds_up(void **state)
{
    (void)state;
    const double orange[3] = {1, 0.5, 0};
    cvol_image *sum, *one, *other;
    assert_int_equal(cvol_image_create_float(context, &sum, 1, 1), CVOL_OK);
    assert_int_equal(cvol_image_create_float(context, &one, 1, 1), CVOL_OK);
    assert_int_equal(cvol_image_create_float(context, &other, 2, 1), CVOL_OK);
    const float colour[4] = {0.75f, 0.25f, 0.5f, 0.5f};
    memcpy(one->values, colour, sizeof colour);
    assert_int_equal(cvol_image_add_light(context, sum, one, NULL), CVOL_OK);
    assert_memory_equal(sum->values, colour, sizeof colour);
    assert_int_equal(cvol_image_add_light(context, sum, one, NULL), CVOL_OK);
    const float twice[4] = {1, 0.5f, 1, 0.75f}; /* clipped; opacities as layers */
    assert_memory_equal(sum->values, twice, sizeof twice);
    memset(sum->values, 0, sizeof twice);
    assert_int_equal(cvol_image_add_light(context, sum, one, orange), CVOL_OK);
    const float grey[4] = {0.75f, 0.125f, 0, 0.5f};
    assert_memory_equal(sum->values, grey, sizeof grey);
    assert_int_equal(cvol_image_add_light(context, sum, other, NULL), CVOL_ERROR_ARGUMENT);
    cvol_image_free(sum);
    cvol_image_free(one);
    cvol_image_free(other);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, files_setup, files_teardown)
    const struct CMUnitTest tests[] = {
        TEST(test_round_trip),
        TEST(test_every_kind_is_read),
        TEST(test_every_truncation_fails),
        TEST(test_damage_does_not_crash),
        TEST(test_no_png),
        TEST(test_sizes_are_limited),
        TEST(test_write_failures_leave_nothing),
        TEST(test_create),
        TEST(test_light_adds_up),
        TEST(test_ssim_equals_naive),
        TEST(test_known_values),
        TEST(test_sizes_must_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
