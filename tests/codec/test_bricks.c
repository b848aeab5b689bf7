/* Files in bricks of other shapes: each decodes to the same samples, whole and box by box, and a
 * box is read from its own bricks; invalid content of section BRKS is refused. */
#include "test.h"

#include "array/core/array.h"
#include "base/bytes.h"
#include "codec/brick/brick_index.h"
#include "codec/brick/brick_shape.h"
#include "codec/container/container.h"
#include "codec/container/header.h"
#include "codec/container/layout.h"
#include "codec/quantize/coding.h"
#include "codec/rate/brick_choice.h"
#include "cvol/algebra.h"
#include "cvol/codec.h"
#include "random.h"
#include "support.h"
#include "support_container.h"

static const size_t zero[3] = {0, 0, 0};

/* The default of compression: planes of large volumes need less than an eighth of the bricks. */
static void random_brick_shapes(void **state)
{
    (void)state;
    static const struct {
        size_t dims[3];
        cvol_type type;
        cvol_target target;
        double value;
        size_t side[3], run;
    } is[] = {
        {{512, 512, 234}, CVOL_INT16, CVOL_TARGET_RATIO, 30, {48, 48, 16}, 1},
        {{512, 512, 234}, CVOL_FLOAT32, CVOL_TARGET_RATIO, 30, {48, 48, 16}, 1},
        {{512, 512, 234}, CVOL_UINT8, CVOL_TARGET_RATIO, 20, {48, 48, 32}, 1},
        {{512, 512, 234}, CVOL_INT16, CVOL_TARGET_RATIO, 50, {48, 48, 32}, 1}, /* 2 kB per brick */
        {{512, 512, 234}, CVOL_INT16, CVOL_TARGET_BITS, 0.5, {48, 48, 16}, 1},
        {{512, 512, 234}, CVOL_INT16, CVOL_TARGET_PSNR, 30, {64, 64, 64}, 16},
        {{301, 370, 316}, CVOL_UINT8, CVOL_TARGET_RATIO, 30, {64, 64, 64}, 16}, /* 1.2 MB */
        {{512, 512, 512}, CVOL_UINT8, CVOL_TARGET_RATIO, 30, {48, 48, 48}, 1},
        {{2048, 2048, 2048}, CVOL_UINT8, CVOL_TARGET_RATIO, 30, {64, 64, 64}, 1},
        {{4096, 4096, 10}, CVOL_UINT16, CVOL_TARGET_RATIO, 30, {64, 64, 16}, 1},
        {{40000, 40000, 1}, CVOL_UINT8, CVOL_TARGET_RATIO, 30, {64, 64, 64}, 1},
    };
    cvol_compress_options options = cvol_compress_options_defaults();
    for (size_t i = 0; i < sizeof is / sizeof *is; i++) {
        const size_t *n = is[i].dims;
        const cvol_grid grid = cvol_grid_make(n[0], n[1], n[2], is[i].type);
        options.target = is[i].target;
        options.target_value = is[i].value;
        const cvol_brick_shape got = cvol_brick_shape_choose(&grid, &options);
        if (memcmp(got.side, is[i].side, sizeof got.side) || got.run != is[i].run)
            fail_msg("%zu: bricks of %zu x %zu x %zu in runs of %zu", i, got.side[0], got.side[1],
                     got.side[2], got.run);
    }
    const cvol_grid grid = cvol_grid_make(512, 512, 234, CVOL_INT16);
    options = cvol_compress_options_defaults();
    options.lossless = 1;
    assert_true(cvol_brick_shape_is_usual(&(cvol_brick_shape){{64, 64, 64}, 16}));
    cvol_brick_shape got = cvol_brick_shape_choose(&grid, &options);
    assert_true(cvol_brick_shape_is_usual(&got));
    options.lossless = 0;
    options.block = 32;
    got = cvol_brick_shape_choose(&grid, &options);
    assert_true(cvol_brick_shape_is_usual(&got));
}

/* Waves with noise, an empty half, and a value for samples without one. */
static int16_t *make_samples(cvol_grid *grid, random_state *r)
{
    *grid = cvol_grid_make(1 + random_below(r, 90), 1 + random_below(r, 70),
                           1 + random_below(r, 60), CVOL_INT16);
    const size_t count = cvol_grid_samples(grid);
    int16_t *samples = malloc(count * sizeof *samples);
    assert_non_null(samples);
    for (size_t i = 0; i < count; i++) {
        const double x = (double)(i % grid->dims[0]), y = (double)(i / grid->dims[0]);
        samples[i] = (int16_t)(300 * sin(0.1 * x) * cos(0.05 * y) + 20 * random_signed(r));
        if (i % grid->dims[0] > grid->dims[0] / 2)
            samples[i] = i % 97 ? 0 : -999;
    }
    return samples;
}

