/* Compressed pictures: round trips, targets, bounds, and cut, flipped, invalid and fuzzed files. */
#include "test.h"

#include "base/context.h"
#include "codec/section/signature.h"
#include "fuzz/fuzz_cvol.c"
#include "image/picture.h"
#include "random.h"
#include "support.h"
#include "support_context.h"

/* Coloured blobs on black, with some noise; alpha: opaque only in the middle. */
static cvol_image *make_image(int width, int height, int grey, int alpha, uint64_t seed)
{
    cvol_image *image;
    random_state r = {seed};
    assert_int_equal(cvol_image_create(context, &image, width, height), CVOL_OK);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const double u = (x + 0.5) / width - 0.5, v = (y + 0.5) / height - 0.5;
            const double inside = 1 / (1 + exp(40 * (sqrt(u * u + v * v) - 0.35)));
            uint8_t *pixel = image->rgba + 4 * ((size_t)y * (size_t)width + (size_t)x);
            for (int c = 0; c < 3; c++) {
                const double wave = 0.6 + 0.3 * sin((grey ? 9 : 9 + 5 * c) * u + 7 * v);
                pixel[c] = (uint8_t)(255 * inside * wave + random_below(&r, 3));
            }
            if (grey)
                pixel[1] = pixel[2] = pixel[0];
            pixel[3] = alpha ? (uint8_t)(255 * inside + 0.5) : 255;
        }
    return image;
}

static cvol_bytes bytes_of(const cvol_picture *picture)
{
    cvol_bytes bytes = {0};
    assert_int_equal(cvol_picture_put(context, &bytes, picture), CVOL_OK);
    return bytes;
}

static void expect_same(const cvol_image *a, const cvol_image *b)
{
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_memory_equal(a->rgba, b->rgba, 4 * (size_t)a->width * (size_t)a->height);
}

/* Writes, reads, and writes again: the same bytes and pixels. */
static void check_round_trip(const cvol_picture *picture)
{
    cvol_bytes first = bytes_of(picture);
    cvol_picture *read;
    cvol_image *before, *after;
    assert_int_equal(cvol_picture_take(context, &read, first.data, first.size, "test"), CVOL_OK);
    cvol_bytes second = bytes_of(read);
    assert_int_equal(first.size, second.size);
    assert_memory_equal(first.data, second.data, first.size);
    assert_int_equal(cvol_picture_evaluate(context, &before, picture), CVOL_OK);
    cvol_context_set_threads(context, 3);
    assert_int_equal(cvol_picture_evaluate(context, &after, read), CVOL_OK);
    cvol_context_set_threads(context, 0);
    expect_same(before, after);
    cvol_image_free(before);
    cvol_image_free(after);
    cvol_picture_free(read);
    cvol_bytes_free(&first);
    cvol_bytes_free(&second);
}

/* ---- pixels --------------------------------------------------------------------------------- */

