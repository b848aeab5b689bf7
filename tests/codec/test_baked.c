/* Baked volumes: pictures from files equal those from samples, from all directions of their axis;
 * refusals; cut, flipped, invalid and fuzzed files. */
#include "test.h"

#include "codec/section/signature.h"
#include "fuzz/fuzz_cvol.c"
#include "random.h"
#include "support.h"
#include "support_files.h"
#include "support_render.h"

static cvol_volume blobs;

static int setup(void **state)
{
    blobs = support_blobs(40, 36, 34);
    blobs.grid.spacing[1] = 1.25;
    return files_setup(state);
}

static int teardown(void **state)
{
    free(blobs.data);
    return files_teardown(state);
}

/* A renderer of samples; points: the number of used points of the transfer function. */
static cvol_renderer *from_samples(size_t points)
{
    cvol_renderer *renderer;
    assert_int_equal(cvol_renderer_create(context, &renderer, CVOL_ENGINE_TRANSFORM,
                                          CVOL_SOURCE(.volume = &blobs)),
                     CVOL_OK);
    support_set_transfer(context, renderer, support_blob_points, points);
    return renderer;
}

static void bake(int axis, const cvol_render_options *options)
{
    cvol_renderer *renderer = from_samples(SUPPORT_BLOB_POINTS);
    uint64_t bytes;
    assert_int_equal(
        cvol_renderer_bake(context, renderer, file_path, axis, "blobs", options, &bytes), CVOL_OK);
    cvol_renderer_free(renderer);
    size_t size;
    free(support_read(file_path, &size));
    assert_int_equal(size, bytes);
    assert_int_equal(cvol_file_kind_of(file_path), CVOL_FILE_BAKED);
    assert_int_equal(cvol_file_verify(context, NULL, file_path), CVOL_OK);
}

static cvol_renderer *from_file(void)
{
    cvol_renderer *renderer;
    assert_int_equal(cvol_renderer_create(context, &renderer, CVOL_ENGINE_TRANSFORM,
                                          CVOL_SOURCE(.baked_path = file_path)),
                     CVOL_OK);
    return renderer;
}

static cvol_render_options view_of(double azimuth, double elevation, double rho, int tile)
{
    cvol_render_options options = support_square(80, CVOL_MODE_COMPOSITE, azimuth, elevation);
    options.transform.rho = rho;
    options.transform.tile = tile;
    return options;
}

/* ---- pictures ------------------------------------------------------------------------------- */

static void test_all_directions(void **state)
{
    static const struct {
        int axis;
        double azimuth, elevation;
    } views[] = {{0, 90, 0}, {0, 270, 0}, {0, 70, 25}, {0, -110, -20},
                 {1, 0, 0},  {1, 180, 0}, {1, 20, 30}, {1, 200, -30},
                 {2, 0, 90}, {2, 0, -90}, {2, 30, 70}, {2, 200, -60}};
    (void)state;
    for (size_t v = 0; v < sizeof views / sizeof *views; v++)
        for (int tile = 0; tile <= 32; tile = tile ? 2 * tile : 8) {
            cvol_render_options options = view_of(views[v].azimuth, views[v].elevation, 1, tile);
            cvol_renderer *samples = from_samples(SUPPORT_BLOB_POINTS), *file;
            cvol_image *truth = support_picture(context, samples, &options);
            bake(views[v].axis, &options);
            file = from_file();
            for (int order = CVOL_ORDER_FRONT; order <= CVOL_ORDER_BACK; order++) {
                options.splat.order = (cvol_order)order;
                cvol_image *image = support_picture(context, file, &options);
                const double psnr = support_psnr(truth, image);
                cvol_image_free(image);
                if (psnr < 40)
                    fail_msg("azimuth %g, elevation %g, tile %d: %.1f dB", views[v].azimuth,
                             views[v].elevation, tile, psnr);
            }
            cvol_image_free(truth);
            cvol_renderer_free(samples);
            cvol_renderer_free(file);
        }
}

/* Fewer planes are stored: the more, the smaller the error; the same bits for any number of
 * threads. */
