/* Files of small volumes: packed in one section, small, checked to the last byte; cut files are
 * complete up to a level. */
#include "test.h"

#include "codec/container/container.h"
#include "codec/container/layout.h"
#include "codec/container/section_pack.h"
#include "cvol/series.h"
#include "random.h"
#include "support.h"
#include "support_container.h"

/* The most bytes of a file of a few samples. */
enum { SMALL_MAX = 150 };

typedef enum small_kind { NOISE, CONSTANT, WAVES } small_kind;

typedef struct small_case {
    const char *name;
    size_t dims[3];
    cvol_type type;
    small_kind kind;
    int lossless, smallest, fill, geometry;
    double psnr; /* 0: the usual ratio */
    size_t most; /* bytes of the file */
} small_case;

static const small_case cases[] = {
    {"noise", {4, 5, 6}, CVOL_UINT8, NOISE, 0, 0, 0, 0, 0, SMALL_MAX},
    {"noise of int16", {4, 5, 6}, CVOL_INT16, NOISE, 0, 0, 0, 0, 0, SMALL_MAX},
    {"noise of floats", {4, 5, 6}, CVOL_FLOAT32, NOISE, 0, 0, 0, 0, 0, SMALL_MAX},
    {"constant", {8, 8, 8}, CVOL_UINT8, CONSTANT, 0, 0, 0, 0, 0, SMALL_MAX},
    {"constant floats", {8, 8, 8}, CVOL_FLOAT32, CONSTANT, 0, 0, 0, 0, 0, SMALL_MAX},
    {"one sample", {1, 1, 1}, CVOL_FLOAT64, CONSTANT, 1, 0, 0, 0, 0, SMALL_MAX},
    {"lossless noise", {4, 5, 6}, CVOL_UINT8, NOISE, 1, 0, 0, 0, 0, 300},
    {"lossless waves", {12, 11, 10}, CVOL_INT16, WAVES, 1, 0, 0, 0, 0, 2000},
    {"waves", {16, 16, 16}, CVOL_INT16, WAVES, 0, 0, 0, 1, 45, 2000},
    /* maximum effort */
    {"smallest", {SUPPORT_SIDE(20), 17, SUPPORT_SIDE(9)}, CVOL_INT16, WAVES, 0, 1, 0, 0, 45, 2000},
    {"a mask", {20, 17, 9}, CVOL_INT16, WAVES, 0, 0, 1, 0, 45, 2000},
    {"a mask, lossless", {12, 11, 10}, CVOL_UINT8, WAVES, 1, 0, 1, 0, 0, 2000},
    {"two bricks", {70, 9, 8}, CVOL_UINT8, WAVES, 0, 0, 0, 0, 40, 2000},
};
enum { CASES = sizeof cases / sizeof *cases };

static cvol_grid grid_of(const small_case *c)
{
    cvol_grid grid = cvol_grid_make(c->dims[0], c->dims[1], c->dims[2], c->type);
    for (int a = 0; a < 3 && c->geometry; a++) {
        grid.spacing[a] = 0.7 + a;
        grid.origin[a] = -31.25 * a - 1;
    }
    if (c->geometry)
        strcpy(grid.unit, "mm");
    return grid;
}

static double sample_at(const small_case *c, size_t i, random_state *r)
{
    const size_t x = i % c->dims[0], y = i / c->dims[0] % c->dims[1],
                 z = i / c->dims[0] / c->dims[1];
    switch (c->kind) {
    case NOISE:
        return random_below(r, 250);
    case CONSTANT:
        return 7;
    case WAVES:
        return c->fill && z < 4 ? 0
                                : floor(120 + 60 * sin((double)x / 3) * cos((double)(y + z) / 4) +
                                        random_below(r, 9));
    }
    return 0;
}

