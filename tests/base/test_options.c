/* Option structs of callers with other headers: older, newer, and without a size. */
#include "test.h"

#include "base/options.h"
#include "cvol/cvol.h"
#include "render/counters.h"
#include "support_files.h"

/* ---- the copy --------------------------------------------------------------------------- */

/* A struct of version 1, as version 2 has it, and as version 3 has it. */
typedef struct first {
    size_t size;
    double a;
} first;
typedef struct second {
    size_t size;
    double a;
    int b, c;
} second;
typedef struct third {
    size_t size;
    double a;
    int b, c;
    double d;
} third;

static const second known = {sizeof(second), 1, 2, 3};

static int copy(second *out, const void *given)
{
    *out = known;
    return cvol_options_copy(context, out, sizeof *out, CVOL_SIZE_TO(first, a), "second", given);
}

static void expect_refusal(int code, const char *part)
{
    assert_int_equal(code, CVOL_ERROR_ARGUMENT);
    if (!strstr(cvol_context_message(context), part))
        fail_msg("\"%s\" lacks \"%s\"", cvol_context_message(context), part);
}

static void test_copy(void **state)
{
    (void)state;
    second out;
    const first old = {sizeof old, 10};
    assert_int_equal(copy(&out, &old), CVOL_OK);
    assert_memory_equal(&out, (&(second){sizeof(second), 10, 2, 3}), sizeof out);
    const second same = {sizeof same, 10, 20, 30};
    assert_int_equal(copy(&out, &same), CVOL_OK);
    assert_memory_equal(&out, &same, sizeof out);
    third newer = {sizeof newer, 10, 20, 30, 0};
    assert_int_equal(copy(&out, &newer), CVOL_OK);
    assert_memory_equal(&out, &same, sizeof out);
    newer.d = 1;
    expect_refusal(copy(&out, &newer), "use a newer library");
    assert_memory_equal(&out, &known, sizeof out);
    const first small = {sizeof small - 1, 10}, none = {0, 10}, wild = {SIZE_MAX / 2, 10};
    char part[32];
    snprintf(part, sizeof part, "second: its size is %zu,", sizeof small - 1);
    expect_refusal(copy(&out, &small), part);
    expect_refusal(copy(&out, &none), "second: its size is 0");
    expect_refusal(copy(&out, &wild), "second: its size is");
    assert_memory_equal(&out, &known, sizeof out);
}

static void test_fill(void **state)
{
    (void)state;
    uint8_t bytes[sizeof(third) + 8];
    for (size_t size = 0; size <= sizeof(third); size++) {
        memset(bytes, 0xa5, sizeof bytes);
        cvol_options_fill(bytes, size, &known, sizeof known);
        size_t told;
        memcpy(&told, bytes, sizeof told);
        if (size >= sizeof told)
            assert_int_equal(told, size);
        for (size_t i = size < sizeof told ? 0 : size; i < sizeof bytes; i++)
            assert_int_equal(bytes[i], 0xa5);
        for (size_t i = sizeof told; size >= sizeof told && i < size; i++)
            assert_int_equal(bytes[i], i < sizeof known ? ((const uint8_t *)&known)[i] : 0);
    }
}

/* ---- every struct ----------------------------------------------------------------------- */

enum { SIDE = 16, PICTURE = 24, TAIL = 64 };

static float samples[SIDE * SIDE * SIDE] __attribute__((aligned(64)));
static cvol_volume volume;
static cvol_array *array;
static cvol_renderer *sheet, *spectral, *fourier;
static cvol_image *image, *floats;
static char *volume_path, *other_path, *film_path;
static const cvol_transfer_point points[2] = {{0, 0, 0, 0, 0}, {100, 1, 1, 1, 0.3}};
static cvol_render_options annotated;

static int read_slices(cvol_context *of, void *user, void *out, size_t from, size_t count)
{
    (void)of, (void)user;
    memcpy(out, samples + from * SIDE * SIDE, count * SIDE * SIDE * sizeof *samples);
    return CVOL_OK;
}

static const cvol_sample_source slices = {.read = read_slices};

/* Each calls a public function with these options, and frees the result. */
static int compress(const void *options)
{
    cvol_array *out;
    const int code = cvol_compress(context, &out, NULL, samples, &volume.grid, options);
    cvol_array_free(out);
    return code;
}

static int compress_stream(const void *options)
{
    return cvol_compress_stream(context, NULL, other_path, &slices, &volume.grid, options);
}

static int transcode(const void *options)
{
    cvol_array *out;
    const int code = cvol_array_transcode(context, &out, NULL, array, options);
    cvol_array_free(out);
    return code;
}

static int add_stream(const void *options)
{
    const cvol_series_options one = cvol_series_options_defaults();
    cvol_series_writer *writer;
    check_ok(cvol_series_writer_open(context, &writer, other_path, &one));
    const int code = cvol_series_add_stream(context, writer, NULL, &slices, &volume.grid, options);
    cvol_series_writer_abandon(writer);
    return code;
}