static void test_targets(void **state)
{
    static const int blocks[] = {0, 8, 16, 32};
    static const double psnrs[] = {25, 40, 60}, ratios[] = {5, 30, 100};
    (void)state;
    cvol_image *image = make_image(131, 97, 0, 0, 1);
    for (int transform = CVOL_DCT; transform <= CVOL_DFT; transform++)
        for (int b = 0; b < 4; b++) {
            cvol_picture_options options = {.size = sizeof(cvol_picture_options),
                                            .transform = (cvol_transform)transform,
                                            .block = blocks[b]};
            /* Three PSNRs and three ratios for the usual kind of picture, one of each for the
             * others. */
            const int usual = transform == CVOL_DCT && blocks[b] == 16;
            for (int i = usual ? 0 : 1; i < 6; i += usual ? 1 : 3) {
                cvol_picture *picture;
                cvol_picture_info info;
                cvol_image *pixels;
                cvol_image_difference d;
                options.ratio = i < 3 ? 0 : ratios[i - 3];
                options.psnr_db = i < 3 ? psnrs[i] : 0;
                assert_int_equal(cvol_picture_compress(context, &picture, image, &options),
                                 CVOL_OK);
                assert_int_equal(cvol_picture_get_info(context, &info, picture), CVOL_OK);
                assert_int_equal(cvol_picture_evaluate(context, &pixels, picture), CVOL_OK);
                assert_int_equal(cvol_image_compare(context, &d, image, pixels), CVOL_OK);
                assert_true(fabs(d.psnr_db - info.psnr_db) < 1e-9);
                if (i < 3)
                    assert_true(d.psnr_db >= psnrs[i] && d.psnr_db < psnrs[i] + 1);
                else if (info.ratio < options.ratio || info.ratio > 1.15 * options.ratio)
                    fail_msg("transform %d, block %d: ratio %g, asked %g", transform, blocks[b],
                             info.ratio, options.ratio);
                check_round_trip(picture);
                cvol_image_free(pixels);
                cvol_picture_free(picture);
            }
        }
    cvol_image_free(image);
}

static void test_shapes(void **state)
{
    static const int sizes[][2] = {{1, 1}, {1, 40}, {17, 1}, {3, 5}, {16, 16}, {33, 64}};
    (void)state;
    for (int s = 0; s < 6; s++)
        for (int kind = 0; kind < 4; kind++) {
            cvol_image *image = make_image(sizes[s][0], sizes[s][1], kind & 1, kind & 2, 7), *out;
            cvol_picture_options options = cvol_picture_options_defaults();
            cvol_picture *picture;
            options.psnr_db = 50;
            assert_int_equal(cvol_picture_compress(context, &picture, image, &options), CVOL_OK);
            assert_int_equal(cvol_picture_evaluate(context, &out, picture), CVOL_OK);
            double squares = 0;
            const size_t bytes = 4 * (size_t)image->width * (size_t)image->height;
            for (size_t i = 0; i < bytes; i++)
                squares += pow(image->rgba[i] - out->rgba[i], 2);
            assert_true(sqrt(squares / (0.75 * (double)bytes)) <= 255 * pow(10, -50 / 20.0) + 1e-9);
            check_round_trip(picture);
            cvol_image_free(image);
            cvol_image_free(out);
            cvol_picture_free(picture);
        }
}

/* A grey picture takes one plane, and little more than that. */
static void test_grey_is_one_plane(void **state)
{
    (void)state;
    cvol_image *image = make_image(96, 96, 1, 0, 5);
    const cvol_picture_options options = cvol_picture_options_defaults();
    cvol_picture *picture;
    cvol_array_info info[3];
    assert_int_equal(cvol_picture_compress(context, &picture, image, &options), CVOL_OK);
    for (int c = 0; c < 3; c++)
        cvol_array_get_info(&info[c], cvol_picture_plane(picture, c));
    assert_true(info[0].coefficients > 50);
    assert_int_equal(info[1].coefficients + info[2].coefficients, 0);
    assert_null(cvol_picture_plane(picture, 3));
    cvol_picture_free(picture);
    cvol_image_free(image);
}

/* Planes on another lattice than the pixels, composited over a background; and the certified
 * bound. */