static void *make_samples(const small_case *c)
{
    const size_t count = c->dims[0] * c->dims[1] * c->dims[2];
    random_state r = {11};
    void *samples = malloc(count * cvol_type_size(c->type));
    assert_non_null(samples);
    for (size_t i = 0; i < count; i++) {
        const double v = sample_at(c, i, &r);
        if (c->type == CVOL_UINT8)
            ((uint8_t *)samples)[i] = (uint8_t)v;
        else if (c->type == CVOL_INT16)
            ((int16_t *)samples)[i] = (int16_t)v;
        else if (c->type == CVOL_FLOAT32)
            ((float *)samples)[i] = (float)v;
        else
            ((double *)samples)[i] = v;
    }
    return samples;
}

static cvol_array *compress(const small_case *c, const void *samples)
{
    const cvol_grid grid = grid_of(c);
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array;
    options.lossless = c->lossless;
    options.effort = c->smallest ? CVOL_EFFORT_MAX : CVOL_EFFORT_DEFAULT;
    options.has_fill = c->fill;
    if (c->psnr > 0) {
        options.target = CVOL_TARGET_PSNR;
        options.target_value = c->psnr;
    }
    if (cvol_compress(context, &array, NULL, samples, &grid, &options))
        fail_msg("%s: %s", c->name, cvol_context_message(context));
    return array;
}

/* The file's bytes; the caller frees them. */
static uint8_t *make_file(const small_case *c, size_t *size)
{
    void *samples = make_samples(c);
    cvol_array *array = compress(c, samples);
    uint8_t *data = container_written(array, size);
    cvol_array_free(array);
    free(samples);
    return data;
}

/* The files of the cases: each is compressed once. */
static struct made_file {
    uint8_t *data;
    size_t size;
} made[CASES];

static int make_files(void **state)
{
    if (files_setup(state))
        return 1;
    for (size_t k = 0; k < CASES; k++)
        made[k].data = make_file(&cases[k], &made[k].size);
    return 0;
}

static int free_files(void **state)
{
    for (size_t k = 0; k < CASES; k++)
        free(made[k].data);
    return files_teardown(state);
}

/* A copy of the file of case k; the caller frees it. */
static uint8_t *copy_file(size_t k, size_t *size)
{
    uint8_t *data = malloc(made[k].size);
    assert_non_null(data);
    memcpy(data, made[k].data, made[k].size);
    *size = made[k].size;
    return data;
}

static void *evaluate(const cvol_array *array)
{
    const cvol_grid *grid = cvol_array_grid(array);
    const size_t begin[3] = {0, 0, 0};
    void *samples = malloc(cvol_grid_bytes(grid));
    assert_non_null(samples);
    assert_int_equal(cvol_array_evaluate_box(context, samples, array, begin, grid->dims), CVOL_OK);
    return samples;
}

/* ---- size and round trip --------------------------------------------------------------------- */

static void small_volumes_take_few_bytes(void **state)
{
    (void)state;
    for (size_t k = 0; k < CASES; k++) {
        size_t size;
        uint8_t *data = copy_file(k, &size);
        assert_true(cvol_pack_detect(data, size));
        if (size > cases[k].most)
            fail_msg("%s: %zu bytes, at most %zu", cases[k].name, size, cases[k].most);
        free(data);
    }
}

static void expect_same_info(const cvol_array *a, const cvol_array *b)
{
    cvol_array_info x, y;
    cvol_array_get_info(&x, a);
    cvol_array_get_info(&y, b);
    assert_int_equal(x.rank, y.rank);
    assert_int_equal(x.coefficients, y.coefficients);
    assert_true(x.value_min <= y.value_min && x.value_min >= y.value_min);
    assert_true(x.max_error <= y.max_error && x.max_error >= y.max_error);
    assert_true(x.psnr_db <= y.psnr_db && x.psnr_db >= y.psnr_db);
    assert_memory_equal(cvol_array_grid(a)->spacing, cvol_array_grid(b)->spacing,
                        sizeof cvol_array_grid(a)->spacing);
    assert_memory_equal(cvol_array_grid(a)->origin, cvol_array_grid(b)->origin,
                        sizeof cvol_array_grid(a)->origin);
    assert_string_equal(cvol_array_grid(a)->unit, cvol_array_grid(b)->unit);
}