static void test_fewer(void **state)
{
    static const double shares[] = {0.02, 0.08, 0.3};
    double before = 0;
    (void)state;
    cvol_render_options options = view_of(20, 10, 1, 16);
    bake(1, &options);
    cvol_renderer *file = from_file();
    cvol_image *truth = support_picture(context, file, &options);
    for (int i = 0; i < 3; i++) {
        cvol_transform_report report;
        options.transform.rho = shares[i];
        cvol_image *image = support_picture(context, file, &options);
        cvol_context_set_threads(context, 3);
        cvol_image *again = support_picture(context, file, &options);
        cvol_context_set_threads(context, 0);
        assert_memory_equal(image->rgba, again->rgba, 4 * 80 * 80);
        assert_int_equal(cvol_renderer_get_transform_report(context, &report, file), CVOL_OK);
        assert_true(report.rho <= shares[i] * 1.001);
        const double psnr = support_psnr(truth, image);
        assert_true(psnr > before);
        before = psnr;
        cvol_image_free(image);
        cvol_image_free(again);
    }
    assert_true(before > 40);
    cvol_image_free(truth);
    cvol_renderer_free(file);
}

static void test_light(void **state)
{
    (void)state;
    cvol_render_options options = view_of(0, 0, 1, 16);
    options.shading.on = 1;
    options.shading.light[0] = 1;
    options.shading.light[2] = 2;
    bake(1, &options);
    cvol_renderer *samples = from_samples(SUPPORT_BLOB_POINTS), *file = from_file();
    cvol_image *truth = support_picture(context, samples, &options);
    cvol_image *image = support_picture(context, file, &options);
    assert_true(support_psnr(truth, image) >= 45);
    cvol_image_free(image);
    image = NULL;
    assert_int_equal(cvol_image_create(context, &image, 80, 80), CVOL_OK);
    options.shading.light[0] = -1;
    assert_int_equal(cvol_renderer_render(context, file, image, &options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "light"));
    options.shading.on = 0;
    assert_int_equal(cvol_renderer_render(context, file, image, &options), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "baked lit"));
    cvol_image_free(image);
    cvol_image_free(truth);
    cvol_renderer_free(samples);
    cvol_renderer_free(file);
}

static void test_info(void **state)
{
    (void)state;
    const cvol_render_options options = view_of(0, 0, 0.2, 8);
    cvol_baked_info info;
    bake(2, &options);
    cvol_renderer *file = from_file(), *samples = from_samples(SUPPORT_BLOB_POINTS);
    assert_int_equal(cvol_renderer_get_baked_info(context, &info, file), CVOL_OK);
    assert_int_equal(info.axis, 2);
    assert_int_equal(info.slices, 34);
    assert_int_equal(info.tile, 8);
    assert_string_equal(info.transfer_name, "blobs");
    assert_int_equal(info.transfer_count, SUPPORT_BLOB_POINTS);
    assert_true(info.kept > 0.02 && info.kept <= 0.2);
    assert_int_equal(info.grid.dims[0], 40);
    assert_int_equal(cvol_renderer_get_baked_info(context, &info, samples), CVOL_ERROR_ARGUMENT);
    cvol_renderer_free(file);
    cvol_renderer_free(samples);
}

/* ---- refusals ------------------------------------------------------------------------------- */

static void expect_refused(cvol_renderer *file, const cvol_render_options *options,
                           const char *what)
{
    cvol_image *image;
    assert_int_equal(cvol_image_create(context, &image, 80, 80), CVOL_OK);
    assert_int_equal(cvol_renderer_render(context, file, image, options), CVOL_ERROR_ARGUMENT);
    if (!strstr(cvol_context_message(context), what))
        fail_msg("'%s' must be about '%s'", cvol_context_message(context), what);
    cvol_image_free(image);
}

