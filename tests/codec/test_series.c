/* Files of many volumes: each has the bytes that it would have alone; invalid lists and damage are
 * reported. */
#include "test.h"

#include <unistd.h>

#include "codec/container/container.h"
#include "codec/container/layout.h"
#include "codec/container/series.h"
#include "codec/section/section.h"
#include "codec/section/signature.h"
#include "cvol/cvol.h"
#include "fuzz/fuzz_cvol.c"
#include "random.h"
#include "support.h"
#include "support_container.h"

enum { TIMES = 3, CHANNELS = 2 };

/* Volume i of a series, different for each i. */
static cvol_array *make_array(int i, size_t nz)
{
    cvol_grid grid = cvol_grid_make(20, 9, nz, CVOL_INT16);
    const size_t count = cvol_grid_samples(&grid);
    int16_t *samples = malloc(count * sizeof *samples);
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array;
    assert_non_null(samples);
    for (size_t k = 0; k < count; k++)
        samples[k] = (int16_t)(300 * sin((double)k / (5 + i)) + 10 * i);
    grid.spacing[2] = 2.5;
    options.target = CVOL_TARGET_PSNR;
    options.target_value = 40;
    assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options), CVOL_OK);
    free(samples);
    return array;
}

/* The series' bytes, which the caller frees. */
static uint8_t *make_series(size_t *size)
{
    static const double values[TIMES] = {0, 1.5, 3}, colours[3 * CHANNELS] = {1, 0.5, 0, 0, 0, 1};
    static const char *const names[CHANNELS] = {"DAPI", "GFP"};
    const cvol_series_options options = {.size = sizeof(cvol_series_options),
                                         .times = TIMES,
                                         .channels = CHANNELS,
                                         .time_values = values,
                                         .time_unit = "ms",
                                         .channel_names = names,
                                         .channel_colours = colours};
    cvol_series_writer *writer;
    uint64_t bytes;
    assert_int_equal(cvol_series_writer_open(context, &writer, file_path, &options), CVOL_OK);
    for (int i = 0; i < TIMES * CHANNELS; i++) {
        cvol_array *array = make_array(i, 4);
        assert_int_equal(cvol_series_add(context, writer, array, NULL), CVOL_OK);
        cvol_array_free(array);
    }
    assert_int_equal(cvol_series_writer_commit(context, writer, &bytes), CVOL_OK);
    uint8_t *data = support_read(file_path, size);
    assert_int_equal(*size, bytes);
    return data;
}

static void test_volumes_equal_their_files(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = make_series(&size);
    cvol_series *series;
    double rgb[3];
    assert_int_equal(cvol_file_kind_of(file_path), CVOL_FILE_SERIES);
    assert_int_equal(cvol_file_verify(context, NULL, file_path), CVOL_OK);
    assert_int_equal(cvol_series_read(context, &series, file_path), CVOL_OK);
    assert_int_equal(cvol_series_times(series), TIMES);
    assert_int_equal(cvol_series_channels(series), CHANNELS);
    assert_true(cvol_series_is_list(series));
    assert_string_equal(cvol_series_time_unit(series), "ms");
    assert_true(fabs(cvol_series_time(series, 1) - 1.5) <= 0);
    assert_string_equal(cvol_series_channel_name(series, 1), "GFP");
    cvol_series_get_channel_colour(rgb, series, 0);
    assert_true(fabs(rgb[1] - 0.5) <= 0);
    for (int i = 0; i < TIMES * CHANNELS; i++) {
        const int time = i / CHANNELS, channel = i % CHANNELS;
        cvol_array *array = make_array(i, 4), *read;
        size_t alone;
        uint8_t *bytes = container_written(array, &alone);
        assert_int_equal(cvol_series_volume_bytes(series, time, channel), alone);
        assert_memory_equal(bytes, data + cvol_series_volume_offset(series, time, channel), alone);
        const cvol_file_part part = {
            .size = sizeof(cvol_file_part), .time = time, .channel = channel};
        cvol_file_report report;
        support_write(file_path, data, size);
        assert_int_equal(cvol_array_read_part(context, &read, &report, file_path, &part), 0);
        assert_int_equal(report.file_bytes, alone);
        cvol_array_free(read);
        char *out = support_path(folder, "one.cvol");
        assert_int_equal(cvol_series_extract(context, file_path, time, channel, out, NULL),
                         CVOL_OK);
        size_t extracted;
        uint8_t *again = support_read(out, &extracted);
        assert_int_equal(extracted, alone);
        assert_memory_equal(again, bytes, alone);
        free(again);
        free(out);
        free(bytes);
        cvol_array_free(array);
    }
    cvol_series_free(series);
    free(data);
}