/* Samples, figures and attributes of the packed file and of the unpacked one equal those
 * written. */
static void small_files_round_trip(void **state)
{
    (void)state;
    for (size_t k = 0; k < CASES; k++) {
        const small_case *c = &cases[k];
        void *samples = make_samples(c);
        cvol_array *array = compress(c, samples), *back, *unpacked;
        size_t size, plain_size;
        assert_int_equal(
            cvol_array_set_attributes(context, array, k % 2 ? "{\"a\": [1, 22]}" : NULL), CVOL_OK);
        uint8_t *data = container_written(array, &size), *plain = malloc(size);
        assert_non_null(plain);
        memcpy(plain, data, size);
        plain_size = size;
        plain = support_unpack(plain, &plain_size);
        assert_true(plain_size > size + 300);
        assert_int_equal(cvol_container_read(context, &back, data, size, "f"), CVOL_OK);
        assert_int_equal(cvol_container_read(context, &unpacked, plain, plain_size, "f"), CVOL_OK);
        expect_same_info(array, back);
        expect_same_info(array, unpacked);
        if (k % 2)
            assert_string_equal(cvol_array_attributes(back), "{\"a\": [1, 22]}");
        void *x = evaluate(array), *y = evaluate(back), *z = evaluate(unpacked);
        const size_t bytes = cvol_grid_bytes(cvol_array_grid(array));
        assert_memory_equal(x, y, bytes);
        assert_memory_equal(x, z, bytes);
        if (c->lossless)
            assert_memory_equal(x, samples, bytes);
        free(x);
        free(y);
        free(z);
        free(plain);
        free(data);
        cvol_array_free(unpacked);
        cvol_array_free(back);
        cvol_array_free(array);
        free(samples);
    }
}

/* Large files are not packed. */
static void large_files_are_not_packed(void **state)
{
    (void)state;
    const small_case large = {"large", {60, 60, 60}, CVOL_UINT8, NOISE, 1, 0, 0, 0, 0, 0};
    size_t size;
    uint8_t *data = make_file(&large, &size);
    assert_true(size > CVOL_PACK_MAX);
    assert_false(cvol_pack_detect(data, size));
    free(data);
}

/* ---- damage ---------------------------------------------------------------------------------- */

static void every_flip_is_detected(void **state)
{
    (void)state;
    random_state r = {7};
    cvol_context_set_threads(context, 1);
    for (size_t k = 0; k < CASES; k++) {
        size_t size;
        uint8_t *data = copy_file(k, &size);
        for (size_t at = 0; at < size; at += SUPPORT_DAMAGE) {
            cvol_file_layout layout;
            const uint8_t was = data[at];
            data[at] ^= (uint8_t)(1 + random_below(&r, 255));
            const int walked = cvol_layout_walk(context, &layout, data, size, "f");
            container_expect_place(at);
            assert_int_equal(walked, at < 8    ? CVOL_ERROR_FORMAT
                                     : at < 12 ? CVOL_ERROR_UNSUPPORTED
                                               : CVOL_ERROR_CORRUPT);
            assert_int_equal(cvol_layout_verify(context, &layout, data, size, "f"), walked);
            assert_int_equal(container_read_code(data, size), walked);
            data[at] = was;
        }
        assert_int_equal(container_read_code(data, size), CVOL_OK);
        free(data);
    }
}