static void test_drawing_refused(void **state)
{
    (void)state;
    const cvol_render_options options = view_of(0, 0, 0.2, 16);
    bake(1, &options);
    cvol_renderer *file = from_file();
    cvol_render_options other = options;
    other.camera.azimuth_deg = 90;
    expect_refused(file, &other, "slices along y, from this direction they lie along x");
    other = options;
    other.transform.rho = 0.3;
    expect_refused(file, &other, "keeps rho 0.2, 0.3 is requested");
    other.transform.rho = 0;
    expect_refused(file, &other, "rho is 0");
    other = options;
    other.transform.tile = 8;
    expect_refused(file, &other, "tiles of 16");
    other = options;
    other.shading.on = 1;
    expect_refused(file, &other, "baked unlit");
    cvol_transfer *transfer;
    assert_int_equal(
        cvol_transfer_create(context, &transfer, support_blob_points, SUPPORT_BLOB_POINTS - 1),
        CVOL_OK);
    assert_int_equal(cvol_renderer_set_transfer(context, file, transfer), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "another transfer function, blobs"));
    cvol_transfer_free(transfer);
    support_set_transfer(context, file, support_blob_points, SUPPORT_BLOB_POINTS);
    cvol_image_free(support_picture(context, file, &options));
    assert_int_equal(cvol_renderer_bake(context, file, file_path, 1, NULL, &options, NULL),
                     CVOL_ERROR_ARGUMENT);
    cvol_renderer_free(file);
}

static void test_baking_refused(void **state)
{
    (void)state;
    cvol_renderer *samples = from_samples(SUPPORT_BLOB_POINTS);
    const cvol_render_options options = view_of(0, 0, 0.2, 16);
    cvol_render_options other = options;
    for (int i = 0; i < 2; i++) {
        other.transform.rho = i ? 0 : 1.5;
        assert_int_equal(cvol_renderer_bake(context, samples, file_path, 1, NULL, &other, NULL),
                         CVOL_ERROR_ARGUMENT);
    }
    other = options;
    other.transform.transform = CVOL_DFT;
    assert_int_equal(cvol_renderer_bake(context, samples, file_path, 1, NULL, &other, NULL),
                     CVOL_ERROR_UNSUPPORTED);
    other = options;
    assert_int_equal(cvol_renderer_bake(context, samples, file_path, 3, NULL, &other, NULL),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(
        cvol_renderer_bake(context, samples, "/no/such/folder/a", 1, NULL, &other, NULL),
        CVOL_ERROR_IO);
    cvol_renderer_free(samples);
    /* thin slices */
    cvol_volume thin = support_blobs(40, 30, 6);
    assert_int_equal(cvol_renderer_create(context, &samples, CVOL_ENGINE_TRANSFORM,
                                          CVOL_SOURCE(.volume = &thin)),
                     CVOL_OK);
    support_set_transfer(context, samples, support_blob_points, SUPPORT_BLOB_POINTS);
    other.splat.size = 7;
    assert_int_equal(cvol_renderer_bake(context, samples, file_path, 1, NULL, &other, NULL),
                     CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "larger than slices of 40 x 6"));
    cvol_renderer_free(samples);
    free(thin.data);
}

/* ---- damage --------------------------------------------------------------------------------- */

static uint8_t *small_file(size_t *size)
{
    cvol_volume small = support_blobs(20, 18, 19);
    cvol_renderer *samples;
    const cvol_render_options options = view_of(0, 0, 0.1, 8);
    assert_int_equal(cvol_renderer_create(context, &samples, CVOL_ENGINE_TRANSFORM,
                                          CVOL_SOURCE(.volume = &small)),
                     CVOL_OK);
    support_set_transfer(context, samples, support_blob_points, SUPPORT_BLOB_POINTS);
    assert_int_equal(cvol_renderer_bake(context, samples, file_path, 2, "blobs", &options, NULL),
                     CVOL_OK);
    cvol_renderer_free(samples);
    free(small.data);
    return support_read(file_path, size);
}

static void expect_damaged(const uint8_t *data, size_t size, const char *what)
{
    cvol_baked_file file;
    cvol_file_layout layout;
    const int code = cvol_baked_file_take(context, &file, data, size, "bad.cvol");
    if (!code || !strstr(cvol_context_message(context), "bad.cvol"))
        fail_msg("%s: code %d, '%s'", what, code, cvol_context_message(context));
    assert_true(cvol_layout_verify(context, &layout, data, size, "bad.cvol") != CVOL_OK);
}

static void test_cut_and_flipped(void **state)
{
    size_t size;
    char what[64];
    (void)state;
    uint8_t *data = small_file(&size);
    for (size_t cut = 0; cut < size; cut += cut < 700 ? 1 : 37) {
        uint8_t *copy = malloc(cut + 1);
        memcpy(copy, data, cut);
        snprintf(what, sizeof what, "cut to %zu bytes", cut);
        expect_damaged(copy, cut, what);
        free(copy);
    }
    for (size_t at = 0; at < size; at += at < 700 ? 1 : 37) {
        data[at] ^= (uint8_t)(1 << at % 8);
        snprintf(what, sizeof what, "byte %zu flipped", at);
        expect_damaged(data, size, what);
        data[at] ^= (uint8_t)(1 << at % 8);
    }
    free(data);
}