static int read_code(const uint8_t *data, size_t size, int time, int channel)
{
    const cvol_file_part part = {.size = sizeof(cvol_file_part), .time = time, .channel = channel};
    cvol_array *array;
    const int code = cvol_container_read_part(context, &array, NULL, data, size, &part, "f");
    cvol_array_free(array);
    return code;
}

static int verify_code(const uint8_t *data, size_t size)
{
    cvol_file_layout layout;
    return cvol_layout_verify(context, &layout, data, size, "f");
}

static void test_no_such_volume(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = make_series(&size);
    assert_int_equal(read_code(data, size, TIMES, 0), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "f: has 3 times, 0 to 2; number 3"));
    assert_int_equal(read_code(data, size, 0, -1), CVOL_ERROR_ARGUMENT);
    free(data);
    cvol_array *array = make_array(0, 4);
    data = container_written(array, &size);
    assert_int_equal(read_code(data, size, 0, 0), CVOL_OK);
    assert_int_equal(read_code(data, size, 1, 0), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "f: has one time"));
    cvol_array_free(array);
    free(data);
}

/* Every byte: its volume is damaged, the others are not. */
static void test_damage_affects_one_volume(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = make_series(&size);
    cvol_series *series;
    assert_int_equal(cvol_series_take(context, &series, data, size, "f"), CVOL_OK);
    for (size_t at = 0; at < size; at += at < 320 ? SUPPORT_STRIDE : 61 * SUPPORT_DAMAGE) {
        data[at] ^= 4;
        assert_int_not_equal(verify_code(data, size), CVOL_OK);
        data[at] ^= 4;
    }
    const uint64_t begin = cvol_series_volume_offset(series, 1, 1);
    const uint64_t length = cvol_series_volume_bytes(series, 1, 1);
    data[begin + length - 30] ^= 1;
    assert_int_equal(read_code(data, size, 1, 1), CVOL_ERROR_CORRUPT);
    assert_non_null(strstr(cvol_context_message(context), "f, time 1, channel 1 (from byte "));
    assert_int_equal(verify_code(data, size), CVOL_ERROR_CORRUPT);
    assert_non_null(strstr(cvol_context_message(context), "f, time 1, channel 1 (from byte "));
    assert_int_equal(read_code(data, size, 1, 0), CVOL_OK);
    assert_int_equal(read_code(data, size, 2, 0), CVOL_OK);
    data[begin + length - 30] ^= 1;
    /* Volumes before a cut can be read. */
    assert_int_equal(read_code(data, (size_t)(begin + length), 1, 1), CVOL_OK);
    for (size_t cut = (size_t)(begin + length) - 1; cut > begin - 40; cut -= 5)
        assert_int_equal(read_code(data, cut, 1, 1), CVOL_ERROR_CORRUPT);
    assert_int_equal(read_code(data, (size_t)begin, 1, 0), CVOL_OK);
    cvol_series_free(series);
    free(data);
}

/* ---- invalid lists -------------------------------------------------------------------------- */

static void put_u32(uint8_t *at, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        at[i] = (uint8_t)(value >> 8 * i);
}