static void test_lattice(void **state)
{
    enum { P = 60, Q = 45 };
    static float planes[4][P * Q];
    random_state r = {11};
    (void)state;
    for (int c = 0; c < 4; c++)
        for (int i = 0; i < P * Q; i++)
            planes[c][i] = (float)(0.4 + 0.2 * sin(0.2 * (i % P) + c) * cos(0.15 * i / P) +
                                   0.05 * random_signed(&r));
    cvol_picture_source from = {.planes = {planes[0], planes[1], planes[2], planes[3]},
                                .lattice = {P, Q},
                                .width = 150,
                                .height = 110,
                                .is_over = 1,
                                .background = {0.2, 0, 0.7},
                                .to_intermediate = {{0.4, 0.1, -3}, {-0.1, 0.45, 4}}};
    const cvol_picture_options options = {
        .size = sizeof(cvol_picture_options), .transform = CVOL_DFT, .psnr_db = 35};
    cvol_picture *picture;
    cvol_picture_info info;
    const size_t begin[3] = {0, 0, 0}, end[3] = {P, Q, 1};
    static float got[3][P * Q];
    double squares = 0;
    assert_int_equal(cvol_picture_make(context, &picture, &from, &options), CVOL_OK);
    assert_int_equal(cvol_picture_get_info(context, &info, picture), CVOL_OK);
    assert_true(info.psnr_db >= 35 && info.psnr_db < 36);
    check_round_trip(picture);
    for (int c = 0; c < 3; c++)
        assert_int_equal(
            cvol_array_evaluate_real(context, got[c], cvol_picture_plane(picture, c), begin, end),
            CVOL_OK);
    for (int i = 0; i < P * Q; i++) {
        const double a = planes[0][i], b = planes[1][i], c = planes[2][i];
        squares += pow((a + b + c) / sqrt(3) - (double)got[0][i], 2) +
                   pow((a - c) / sqrt(2) - (double)got[1][i], 2) +
                   pow((a - 2 * b + c) / sqrt(6) - (double)got[2][i], 2);
    }
    assert_true(sqrt(squares) <= info.l2_error);
    assert_true(sqrt(squares) > 0.5 * info.l2_error);
    cvol_picture_free(picture);
}

static void test_refusals(void **state)
{
    (void)state;
    cvol_image *image = make_image(20, 20, 0, 0, 2);
    cvol_picture *picture;
    cvol_picture_options options = cvol_picture_options_defaults();
    options.ratio = 1e6;
    assert_int_equal(cvol_picture_compress(context, &picture, image, &options), CVOL_ERROR_TARGET);
    assert_null(picture);
    options.ratio = 0.5;
    assert_int_equal(cvol_picture_compress(context, &picture, image, &options),
                     CVOL_ERROR_ARGUMENT);
    options.ratio = 0;
    options.psnr_db = -3;
    assert_int_equal(cvol_picture_compress(context, &picture, image, &options),
                     CVOL_ERROR_ARGUMENT);
    options = cvol_picture_options_defaults();
    options.block = 5;
    assert_int_equal(cvol_picture_compress(context, &picture, image, &options),
                     CVOL_ERROR_ARGUMENT);
    cvol_image_free(image);
}

/* ---- numbers of any size -------------------------------------------------------------------- */

static void test_numbers(void **state)
{
    random_state r = {77};
    (void)state;
    for (int n = 0; n < 60; n++) {
        const cvol_plane_shape shape = {{1 + random_below(&r, 50), 1 + random_below(&r, 50)},
                                        (cvol_transform)(1 + random_below(&r, 3)),
                                        n % 4 ? 4 << n % 4 : 0};
        const size_t count = (size_t)cvol_plane_places(&shape);
        const uint32_t rare = 1 + random_below(&r, 40), bits = random_below(&r, 30);
        int32_t *values = malloc(count * sizeof *values), *copy = malloc(count * sizeof *copy);
        assert_true(values && copy);
        for (size_t i = 0; i < count; i++) {
            values[i] = random_below(&r, rare) ? 0 : (int32_t)random_below(&r, (1u << bits) + 1);
            values[i] = random_u64(&r) & 1 ? -values[i] : values[i];
        }
        memcpy(copy, values, count * sizeof *copy);
        cvol_tile_contexts contexts;
        cvol_range_encoder encoder = {0};
        cvol_range_decoder decoder;
        cvol_bytes bytes = {0};
        cvol_tile_contexts_start(&contexts);
        cvol_range_encoder_start(&encoder);
        cvol_tile_coder coder = {.encoder = &encoder, .contexts = &contexts};
        assert_true(cvol_plane_code(&coder, copy, NULL, &shape));
        assert_memory_equal(values, copy, count * sizeof *values);
        assert_true(cvol_range_encoder_finish(&encoder, &bytes));
        cvol_range_encoder_free(&encoder);
        cvol_tile_contexts_start(&contexts);
        cvol_range_decoder_start(&decoder, bytes.data, bytes.size);
        coder = (cvol_tile_coder){.decoder = &decoder, .contexts = &contexts};
        memset(copy, 1, count * sizeof *copy);
        if (!cvol_plane_code(&coder, copy, NULL, &shape) || cvol_range_decoder_overrun(&decoder) ||
            memcmp(values, copy, count * sizeof *values))
            fail_msg("seed 77, case %d: what was coded must come back", n);
        cvol_bytes_free(&bytes);
        free(values);
        free(copy);
    }
}