enum { MODES = 8 };

/* Random options, with bricks of random sides. */
static cvol_compress_options random_options(random_state *r, int mode)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target = CVOL_TARGET_PSNR;
    options.target_value = 38;
    options.lapped = mode != 1;
    options.effort = mode == 2 ? CVOL_EFFORT_FAST : CVOL_EFFORT_DEFAULT;
    options.lossless = mode == 3;
    options.max_error = mode == 4 ? 6 : 0;
    options.has_fill = mode == 5 || mode == 4;
    options.fill = -999;
    options.block = mode == 6 ? 8 : mode == 7 ? 32 : 16;
    const size_t unit = options.block == 32 ? 32 : 16;
    for (int a = 0; a < 3; a++)
        options.brick[a] = (int)(unit * (1 + random_below(r, (uint32_t)(64 / unit))));
    return options;
}

static int16_t *evaluate(const cvol_array *array, const size_t begin[3], const size_t end[3])
{
    int16_t *samples = malloc((end[0] - begin[0]) * (end[1] - begin[1]) * (end[2] - begin[2]) * 2);
    assert_non_null(samples);
    check_ok(cvol_array_evaluate_box(context, samples, array, begin, end));
    return samples;
}

/* The file's bytes in memory, with one damaged byte in every brick of the subbands outside of the
 * box: decoding a box reads only its own bricks. */
static void damage_other_bricks(uint8_t *data, size_t size, const cvol_array *array,
                                const size_t begin[3], const size_t end[3])
{
    cvol_file_layout layout;
    cvol_brick_index index = {0};
    const size_t reach = array->lapped ? 2 : 0;
    check_ok(cvol_layout_walk(context, &layout, data, size, "f"));
    for (int i = 0; i < layout.section_count; i++) {
        const cvol_file_section *s = &layout.sections[i];
        uint8_t *content = data + s->offset + CVOL_SECTION_HEADER_BYTES;
        if (!strcmp(s->tag, "INDX")) {
            const cvol_section section = {.content = content, .length = s->length};
            cvol_header header = cvol_header_of(array);
            check_ok(cvol_brick_index_take_streams(context, &index, &section,
                                                   cvol_header_bricks(&header), header.brick.run,
                                                   cvol_header_streams(&header), "f"));
        }
        for (size_t b = 0; !strncmp(s->tag, "SHL", 3) && b < index.bricks; b++) {
            const cvol_span bytes = cvol_brick_index_brick(&index, s->tag[3] - '0', b, content);
            const cvol_brick_box box = cvol_brick_box_of(array, b);
            int is_met = 1;
            for (int a = 0; a < 3; a++) {
                const size_t from = box.first[a] * (size_t)array->block;
                const size_t to = from + box.count[a] * (size_t)array->block;
                is_met &= to + reach > begin[a] && from < end[a] + reach;
            }
            if (!is_met && bytes.size)
                content[bytes.data - content] ^= 0x55;
        }
    }
    cvol_brick_index_free(&index);
}

static void check_box(random_state *r, const cvol_array *array, const int16_t *whole)
{
    const size_t *dims = array->grid.dims;
    size_t begin[3], end[3], size;
    for (int a = 0; a < 3; a++) {
        begin[a] = random_below(r, (uint32_t)dims[a]);
        end[a] = begin[a] + 1 + random_below(r, (uint32_t)(dims[a] - begin[a]));
        if (!random_below(r, 3)) /* a plane */
            end[a] = begin[a] + 1;
    }
    uint8_t *data = support_unpack(support_read(file_path, &size), &size);
    if (cvol_coding_of(array)->brick.run == 1)
        damage_other_bricks(data, size, array, begin, end);
    const cvol_file_part part = {.size = sizeof(cvol_file_part), .begin = begin, .end = end};
    cvol_array *read;
    check_ok(cvol_container_read_part(context, &read, NULL, data, size, &part, "f"));
    int16_t *box = evaluate(read, begin, end);
    const size_t width = end[0] - begin[0], height = end[1] - begin[1];
    for (size_t z = begin[2]; z < end[2]; z++)
        for (size_t y = begin[1]; y < end[1]; y++)
            assert_memory_equal(box + width * (y - begin[1] + height * (z - begin[2])),
                                whole + begin[0] + dims[0] * (y + dims[1] * z), 2 * width);
    free(box);
    free(data);
    cvol_array_free(read);
}