static void put_u64(uint8_t *at, uint64_t value)
{
    put_u32(at, (uint32_t)value);
    put_u32(at + 4, (uint32_t)(value >> 32));
}

/* Updates the list's header and checksum. */
static void repair_list(uint8_t *data)
{
    uint64_t length = 0;
    for (int i = 7; i >= 0; i--)
        length = length << 8 | data[20 + i];
    put_u32(data + 28, cvol_crc32c(data + 36, (size_t)length));
    put_u32(data + 32, cvol_crc32c(data + 12, 20));
}

static void expect_refused_value(uint8_t *data, size_t size, int code, const char *what)
{
    repair_list(data);
    assert_int_equal(read_code(data, size, 0, 0), code);
    if (!strstr(cvol_context_message(context), what))
        fail_msg("'%s' is not in: %s", what, cvol_context_message(context));
    assert_int_not_equal(verify_code(data, size), CVOL_OK);
}

static void test_invalid_lists(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = make_series(&size), *copy = malloc(size);
    const size_t channels = 36 + 24, times = channels + 88 * CHANNELS, volumes = times + 8 * TIMES;
    assert_non_null(copy);
#define LIE(code, what, ...)                          \
    do {                                              \
        memcpy(copy, data, size);                     \
        __VA_ARGS__;                                  \
        expect_refused_value(copy, size, code, what); \
    } while (0)
    LIE(CVOL_ERROR_CORRUPT, "0 times", put_u32(copy + 36, 0));
    LIE(CVOL_ERROR_CORRUPT, "0 channels", put_u32(copy + 40, 0));
    LIE(CVOL_ERROR_LIMIT, "more than 1048576", put_u32(copy + 36, 0xFFFFFFFF));
    LIE(CVOL_ERROR_LIMIT, "more than 1048576", put_u32(copy + 36, 0xFFFFFFFF),
        put_u32(copy + 40, 0xFFFFFFFF));
    LIE(CVOL_ERROR_CORRUPT, "it has", put_u32(copy + 36, 1000));
    LIE(CVOL_ERROR_CORRUPT, "unit", memset(copy + 44, 'x', 16));
    LIE(CVOL_ERROR_CORRUPT, "unit", copy[44 + 9] = 'x');
    LIE(CVOL_ERROR_CORRUPT, "channel 0", memset(copy + channels + 24, 'x', 64));
    LIE(CVOL_ERROR_CORRUPT, "channel 1", put_u64(copy + channels + 88, UINT64_C(0x7FF8) << 48));
    LIE(CVOL_ERROR_CORRUPT, "channel 1", put_u64(copy + channels + 88, UINT64_C(0x4000) << 48));
    LIE(CVOL_ERROR_CORRUPT, "a time", put_u64(copy + times, UINT64_C(0x7FF0) << 48));
    /* Beyond the file, near overflow, in the list, in each other, at no section. */
    LIE(CVOL_ERROR_CORRUPT, "overlaps the content before it",
        put_u64(copy + volumes, UINT64_C(1) << 40));
    LIE(CVOL_ERROR_CORRUPT, "overlaps the content before it", put_u64(copy + volumes, 3));
    LIE(CVOL_ERROR_CORRUPT, "overlaps the content before it",
        put_u64(copy + volumes + 8, UINT64_MAX - 10));
    LIE(CVOL_ERROR_CORRUPT, "overlaps the content before it", put_u64(copy + volumes + 8, size));
    LIE(CVOL_ERROR_CORRUPT, "no section VOLM", put_u64(copy + volumes, 100));
    LIE(CVOL_ERROR_CORRUPT, "no section VOLM", put_u64(copy + volumes + 8, 100));
    /* The last volume does not affect the first. */
    memcpy(copy, data, size);
    put_u64(copy + volumes + 16 * (TIMES * CHANNELS - 1), UINT64_C(1) << 60);
    repair_list(copy);
    assert_int_equal(read_code(copy, size, 0, 0), CVOL_OK);
    assert_int_equal(read_code(copy, size, TIMES - 1, CHANNELS - 1), CVOL_ERROR_CORRUPT);
    assert_int_equal(verify_code(copy, size), CVOL_ERROR_CORRUPT);
#undef LIE
    free(copy);
    free(data);
}