/* ---- damage --------------------------------------------------------------------------------- */

static cvol_bytes small_file(int alpha)
{
    cvol_image *image = make_image(37, 29, 0, alpha, 3);
    const cvol_picture_options options = cvol_picture_options_defaults();
    cvol_picture *picture;
    assert_int_equal(cvol_picture_compress(context, &picture, image, &options), CVOL_OK);
    cvol_bytes bytes = bytes_of(picture);
    cvol_picture_free(picture);
    cvol_image_free(image);
    return bytes;
}

static void expect_refused(const uint8_t *data, size_t size, const char *what)
{
    cvol_picture *picture;
    cvol_file_layout layout;
    const int code = cvol_picture_take(context, &picture, data, size, "bad.cvi");
    if (!code || !strstr(cvol_context_message(context), "bad.cvi"))
        fail_msg("%s: code %d, '%s'", what, code, cvol_context_message(context));
    assert_null(picture);
    assert_true(cvol_layout_verify(context, &layout, data, size, "bad.cvi") != CVOL_OK);
}

static void test_cut_and_flipped(void **state)
{
    (void)state;
    cvol_bytes file = small_file(1);
    char what[64];
    for (size_t size = 0; size < file.size; size++) {
        uint8_t *cut = malloc(size + 1); /* separate, so that sanitizers detect reads beyond it */
        memcpy(cut, file.data, size);
        snprintf(what, sizeof what, "cut to %zu bytes", size);
        expect_refused(cut, size, what);
        free(cut);
    }
    for (size_t at = 0; at < file.size; at++) {
        file.data[at] ^= (uint8_t)(1 << at % 8);
        snprintf(what, sizeof what, "byte %zu flipped", at);
        expect_refused(file.data, file.size, what);
        file.data[at] ^= (uint8_t)(1 << at % 8);
    }
    cvol_bytes_append(&file, "x", 1);
    expect_refused(file.data, file.size, "a byte more");
    cvol_bytes_free(&file);
}

/* Invalid fields under valid checksums. */
static void test_lies(void **state)
{
    enum { HEAD = CVOL_SECTIONS_AT + CVOL_SECTION_HEADER_BYTES };
    static const struct {
        size_t at;
        uint32_t value;
    } lies[] = {{0, 0},
                {0, 40000},
                {4, 0},
                {4, 0xFFFFFFFF},
                {8, 0},
                {8, 70000},
                {12, 0},
                {8, 60000},
                {16, 0},
                {16, 4},
                {20, 4},
                {20, 64},
                {24, 2},
                {24, 5},
                {28, 2},
                {36, 0x7FF00000},
                {84, 0x40000000},
                {84, 0xBFF00000},
                {108, 0x7FF80000},
                {116, 0},
                {116, 0xBFF00000},
                {116, 0x7FF00000},
                {124, 0x7FF00000},
                {132, 0x7FF00000}};
    (void)state;
    cvol_bytes file = small_file(1);
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        uint8_t *copy = malloc(file.size);
        char what[64];
        memcpy(copy, file.data, file.size);
        fuzz_put_u32(copy + HEAD + lies[i].at, lies[i].value);
        fuzz_repair(copy, file.size);
        snprintf(what, sizeof what, "field %zu is %x", lies[i].at, lies[i].value);
        if (lies[i].at == 116 && !lies[i].value) /* a step slightly above 0 is valid */
            fuzz_put_u32(copy + HEAD + 112, 0), fuzz_repair(copy, file.size);
        expect_refused(copy, file.size, what);
        free(copy);
    }
    cvol_bytes_free(&file);
}