static void all_brick_shapes_decode(void **state)
{
    (void)state;
    for (int i = 0; i < 2 * MODES; i += SUPPORT_STRIDE) {
        random_state r = {(uint64_t)i};
        cvol_grid grid;
        int16_t *samples = make_samples(&grid, &r);
        const cvol_compress_options options = random_options(&r, i % MODES);
        cvol_array *array, *again, *read;
        cvol_compress_report report;
        size_t size, other;
        cvol_array_info info;
        cvol_context_set_threads(context, 1);
        check_ok(cvol_compress(context, &array, &report, samples, &grid, &options));
        uint8_t *data = container_written(array, &size);
        assert_int_equal(size, report.file_bytes);
        cvol_context_set_threads(context, 3);
        check_ok(cvol_compress(context, &again, NULL, samples, &grid, &options));
        uint8_t *same = container_written(again, &other);
        assert_int_equal(other, size);
        assert_memory_equal(same, data, size);
        check_ok(cvol_file_verify(context, NULL, file_path));
        check_ok(cvol_array_read(context, &read, file_path, NULL));
        cvol_array_get_info(&info, read);
        for (int a = 0; a < 3; a++)
            assert_int_equal(info.brick[a], options.brick[a]);
        int16_t *one = evaluate(array, zero, grid.dims), *two = evaluate(read, zero, grid.dims);
        assert_memory_equal(one, two, cvol_grid_bytes(&grid));
        if (options.lossless)
            assert_memory_equal(one, samples, cvol_grid_bytes(&grid));
        for (int k = 0; k < 6; k++)
            check_box(&r, read, two);
        free(one);
        free(two);
        free(data);
        free(same);
        free(samples);
        cvol_array_free(array);
        cvol_array_free(again);
        cvol_array_free(read);
    }
}

/* ---- shapes that change --------------------------------------------------------------------- */

static cvol_array *make_array(int16_t **samples, cvol_grid *grid, const int brick[3])
{
    random_state r = {77};
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array;
    *samples = make_samples(grid, &r);
    options.target_value = 12;
    memcpy(options.brick, brick, sizeof options.brick);
    check_ok(cvol_compress(context, &array, NULL, *samples, grid, &options));
    return array;
}

static cvol_array *read_back(void)
{
    cvol_array *array;
    check_ok(cvol_file_verify(context, NULL, file_path));
    check_ok(cvol_array_read(context, &array, file_path, NULL));
    return array;
}

static void default_shape_takes_no_section(void **state)
{
    (void)state;
    static const int nothing[3] = {0, 0, 0}, said[3] = {64, 64, 64};
    int16_t *samples;
    cvol_grid grid;
    size_t size, other;
    cvol_array *a = make_array(&samples, &grid, nothing);
    free(samples);
    cvol_array *b = make_array(&samples, &grid, said);
    free(samples);
    uint8_t *one = container_file_of(a, &size), *two = container_file_of(b, &other);
    assert_int_equal(size, other);
    assert_memory_equal(one, two, size);
    for (size_t i = 0; i + 4 <= size; i++)
        assert_memory_not_equal(one + i, "BRKS", 4);
    free(one);
    free(two);
    cvol_array_free(a);
    cvol_array_free(b);
}

/* Terms in other bricks are the same terms; transcoding and sums keep the shape. */
static void shapes_are_kept_or_changed(void **state)
{
    (void)state;
    static const int first[3] = {32, 16, 48}, other[3] = {16, 64, 32}, wrong[3] = {16, 20, 16};
    int16_t *samples;
    cvol_grid grid;
    size_t size;
    cvol_array *array = make_array(&samples, &grid, first), *coarse, *sum;
    int16_t *whole = evaluate(array, zero, grid.dims);
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target_value = 40;
    check_ok(cvol_array_transcode(context, &coarse, NULL, array, &options));
    assert_int_equal(cvol_coding_of(coarse)->brick.side[2], 48);
    int16_t *coarse_samples = evaluate(coarse, zero, grid.dims);
    cvol_array_free(coarse);
    memcpy(options.brick, other, sizeof other);
    check_ok(cvol_array_transcode(context, &coarse, NULL, array, &options));
    assert_int_equal(cvol_coding_of(coarse)->brick.side[1], 64);
    assert_int_equal(cvol_coding_of(coarse)->brick.run, 1);
    free(container_file_of(coarse, &size));
    cvol_array_free(coarse);
    coarse = read_back();
    assert_int_equal(cvol_coding_of(coarse)->brick.side[0], 16);
    cvol_array_free(coarse);
    free(coarse_samples);

    assert_int_equal(cvol_array_set_bricks(context, array, wrong), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "a brick's side along y is 20"));
    check_ok(cvol_array_set_bricks(context, array, other));
    free(container_file_of(array, &size));
    cvol_array *read = read_back();
    assert_int_equal(cvol_coding_of(read)->brick.side[1], 64);
    assert_int_equal(cvol_coding_of(read)->trellis, cvol_coding_of(array)->trellis);
    int16_t *again = evaluate(read, zero, grid.dims);
    assert_memory_equal(again, whole, cvol_grid_bytes(&grid));
    if (!read->mask) {
        check_ok(cvol_array_add(context, &sum, 1, read, 1, read, NULL));
        assert_int_equal(cvol_coding_of(sum)->brick.side[2], 32);
        cvol_array_free(sum);
    }
    free(again);
    free(whole);
    free(samples);
    cvol_array_free(array);
    cvol_array_free(read);
    /* A residual is coded in bricks. */
    cvol_compress_options bound = cvol_compress_options_defaults();
    random_state r = {78};
    samples = make_samples(&grid, &r);
    bound.target = CVOL_TARGET_MAX_ERROR;
    bound.target_value = 5;
    check_ok(cvol_compress(context, &array, NULL, samples, &grid, &bound));
    assert_int_equal(cvol_array_set_bricks(context, array, other), CVOL_ERROR_UNSUPPORTED);
    free(samples);
    cvol_array_free(array);
}