/* A file of these volumes, one per time; the caller frees it. */
static uint8_t *wrap_all(const cvol_bytes *volumes, int times, size_t *size)
{
    cvol_series *series;
    cvol_bytes out = {0}, list = {0};
    assert_int_equal(cvol_series_make(context, &series, times, 1), CVOL_OK);
    uint64_t at = 12 + 24 + cvol_series_list_bytes(series);
    for (int t = 0; t < times; t++) {
        series->volumes[t] = (cvol_extent){at + 24, volumes[t].size};
        at += 24 + volumes[t].size;
    }
    cvol_series_put(&list, series);
    for (size_t i = 0; i < CVOL_SIGNATURE_BYTES; i++)
        cvol_bytes_put_u8(&out, cvol_container_signature(i));
    cvol_bytes_put_u32(&out, 1);
    cvol_section_put(&out, CVOL_LIST, &list);
    for (int t = 0; t < times; t++)
        cvol_section_put(&out, CVOL_VOLM, &volumes[t]);
    cvol_section_put(&out, CVOL_ENDS, &(cvol_bytes){0});
    cvol_bytes_free(&list);
    cvol_series_free(series);
    assert_false(out.failed);
    *size = out.size;
    return out.data;
}

/* A file of the same bytes for each time. */
static uint8_t *wrap(const uint8_t *inside, size_t length, int times, size_t *size)
{
    const cvol_bytes one = {.data = (uint8_t *)inside, .size = length};
    return wrap_all((const cvol_bytes[]){one, one}, times, size);
}

static void test_files_without_volumes(void **state)
{
    (void)state;
    cvol_array *array = make_array(0, 4);
    size_t alone, size, nested;
    uint8_t *bytes = container_written(array, &alone);
    uint8_t *data = wrap(bytes, alone, 2, &size);
    assert_int_equal(read_code(data, size, 1, 0), CVOL_OK);
    assert_int_equal(verify_code(data, size), CVOL_OK);
    uint8_t *twice = wrap(data, size, 1, &nested);
    assert_int_equal(read_code(twice, nested, 0, 0), CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context), "is itself a file of many volumes"));
    assert_int_not_equal(verify_code(twice, nested), CVOL_OK);
    free(twice);
    free(data);
    data = wrap((const uint8_t *)"no volume at all", 16, 1, &size);
    assert_int_equal(read_code(data, size, 0, 0), CVOL_ERROR_CORRUPT);
    assert_int_not_equal(verify_code(data, size), CVOL_OK);
    free(data);
    data = wrap(NULL, 0, 1, &size);
    assert_int_not_equal(read_code(data, size, 0, 0), CVOL_OK);
    assert_int_not_equal(verify_code(data, size), CVOL_OK);
    free(data);
    /* One volume is listed, two exist. */
    data = wrap(bytes, alone, 2, &size);
    put_u32(data + 36, 1);
    memmove(data + 36 + 24 + 88 + 8, data + 36 + 24 + 88 + 16, 32);
    repair_list(data);
    assert_int_equal(read_code(data, size, 0, 0), CVOL_OK);
    assert_int_equal(verify_code(data, size), CVOL_ERROR_CORRUPT);
    assert_non_null(strstr(cvol_context_message(context), "2 sections VOLM, section LIST has 1"));
    free(data);
    free(bytes);
    cvol_array_free(array);
}

/* A compressed picture or a baked volume, of empty sections. */
static cvol_bytes plane_file(cvol_section_kind kind)
{
    const cvol_bytes empty = {0};
    cvol_bytes out = {0};
    assert_int_equal(cvol_plane_file_put(context, &out, kind, &empty, &empty), CVOL_OK);
    return out;
}