/* Invalid fields under valid checksums. */
static void test_lies(void **state)
{
    enum { HEAD = CVOL_SECTIONS_AT + CVOL_SECTION_HEADER_BYTES };
    static const struct {
        size_t at;
        uint32_t value;
    } lies[] = {{0, 0},
                {0, 70000},
                {4, 60000},
                {8, 5},
                {8, 40},
                {12, 0},
                {12, 9},
                {20, 0},
                {20, 0x7FF00000},
                {28, 0xBFF00000},
                {40, 3},
                {44, 0},
                {44, 3},
                {48, 4},
                {48, 64},
                {52, 0},
                {52, 2},
                {52, 4},
                {56, 2},
                {60, 0},
                {60, 2},
                {60, 5},
                {64, 2},
                {64, 32},
                {68, 0},
                {68, 70000},
                {68, 500},
                {76, 0},
                {76, 0x7FF80000},
                {84, 0x40000000},
                {84, 0xBFF00000},
                {92, 0x7FF00000},
                {100, 0x40500000},
                {108, 0x7FF00000},
                {128, 0x01010101},
                {156, 0x61616161},
                {164, 0x7FF00000},
                {172, 0x40000000}};
    size_t size;
    (void)state;
    uint8_t *data = small_file(&size);
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        uint8_t *copy = malloc(size);
        char what[64];
        memcpy(copy, data, size);
        fuzz_put_u32(copy + HEAD + lies[i].at, lies[i].value);
        fuzz_repair(copy, size);
        snprintf(what, sizeof what, "field %zu is %x", lies[i].at, lies[i].value);
        expect_damaged(copy, size, what);
        free(copy);
    }
    free(data);
}

static void test_kinds(void **state)
{
    size_t size;
    cvol_array *array;
    cvol_picture *picture;
    (void)state;
    uint8_t *data = small_file(&size);
    assert_int_equal(cvol_container_read(context, &array, data, size, "a"), CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context), "a: is a baked volume"));
    assert_int_equal(cvol_picture_take(context, &picture, data, size, "a"), CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context), "section BAKE"));
    free(data);
}

static void test_fuzz(void **state)
{
    random_state r = {1990};
    size_t size;
    (void)state;
    uint8_t *data = small_file(&size), *copy = malloc(size);
    for (int i = 0; i < 300; i++) {
        memcpy(copy, data, size);
        for (uint32_t n = 1 + random_below(&r, 4); n; n--)
            copy[random_below(&r, random_below(&r, 2) ? 400 : (uint32_t)size)] = (uint8_t)
                random_u64(&r);
        LLVMFuzzerTestOneInput(copy, size);
        /* Every file that can be read can be drawn. */
        fuzz_repair(copy, size);
        support_write(file_path, copy, size);
        cvol_renderer *file;
        if (!cvol_renderer_create(context, &file, CVOL_ENGINE_TRANSFORM,
                                  CVOL_SOURCE(.baked_path = file_path))) {
            cvol_baked_info info;
            assert_int_equal(cvol_renderer_get_baked_info(context, &info, file), CVOL_OK);
            cvol_render_options options = view_of(0, info.axis == 2 ? 90 : 0, info.rho, info.tile);
            options.camera.azimuth_deg = info.axis == 0 ? 90 : 0;
            options.splat = info.splat;
            cvol_image *image;
            assert_int_equal(cvol_image_create(context, &image, 80, 80), CVOL_OK);
            (void)cvol_renderer_render(context, file, image, &options);
            cvol_image_free(image);
            cvol_renderer_free(file);
        }
    }
    free(copy);
    free(data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_directions),  cmocka_unit_test(test_fewer),
        cmocka_unit_test(test_light),           cmocka_unit_test(test_info),
        cmocka_unit_test(test_drawing_refused), cmocka_unit_test(test_baking_refused),
        cmocka_unit_test(test_cut_and_flipped), cmocka_unit_test(test_lies),
        cmocka_unit_test(test_kinds),           cmocka_unit_test(test_fuzz),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