typedef struct given {
    const int16_t *samples;
    size_t sheet;
} given;

static int give(cvol_context *unused, void *user, void *samples, size_t first, size_t sheets)
{
    const given *from = user;
    (void)unused;
    memcpy(samples, from->samples + first * from->sheet, 2 * sheets * from->sheet);
    return CVOL_OK;
}

/* Slab by slab, of layers with fewer than 64 slices. */
static void streams_have_shapes(void **state)
{
    (void)state;
    random_state r = {5};
    cvol_grid grid;
    for (int i = 0; i < 6; i += SUPPORT_STRIDE) {
        int16_t *samples = make_samples(&grid, &r);
        cvol_compress_options options = random_options(&r, i % 2);
        given from = {samples, grid.dims[0] * grid.dims[1]};
        const cvol_sample_source source = {.read = give, .user = &from};
        cvol_compress_report report;
        check_ok(cvol_compress_stream(context, &report, file_path, &source, &grid, &options));
        cvol_array *read = read_back();
        int16_t *whole = evaluate(read, zero, grid.dims);
        double squares = 0;
        for (size_t k = 0; k < cvol_grid_samples(&grid); k++)
            squares += pow((double)whole[k] - (double)samples[k], 2);
        const double span = read->error_bound.value_max - read->error_bound.value_min;
        const double psnr = 20 * log10(span * sqrt((double)cvol_grid_samples(&grid) /
                                                   fmax(squares, 1e-9)));
        if (isfinite(report.psnr_db))
            assert_true(fabs(psnr - report.psnr_db) < 1e-6);
        assert_true(report.psnr_db >= 38);
        for (int k = 0; k < 4; k++)
            check_box(&r, read, whole);
        free(whole);
        free(samples);
        cvol_array_free(read);
    }
}

/* ---- invalid sections BRKS ------------------------------------------------------------------ */

static void put_u32(uint8_t *at, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        at[i] = (uint8_t)(value >> 8 * i);
}

static void expect_refused(const uint8_t *data, size_t size, const char *sentence)
{
    cvol_file_layout layout;
    const int code = container_read_code(data, size);
    if (code != CVOL_ERROR_CORRUPT || !strstr(cvol_context_message(context), sentence))
        fail_msg("%d, must be CORRUPT with '%s': '%s'", code, sentence,
                 cvol_context_message(context));
    assert_int_equal(cvol_layout_verify(context, &layout, data, size, "f"), CVOL_ERROR_CORRUPT);
}

/* The file without the bytes of a section at `at`, or with them `times` times. */
static uint8_t *repeat(const uint8_t *data, size_t *size, size_t at, size_t length, int times)
{
    cvol_bytes out = {0};
    cvol_bytes_append(&out, data, at);
    for (int i = 0; i < times; i++)
        cvol_bytes_append(&out, data + at, length);
    cvol_bytes_append(&out, data + at + length, *size - at - length);
    assert_false(out.failed);
    *size = out.size;
    return out.data;
}