static void test_other_kinds(void **state)
{
    (void)state;
    static const struct {
        cvol_section_kind kind;
        const char *what;
    } kinds[] = {{CVOL_PICT, "is a compressed picture, not a volume"},
                 {CVOL_BAKE, "is a baked volume, not a volume"}};
    cvol_series *series;
    for (size_t i = 0; i < 2; i++) {
        cvol_bytes file = plane_file(kinds[i].kind);
        size_t size;
        support_write(file_path, file.data, file.size);
        assert_int_equal(cvol_series_read(context, &series, file_path), CVOL_ERROR_FORMAT);
        assert_non_null(strstr(cvol_context_message(context), kinds[i].what));
        uint8_t *data = wrap(file.data, file.size, 1, &size);
        assert_int_equal(read_code(data, size, 0, 0), CVOL_ERROR_FORMAT);
        assert_non_null(strstr(cvol_context_message(context), kinds[i].what));
        free(data);
        cvol_bytes_free(&file);
    }
    support_write_text(file_path, "no .cvol file");
    assert_int_equal(cvol_series_read(context, &series, file_path), CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context), "is not a .cvol file"));
    uint8_t start[10];
    for (size_t i = 0; i < sizeof start; i++)
        start[i] = i < CVOL_SIGNATURE_BYTES ? cvol_container_signature(i) : 1;
    support_write(file_path, start, sizeof start);
    assert_int_equal(cvol_series_read(context, &series, file_path), CVOL_ERROR_CORRUPT);
    assert_non_null(strstr(cvol_context_message(context), "truncated: within its version"));
    assert_null(series);
}

/* Volumes of other shapes than the first one; volumes that end early are not extracted. */
static void test_volumes_of_other_shapes(void **state)
{
    (void)state;
    cvol_array *arrays[2] = {make_array(0, 4), make_array(1, 5)};
    cvol_bytes volumes[2] = {{0}};
    size_t size;
    uint64_t bytes = 0;
    for (int i = 0; i < 2; i++) {
        volumes[i].data = container_written(arrays[i], &volumes[i].size);
        cvol_array_free(arrays[i]);
    }
    uint8_t *data = wrap_all(volumes, 2, &size);
    char *out = support_path(folder, "one.cvol");
    assert_int_equal(read_code(data, size, 1, 0), CVOL_OK);
    assert_int_equal(verify_code(data, size), CVOL_ERROR_CORRUPT);
    assert_non_null(strstr(cvol_context_message(context), "has 20 x 9 x 5 samples of int16, the "
                                                          "first volume 20 x 9 x 4 of int16"));
    support_write(file_path, data, size);
    assert_int_equal(cvol_series_extract(context, file_path, 1, 0, out, &bytes), CVOL_OK);
    assert_int_equal(bytes, volumes[1].size);
    support_write(file_path, data, size - 60);
    assert_int_equal(cvol_series_extract(context, file_path, 1, 0, out, NULL), CVOL_ERROR_CORRUPT);
    assert_non_null(strstr(cvol_context_message(context), "time 1, channel 0"));
    assert_non_null(strstr(cvol_context_message(context), "bytes are there"));
    free(out);
    free(data);
    free(volumes[0].data);
    free(volumes[1].data);
}

/* Flips, numbers and cuts, as the fuzzer makes them: verified files can be read, and nothing
 * crashes. */
static void test_mutations(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = make_series(&size), *copy = malloc(size);
    random_state r = {11};
    assert_non_null(copy);
    for (int i = 0; i < 240; i += SUPPORT_DAMAGE) {
        memcpy(copy, data, size);
        const uint32_t near = i % 2 ? (uint32_t)size : 400; /* in the whole file, in the list */
        for (int k = 0; k < 1 + i % 3; k++)
            copy[12 + random_below(&r, near - 12)] = (uint8_t)random_u64(&r);
        LLVMFuzzerTestOneInput(copy, i % 5 ? size : random_below(&r, (uint32_t)size));
    }
    free(copy);
    free(data);
}