/* The first bytes of the subbands, and the file's end. */
static void find_subbands(size_t begins[5], const uint8_t *data, size_t size)
{
    cvol_file_layout layout;
    int subbands = 0;
    assert_int_equal(cvol_layout_verify(context, &layout, data, size, "f"), CVOL_OK);
    assert_int_equal(layout.level, 0);
    assert_string_equal(layout.sections[0].tag, "PACK");
    assert_int_equal(layout.sections[0].offset, 12);
    assert_int_equal(layout.sections[0].length, size - 36);
    for (int i = 0; i < layout.section_count; i++) {
        const cvol_file_section *s = &layout.sections[i];
        assert_int_equal(s->state, CVOL_SECTION_SOUND);
        if (!strncmp(s->tag, "SHL", 3)) {
            begins[subbands++] = (size_t)s->offset;
            begins[subbands] = (size_t)(s->offset + s->length);
        }
    }
    assert_int_equal(subbands, 4);
}

/* Cut anywhere, the file is refused with a message about the remaining part; a remaining level
 * equals that of the whole file. */
static void every_cut_is_reported(void **state)
{
    (void)state;
    cvol_context_set_threads(context, 1);
    for (size_t k = 0; k < CASES; k++) {
        size_t size, begins[5];
        uint8_t *data = copy_file(k, &size);
        find_subbands(begins, data, size);
        for (size_t cut = k % 3; cut < size; cut += SUPPORT_DAMAGE + 2) {
            cvol_file_layout layout;
            cvol_file_report report;
            cvol_array *array;
            int subbands = 0;
            uint8_t *exact = malloc(cut ? cut : 1); /* so that reading beyond it is detected */
            assert_non_null(exact);
            memcpy(exact, data, cut);
            while (subbands < 4 && cut >= begins[subbands + 1])
                subbands++;
            subbands = cut < begins[0] ? 0 : subbands;
            assert_int_equal(cvol_layout_verify(context, &layout, exact, cut, "f"),
                             CVOL_ERROR_CORRUPT);
            if (!strstr(cvol_context_message(context), "f: truncated: "))
                fail_msg("%s, %zu bytes: '%s'", cases[k].name, cut, cvol_context_message(context));
            assert_int_equal(layout.level, subbands ? 4 - subbands : -1);
            assert_int_not_equal(container_read_code(exact, cut), CVOL_OK);
            assert_true(!strstr(cvol_context_message(context), "; it is whole up") == !subbands);
            const int code = cvol_container_read_part(context, &array, &report, exact, cut,
                                                      CVOL_FILE_PART(.cut = 1), "f");
            assert_true(!code == (subbands > 0));
            if (!code) {
                assert_true(report.cut && report.level == 4 - subbands);
                assert_int_equal(report.file_bytes, cut);
            }
            cvol_array_free(array);
            free(exact);
        }
        free(data);
    }
}

static void levels_need_only_the_beginning(void **state)
{
    (void)state;
    size_t size, begins[5];
    uint8_t *data = copy_file(8, &size); /* waves */
    find_subbands(begins, data, size);
    for (int level = 1; level < 4; level++) {
        const cvol_file_part part = {.size = sizeof(cvol_file_part), .level = level};
        cvol_array *whole, *first;
        assert_int_equal(cvol_container_read_part(context, &whole, NULL, data, size, &part, "f"),
                         CVOL_OK);
        assert_int_equal(
            cvol_container_read_part(context, &first, NULL, data, begins[4 - level], &part, "f"),
            CVOL_OK);
        void *x = evaluate(whole), *y = evaluate(first);
        assert_memory_equal(x, y, cvol_grid_bytes(cvol_array_grid(whole)));
        free(x);
        free(y);
        cvol_array_free(whole);
        cvol_array_free(first);
    }
    free(data);
}

static void trailing_bytes_are_detected(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = copy_file(0, &size);
    cvol_file_layout layout;
    char wanted[64];
    data = realloc(data, size + 3);
    assert_non_null(data);
    memset(data + size, 0, 3);
    assert_int_equal(cvol_layout_verify(context, &layout, data, size + 3, "f"), CVOL_ERROR_CORRUPT);
    snprintf(wanted, sizeof wanted, "f: 3 bytes follow the end, at byte %zu", size);
    assert_string_equal(cvol_context_message(context), wanted);
    assert_int_equal(container_read_code(data, size + 3), CVOL_ERROR_CORRUPT);
    free(data);
}