static void invalid_shapes_are_refused(void **state)
{
    (void)state;
    static const int brick[3] = {32, 32, 16};
    static const uint32_t sides[] = {0, 8, 17, 24, 80, 128, 1u << 31, UINT32_MAX};
    static const uint32_t runs[] = {0, 3, 17, 32, 1u << 31, UINT32_MAX};
    int16_t *samples;
    cvol_grid grid;
    size_t size, at = 0;
    cvol_array *array = make_array(&samples, &grid, brick);
    uint8_t *data = container_file_of(array, &size);
    while (memcmp(data + at, "BRKS", 4))
        at++;
    uint8_t *content = data + at + CVOL_SECTION_HEADER_BYTES;
    for (int field = 0; field < 4; field++) {
        const uint32_t *values = field < 3 ? sides : runs;
        const size_t count = field < 3 ? sizeof sides / sizeof *sides : sizeof runs / sizeof *runs;
        const uint32_t was = (uint32_t)content[4 * field];
        for (size_t i = 0; i < count; i++) {
            put_u32(content + 4 * field, values[i]);
            put_u32(data + at + 16, cvol_crc32c(content, 16));
            put_u32(data + at + 20, cvol_crc32c(data + at, 20));
            expect_refused(data, size, field < 3 ? "section BRKS: side" : "section BRKS: bricks");
        }
        /* Other than the shape the file was written with. */
        put_u32(content + 4 * field, field < 3 ? 64 : 2);
        put_u32(data + at + 16, cvol_crc32c(content, 16));
        put_u32(data + at + 20, cvol_crc32c(data + at, 20));
        expect_refused(data, size, "f: ");
        put_u32(content + 4 * field, was);
    }
    put_u32(data + at + 16, cvol_crc32c(content, 16));
    put_u32(data + at + 20, cvol_crc32c(data + at, 20));
    assert_int_equal(container_read_code(data, size), CVOL_OK);
    size_t changed = size;
    uint8_t *without = repeat(data, &changed, at, CVOL_SECTION_HEADER_BYTES + 16, 0);
    expect_refused(without, changed, "section INDX");
    free(without);
    changed = size;
    uint8_t *twice = repeat(data, &changed, at, CVOL_SECTION_HEADER_BYTES + 16, 2);
    expect_refused(twice, changed, "section BRKS at byte");
    free(twice);
    /* Too short, then too long. */
    put_u32(data + at + 8, 12);
    put_u32(data + at + 16, cvol_crc32c(content, 12));
    put_u32(data + at + 20, cvol_crc32c(data + at, 20));
    changed = size;
    uint8_t *shorter = repeat(data, &changed, at + CVOL_SECTION_HEADER_BYTES + 12, 4, 0);
    expect_refused(shorter, changed, "section BRKS is too short");
    free(shorter);
    free(data);
    free(samples);
    cvol_array_free(array);
}

static void invalid_requested_shapes(void **state)
{
    (void)state;
    static const int wrong[][4] = {{16, 0, 32, 32},  {16, 16, 16, 80}, {16, -16, 16, 16},
                                   {32, 16, 32, 32}, {8, 8, 16, 16},   {16, 64, 64, 1 << 30}};
    cvol_grid grid;
    random_state r = {3};
    int16_t *samples = make_samples(&grid, &r);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        cvol_compress_options options = cvol_compress_options_defaults();
        cvol_array *array;
        options.block = wrong[i][0];
        memcpy(options.brick, wrong[i] + 1, sizeof options.brick);
        assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options),
                         CVOL_ERROR_ARGUMENT);
        assert_non_null(strstr(cvol_context_message(context), "a brick's side along "));
    }
    free(samples);
}

/* A stream without bytes has no offset, nor have its runs and bricks: no arithmetic on NULL. */
static void empty_streams_have_no_offset(void **state)
{
    (void)state;
    cvol_brick_index index;
    check_ok(cvol_brick_index_make(context, &index, 3, 2));
    for (int s = 0; s < CVOL_STREAMS; s++)
        for (size_t b = 0; b < 3; b++) {
            const cvol_span brick = cvol_brick_index_brick(&index, s, b, NULL);
            const cvol_span run = cvol_brick_index_run(&index, s, b / 2, NULL);
            assert_true(!brick.data && !brick.size && !run.data && !run.size);
        }
    cvol_brick_index_free(&index);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(all_brick_shapes_decode),
                                       cmocka_unit_test(empty_streams_have_no_offset),
                                       cmocka_unit_test(default_shape_takes_no_section),
                                       cmocka_unit_test(shapes_are_kept_or_changed),
                                       cmocka_unit_test(streams_have_shapes),
                                       cmocka_unit_test(invalid_shapes_are_refused),
                                       cmocka_unit_test(random_brick_shapes),
                                       cmocka_unit_test(invalid_requested_shapes)};
    return cmocka_run_group_tests(tests, files_setup, files_teardown);
}