/* Other files are not pictures, and pictures are not other files; each message names the kind. */
static void test_kinds(void **state)
{
    (void)state;
    cvol_bytes file = small_file(0);
    cvol_array *array;
    cvol_picture *picture;
    assert_int_equal(cvol_plane_file_kind(file.data, file.size), CVOL_FILE_PICTURE);
    assert_int_equal(cvol_container_read(context, &array, file.data, file.size, "a.cvi"),
                     CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context), "a.cvi: is a compressed picture"));
    assert_int_equal(
        cvol_picture_take(context, &picture, (const uint8_t *)"\x89PNG\r\n\x1a\n", 8, "a.png"),
        CVOL_ERROR_FORMAT);
    cvol_bytes_free(&file);
}

static void test_fuzz(void **state)
{
    random_state r = {2003};
    (void)state;
    for (int alpha = 0; alpha < 2; alpha++) {
        cvol_bytes file = small_file(alpha);
        uint8_t *copy = malloc(file.size);
        for (int i = 0; i < 400; i++) {
            memcpy(copy, file.data, file.size);
            for (uint32_t n = 1 + random_below(&r, 4); n; n--)
                copy[random_below(&r, (uint32_t)file.size)] = (uint8_t)random_u64(&r);
            LLVMFuzzerTestOneInput(copy, file.size);
            LLVMFuzzerTestOneInput(copy, random_below(&r, (uint32_t)file.size));
        }
        free(copy);
        cvol_bytes_free(&file);
    }
}

static void test_files(void **state)
{
    (void)state;
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvi");
    cvol_image *image = make_image(40, 30, 0, 0, 9);
    const cvol_picture_options options = cvol_picture_options_defaults();
    cvol_picture *picture, *read;
    uint64_t bytes;
    cvol_picture_info info;
    assert_int_equal(cvol_picture_compress(context, &picture, image, &options), CVOL_OK);
    assert_int_equal(cvol_picture_write(context, picture, path, &bytes), CVOL_OK);
    assert_int_equal(cvol_picture_get_info(context, &info, picture), CVOL_OK);
    assert_int_equal(info.file_bytes, bytes);
    assert_int_equal(cvol_file_kind_of(path), CVOL_FILE_PICTURE);
    assert_int_equal(cvol_file_verify(context, NULL, path), CVOL_OK);
    assert_int_equal(cvol_picture_read(context, &read, path), CVOL_OK);
    cvol_picture_free(read);
    assert_int_equal(cvol_picture_write(context, picture, "/no/such/folder/a.cvi", NULL),
                     CVOL_ERROR_IO);
    assert_int_equal(cvol_picture_read(context, &read, "/no/such/file.cvi"), CVOL_ERROR_IO);
    assert_int_equal(support_folder_count(folder), 1);
    cvol_picture_free(picture);
    cvol_image_free(image);
    free(path);
    support_folder_remove(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_targets),
        cmocka_unit_test(test_shapes),
        cmocka_unit_test(test_grey_is_one_plane),
        cmocka_unit_test(test_lattice),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_numbers),
        cmocka_unit_test(test_cut_and_flipped),
        cmocka_unit_test(test_lies),
        cmocka_unit_test(test_kinds),
        cmocka_unit_test(test_fuzz),
        cmocka_unit_test(test_files),
    };
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