/* Fronts of random bytes with valid checksums: each is refused or read. */
static void invalid_fronts_do_not_crash(void **state)
{
    (void)state;
    random_state r = {3};
    size_t size;
    uint8_t *data = copy_file(0, &size), *copy = malloc(size);
    const size_t front = 37 + data[36]; /* its length is one byte */
    assert_non_null(copy);
    assert_true(data[36] < 128 && front < size);
    for (int i = 0; i < 4000; i += SUPPORT_DAMAGE) {
        memcpy(copy, data, size);
        for (uint32_t flips = 1 + random_below(&r, 4); flips; flips--)
            copy[36 + random_below(&r, (uint32_t)(front - 36))] = (uint8_t)random_below(&r, 256);
        const size_t said = copy[36] < 128 && 37u + copy[36] <= size ? 37u + copy[36] : front;
        for (int field = 0; field < 2; field++) {
            const uint32_t sum = field ? cvol_crc32c(copy + 12, 20)
                                       : cvol_crc32c(copy + 36, said - 36);
            for (int b = 0; b < 4; b++)
                copy[28 + 4 * field + b] = (uint8_t)(sum >> 8 * b);
        }
        cvol_file_layout layout;
        const int verified = cvol_layout_verify(context, &layout, copy, size, "f");
        assert_int_equal(!container_read_code(copy, size), !verified);
    }
    free(copy);
    free(data);
}

/* ---- many volumes ---------------------------------------------------------------------------- */

static void series_of_small_volumes_are_small(void **state)
{
    (void)state;
    enum { TIMES = 5 };
    cvol_series_writer *writer;
    cvol_series_options options = cvol_series_options_defaults();
    void *samples = make_samples(&cases[0]);
    cvol_array *array = compress(&cases[0], samples), *back;
    options.times = TIMES;
    assert_int_equal(cvol_series_writer_open(context, &writer, file_path, &options), CVOL_OK);
    for (int t = 0; t < TIMES; t++)
        assert_int_equal(cvol_series_add(context, writer, array, NULL), CVOL_OK);
    assert_int_equal(cvol_series_writer_commit(context, writer, NULL), CVOL_OK);
    size_t size;
    uint8_t *data = support_read(file_path, &size);
    assert_true(size < 300 + TIMES * (24 + 16 + 8 + SMALL_MAX));
    assert_int_equal(cvol_file_verify(context, NULL, file_path), CVOL_OK);
    void *wanted = evaluate(array);
    for (int t = 0; t < TIMES; t++) {
        const cvol_file_part part = {.size = sizeof(cvol_file_part), .time = t};
        assert_int_equal(cvol_array_read_part(context, &back, NULL, file_path, &part), CVOL_OK);
        void *found = evaluate(back);
        assert_memory_equal(found, wanted, cvol_grid_bytes(cvol_array_grid(back)));
        free(found);
        cvol_array_free(back);
    }
    for (size_t at = 0; at < size; at += SUPPORT_DAMAGE) {
        cvol_file_layout layout;
        data[at] ^= 32;
        assert_int_not_equal(cvol_layout_verify(context, &layout, data, size, "f"), CVOL_OK);
        data[at] ^= 32;
    }
    free(wanted);
    free(data);
    free(samples);
    cvol_array_free(array);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(small_volumes_take_few_bytes),
        cmocka_unit_test(small_files_round_trip),
        cmocka_unit_test(large_files_are_not_packed),
        cmocka_unit_test(every_flip_is_detected),
        cmocka_unit_test(every_cut_is_reported),
        cmocka_unit_test(levels_need_only_the_beginning),
        cmocka_unit_test(trailing_bytes_are_detected),
        cmocka_unit_test(invalid_fronts_do_not_crash),
        cmocka_unit_test(series_of_small_volumes_are_small),
    };
    return cmocka_run_group_tests(tests, make_files, free_files);
}