static int open_film(const void *options)
{
    cvol_film *out;
    const int code = cvol_film_open(context, &out, film_path, PICTURE, PICTURE, options);
    cvol_film_abandon(out);
    return code;
}

static int compress_picture(const void *options)
{
    cvol_picture *out;
    const int code = cvol_picture_compress(context, &out, image, options);
    cvol_picture_free(out);
    return code;
}

static int render_compressed_as(const void *options)
{
    cvol_picture *out;
    const int code = cvol_renderer_render_compressed(context, spectral, &out, &annotated, options);
    cvol_picture_free(out);
    return code;
}

static int open_series(const void *options)
{
    cvol_series_writer *out;
    const int code = cvol_series_writer_open(context, &out, other_path, options);
    cvol_series_writer_abandon(out);
    return code;
}

static int read_volume(const void *options)
{
    cvol_volume *out;
    const int code = cvol_volume_read(context, &out, volume_path, options);
    cvol_volume_free(out);
    return code;
}

static int open_stream(const void *options)
{
    cvol_volume_stream *out;
    const int code = cvol_volume_stream_open(context, &out, volume_path, options);
    cvol_volume_stream_free(out);
    return code;
}

static int count_volumes(const void *options)
{
    int times, channels;
    return cvol_file_count_volumes(context, &times, &channels, volume_path, options);
}

static int read_part(const void *part)
{
    cvol_array *out;
    const int code = cvol_array_read_part(context, &out, NULL, file_path, part);
    cvol_array_free(out);
    return code;
}

static int read_grid(const void *part)
{
    cvol_grid grid;
    return cvol_file_read_grid(context, &grid, file_path, part);
}

static int render(const void *options)
{
    return cvol_renderer_render(context, sheet, image, options);
}

static int count(const void *options)
{
    uint64_t out;
    return cvol_renderer_sheet_multiply_adds(context, sheet, image, options, &out);
}

static int refine(const void *options)
{
    return cvol_renderer_refine(context, sheet, image, options, 1e6, NULL, NULL, NULL);
}

static int choose_level(const void *options)
{
    int level;
    return cvol_render_choose_file_level(context, &level, &volume.grid, options);
}

static int render_compressed(const void *options)
{
    const cvol_picture_options how = cvol_picture_options_defaults();
    cvol_picture *out;
    const int code = cvol_renderer_render_compressed(context, spectral, &out, options, &how);
    cvol_picture_free(out);
    return code;
}

static int project(const void *options)
{
    static float out[PICTURE * PICTURE];
    const double rotation[1][4] = {{1, 0, 0, 0}};
    return cvol_renderer_project(context, fourier, out, options, rotation, 1);
}

static int bake(const void *options)
{
    return cvol_renderer_bake(context, spectral, other_path, 2, NULL, options, NULL);
}

static int annotate_view(const void *options)
{
    const cvol_annotation annotation = {.size = sizeof annotation,
                                        .grid = &volume.grid,
                                        .options = options,
                                        .rescale = {1, 0},
                                        .value_unit = ""};
    return cvol_image_annotate(context, floats, &annotation);
}

static int annotate(const void *annotation)
{
    return cvol_image_annotate(context, floats, annotation);
}

static int create_renderer(const void *source)
{
    cvol_renderer *out;
    const int code = cvol_renderer_create(context, &out, CVOL_ENGINE_RAY, source);
    cvol_renderer_free(out);
    return code;
}

static void make_compress(void *out)
{
    cvol_compress_options o = cvol_compress_options_defaults();
    o.target_value = 4;
    memcpy(out, &o, sizeof o);
}

static void make_film(void *out)
{
    cvol_film_options_set_defaults(out, sizeof(cvol_film_options));
}

static void make_picture(void *out)
{
    cvol_picture_options_set_defaults(out, sizeof(cvol_picture_options));
}

static void make_series(void *out)
{
    cvol_series_options_set_defaults(out, sizeof(cvol_series_options));
}

static void make_read(void *out)
{
    cvol_read_options_set_defaults(out, sizeof(cvol_read_options));
}

static void make_render(void *out)
{
    cvol_render_options o = cvol_render_options_defaults();
    o.width = o.height = PICTURE;
    memcpy(out, &o, sizeof o);
}

static void make_projection(void *out)
{
    make_render(out);
    ((cvol_render_options *)out)->mode = CVOL_MODE_XRAY;
}

static void make_baking(void *out)
{
    make_render(out);
    ((cvol_render_options *)out)->splat.plane = CVOL_FOOTPRINT_IN_SLICES;
}

static void make_part(void *out)
{
    const cvol_file_part part = {.size = sizeof part};
    memcpy(out, &part, sizeof part);
}

static void make_annotation(void *out)
{
    const cvol_annotation annotation = {.size = sizeof annotation,
                                        .grid = &volume.grid,
                                        .options = &annotated,
                                        .rescale = {1, 0},
                                        .value_unit = ""};
    memcpy(out, &annotation, sizeof annotation);
}

static void make_source(void *out)
{
    const cvol_source source = {.size = sizeof source, .volume = &volume};
    memcpy(out, &source, sizeof source);
}