/* ---- writing -------------------------------------------------------------------------------- */

static void test_volumes_must_match(void **state)
{
    (void)state;
    cvol_series_options options = cvol_series_options_defaults();
    cvol_array *array = make_array(0, 4), *taller = make_array(0, 5), *moved = make_array(0, 4);
    cvol_series_writer *writer;
    moved->grid.origin[1] = 3;
    options.times = 2;
    const size_t before = support_folder_count(folder);
    char *path = support_path(folder, "never.cvol");
    assert_int_equal(cvol_series_writer_open(context, &writer, path, &options), CVOL_OK);
    assert_int_equal(cvol_series_add(context, writer, array, NULL), CVOL_OK);
    assert_int_equal(cvol_series_add(context, writer, taller, NULL), CVOL_ERROR_ARGUMENT);
    assert_string_equal(cvol_context_message(context),
                        "has 20 x 9 x 5 samples of int16, the volumes before it 20 x 9 x 4 of "
                        "int16; those in one file must match");
    assert_int_equal(cvol_series_add(context, writer, moved, NULL), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "another origin"));
    assert_int_equal(cvol_series_writer_commit(context, writer, NULL), CVOL_ERROR_ARGUMENT);
    assert_string_equal(cvol_context_message(context), "1 of 2 volumes were written");
    assert_int_equal(support_folder_count(folder), before);
    assert_int_equal(cvol_series_writer_open(context, &writer, path, &options), CVOL_OK);
    for (int i = 0; i < 2; i++)
        assert_int_equal(cvol_series_add(context, writer, array, NULL), CVOL_OK);
    assert_int_equal(cvol_series_add(context, writer, array, NULL), CVOL_ERROR_ARGUMENT);
    cvol_series_writer_abandon(writer);
    assert_int_equal(support_folder_count(folder), before);
    options.times = 0;
    assert_int_equal(cvol_series_writer_open(context, &writer, path, &options),
                     CVOL_ERROR_ARGUMENT);
    options.times = CVOL_SERIES_MOST + 1;
    assert_int_equal(cvol_series_writer_open(context, &writer, path, &options),
                     CVOL_ERROR_ARGUMENT);
    free(path);
    cvol_array_free(array);
    cvol_array_free(taller);
    cvol_array_free(moved);
}

static void expect_options_refused(const cvol_series_options *options, const char *sentence)
{
    cvol_series_writer *writer;
    char *path = support_path(folder, "never.cvol");
    assert_int_equal(cvol_series_writer_open(context, &writer, path, options), CVOL_ERROR_ARGUMENT);
    if (!strstr(cvol_context_message(context), sentence))
        fail_msg("'%s' is not in: %s", sentence, cvol_context_message(context));
    assert_null(writer);
    assert_int_not_equal(access(path, F_OK), 0);
    free(path);
}

static void test_invalid_options(void **state)
{
    (void)state;
    char text[100];
    const char *const names[3] = {"a", text, "c"};
    double colours[9] = {0}, times[2] = {0, (double)NAN};
    cvol_series_options options = cvol_series_options_defaults();
    memset(text, 'x', sizeof text - 1);
    text[sizeof text - 1] = 0;
    options.channels = 2;
    options.colours = 1;
    expect_options_refused(&options, "a file of colours has 2 channels: there must be 3");
    options.channels = 3;
    options.time_unit = text;
    expect_options_refused(&options, "must have at most 15 bytes");
    options.time_unit = NULL;
    options.channel_names = names;
    expect_options_refused(&options, "channel 1 is called 'xxx");
    options.channel_names = NULL;
    options.channel_colours = colours;
    colours[7] = 1.5;
    expect_options_refused(&options, "the colour of channel 2 has 1.5, must be 0 to 1");
    options.channel_colours = NULL;
    options.times = 2;
    options.time_values = times;
    expect_options_refused(&options, "the value of time 1 is not a number");
}