/* `least`: bytes to the end of the last field of version 0.1. */
#define STRUCT(name, last) #name, sizeof(name), CVOL_SIZE_TO(name, last)

static const struct {
    const char *name;
    size_t size, least;
    void (*make)(void *out);
    int (*calls[8])(const void *options);
} structs[] = {
    {STRUCT(cvol_compress_options, brick),
     make_compress,
     {compress, compress_stream, transcode, add_stream}},
    {STRUCT(cvol_film_options, quality), make_film, {open_film}},
    {STRUCT(cvol_picture_options, psnr_db), make_picture, {compress_picture, render_compressed_as}},
    {STRUCT(cvol_series_options, colours), make_series, {open_series}},
    {STRUCT(cvol_read_options, series), make_read, {read_volume, open_stream, count_volumes}},
    {STRUCT(cvol_render_options, clip),
     make_render,
     {render, count, refine, choose_level, render_compressed, annotate_view}},
    {STRUCT(cvol_render_options, clip), make_projection, {project}},
    {STRUCT(cvol_render_options, clip), make_baking, {bake}},
    {STRUCT(cvol_file_part, channel), make_part, {read_part, read_grid}},
    {STRUCT(cvol_annotation, value_unit), make_annotation, {annotate}},
    {STRUCT(cvol_source, rho), make_source, {create_renderer}},
};

static void set_size(uint8_t *bytes, size_t size)
{
    memcpy(bytes, &size, sizeof size);
}

static void expect_other_sizes(size_t s, int (*call)(const void *options))
{
    const size_t size = structs[s].size;
    uint8_t *bytes = calloc(1, size + TAIL);
    char *small;
    assert_non_null(bytes);
    structs[s].make(bytes);
    check_ok(call(bytes));
    set_size(bytes, size + TAIL);
    check_ok(call(bytes));
    bytes[size + TAIL - 1] = 1;
    expect_refusal(call(bytes), "use a newer library");
    bytes[size + TAIL - 1] = 0;
    assert_true(asprintf(&small, "%s: its size is ", structs[s].name) > 0);
    const size_t refused[] = {0, 1, sizeof(size_t), structs[s].least - 1, SIZE_MAX};
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        set_size(bytes, refused[i]);
        expect_refusal(call(bytes), small);
    }
    free(small);
    free(bytes);
}

static void test_structs(void **state)
{
    (void)state;
    for (size_t s = 0; s < sizeof structs / sizeof *structs; s++) {
        assert_true(structs[s].least <= structs[s].size);
        for (int k = 0; structs[s].calls[k]; k++)
            if (structs[s].calls[k] != open_film || strstr(cvol_film_formats(), ".gif"))
                expect_other_sizes(s, structs[s].calls[k]);
    }
}

/* ---- the objects ------------------------------------------------------------------------ */

static int setup(void **state)
{
    files_setup(state);
    for (size_t i = 0; i < SIDE * SIDE * SIDE; i++)
        samples[i] = (float)(50 + 40 * sin((double)i / 97) + (double)(i % 7));
    volume = (cvol_volume){cvol_grid_make(SIDE, SIDE, SIDE, CVOL_FLOAT32), samples};
    make_render(&annotated);
    assert_true(asprintf(&volume_path, "%s/v.nrrd", folder) > 0);
    assert_true(asprintf(&other_path, "%s/other", folder) > 0);
    assert_true(asprintf(&film_path, "%s/film.gif", folder) > 0);
    cvol_compress_options options;
    make_compress(&options);
    check_ok(cvol_compress(context, &array, NULL, samples, &volume.grid, &options));
    check_ok(cvol_array_write(context, array, file_path, NULL));
    check_ok(cvol_volume_write(context, &volume, volume_path));
    cvol_transfer *transfer;
    check_ok(cvol_transfer_create(context, &transfer, points, 2));
    check_ok(cvol_renderer_create(context, &sheet, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)));
    check_ok(cvol_renderer_create(context, &spectral, CVOL_ENGINE_TRANSFORM,
                                  CVOL_SOURCE(.array = array)));
    check_ok(
        cvol_renderer_create(context, &fourier, CVOL_ENGINE_FOURIER, CVOL_SOURCE(.array = array)));
    check_ok(cvol_renderer_set_transfer(context, sheet, transfer));
    check_ok(cvol_renderer_set_transfer(context, spectral, transfer));
    cvol_transfer_free(transfer);
    check_ok(cvol_image_create(context, &image, PICTURE, PICTURE));
    check_ok(cvol_image_create_float(context, &floats, PICTURE, PICTURE));
    return 0;
}

static int teardown(void **state)
{
    cvol_image_free(image);
    cvol_image_free(floats);
    cvol_renderer_free(sheet);
    cvol_renderer_free(spectral);
    cvol_renderer_free(fourier);
    cvol_array_free(array);
    free(volume_path);
    free(other_path);
    free(film_path);
    return files_teardown(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_copy), cmocka_unit_test(test_fill),
                                       cmocka_unit_test(test_structs)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