/* Three channels that are colours; and questions about volumes that do not exist. */
static void test_colours(void **state)
{
    (void)state;
    for (int colours = 0; colours < 2; colours++) {
        cvol_series_options options = cvol_series_options_defaults();
        cvol_series_writer *writer;
        cvol_series *series;
        double rgb[3];
        options.channels = 3;
        options.colours = colours;
        assert_int_equal(cvol_series_writer_open(context, &writer, file_path, &options), CVOL_OK);
        for (int i = 0; i < 3; i++) {
            cvol_array *array = make_array(i, 4);
            assert_int_equal(cvol_series_add(context, writer, array, NULL), CVOL_OK);
            cvol_array_free(array);
        }
        assert_int_equal(cvol_series_writer_commit(context, writer, NULL), CVOL_OK);
        assert_int_equal(cvol_series_read(context, &series, file_path), CVOL_OK);
        assert_int_equal(cvol_series_has_colours(series), colours);
        assert_int_equal(cvol_series_volume_bytes(series, 1, 0), 0);
        assert_int_equal(cvol_series_volume_bytes(series, 0, 3), 0);
        assert_int_equal(cvol_series_volume_offset(series, -1, 0), 0);
        assert_string_equal(cvol_series_channel_name(series, 3), "");
        assert_true(cvol_series_time(series, 1) == 0);
        cvol_series_get_channel_colour(rgb, series, -1);
        assert_true(rgb[0] == 1 && rgb[1] == 1 && rgb[2] == 1);
        cvol_series_free(series);
    }
}

static int read_ramp(cvol_context *unused, void *user, void *samples, size_t first, size_t slices)
{
    (void)unused;
    (void)user;
    for (size_t i = 0; i < slices * 600; i++)
        ((uint8_t *)samples)[i] = (uint8_t)((i + first * 600) % 200);
    return CVOL_OK;
}

/* By slab: the same bytes as alone, behind another volume. */
static void test_by_slab(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(30, 20, 70, CVOL_UINT8);
    const cvol_sample_source source = {.read = read_ramp, .user = NULL};
    const cvol_compress_options options = cvol_compress_options_defaults();
    cvol_series_options two = cvol_series_options_defaults();
    cvol_series_writer *writer;
    cvol_compress_report report;
    size_t alone, size;
    two.times = 2;
    assert_int_equal(cvol_compress_stream(context, &report, file_path, &source, &grid, &options),
                     CVOL_OK);
    uint8_t *bytes = support_read(file_path, &alone);
    assert_int_equal(cvol_series_writer_open(context, &writer, file_path, &two), CVOL_OK);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(cvol_series_add_stream(context, writer, &report, &source, &grid, &options),
                         CVOL_OK);
        assert_int_equal(report.file_bytes, alone);
    }
    assert_int_equal(cvol_series_writer_commit(context, writer, NULL), CVOL_OK);
    assert_int_equal(cvol_file_verify(context, NULL, file_path), CVOL_OK);
    uint8_t *data = support_read(file_path, &size);
    assert_memory_equal(data + size - 24 - alone, bytes, alone);
    free(data);
    free(bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_volumes_equal_their_files),
        cmocka_unit_test(test_no_such_volume),
        cmocka_unit_test(test_damage_affects_one_volume),
        cmocka_unit_test(test_invalid_lists),
        cmocka_unit_test(test_files_without_volumes),
        cmocka_unit_test(test_other_kinds),
        cmocka_unit_test(test_volumes_of_other_shapes),
        cmocka_unit_test(test_volumes_must_match),
        cmocka_unit_test(test_invalid_options),
        cmocka_unit_test(test_colours),
        cmocka_unit_test(test_by_slab),
        cmocka_unit_test(test_mutations),
    };
    return cmocka_run_group_tests(tests, files_setup, files_teardown);
}
