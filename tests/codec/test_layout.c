/* The layout of files: sections and their states; every flip and every cut is reported with its
 * offset. */
#include "test.h"

#include "base/bytes.h"
#include "codec/container/container.h"
#include "codec/container/layout.h"
#include "cvol/cvol.h"
#include "random.h"
#include "support.h"
#include "support_container.h"
#include "support_files.h"

/* Writes FOLDER/a.cvol; returns its bytes, which the caller frees. x beyond 128: three bricks. */
static uint8_t *make_file(size_t *size, size_t nx, cvol_transform transform, int block)
{
    cvol_grid grid = cvol_grid_make(nx, 5, 4, CVOL_INT16);
    const size_t count = cvol_grid_samples(&grid);
    int16_t *samples = malloc(count * sizeof *samples);
    random_state r = {5};
    cvol_array *array;
    assert_non_null(samples);
    for (size_t i = 0; i < count; i++)
        samples[i] = (int16_t)(500 * sin((double)i / 9) + 60 * random_signed(&r));
    if (transform == CVOL_DCT && block) {
        cvol_compress_options options = cvol_compress_options_defaults();
        options.block = block;
        options.target_value = 3;
        assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options), CVOL_OK);
    } else {
        const cvol_keep keep = cvol_keep_terms(0, 20);
        assert_int_equal(
            cvol_array_compress(context, &array, samples, &grid, 3, transform, block, &keep),
            CVOL_OK);
    }
    assert_int_equal(cvol_array_write(context, array, file_path, NULL), CVOL_OK);
    cvol_array_free(array);
    free(samples);
    return support_unpack(support_read(file_path, size), size);
}

static void expect_whole(const uint8_t *data, size_t size, const char *tags)
{
    cvol_file_layout layout;
    char found[128] = "";
    assert_int_equal(cvol_layout_verify(context, &layout, data, size, "f"), CVOL_OK);
    uint64_t next = 12;
    for (int i = 0; i < layout.section_count; i++) {
        strcat(found, layout.sections[i].tag);
        strcat(found, " ");
        assert_int_equal(layout.sections[i].state, CVOL_SECTION_SOUND);
        assert_int_equal(layout.sections[i].offset, next);
        assert_true(strlen(layout.sections[i].content) > 5);
        next += 24 + layout.sections[i].length;
    }
    assert_string_equal(found, tags);
    assert_int_equal(next, size);
    assert_int_equal(layout.file_bytes, size);
}

static void complete_files_verify(void **state)
{
    (void)state;
    static const struct {
        cvol_transform transform;
        int block;
        const char *tags;
    } cases[] = {{CVOL_DCT, 8, "HEAD GEOM ERRS SUMM TABL INDX SHL0 SHL1 SHL2 SHL3 ENDS "},
                 {CVOL_DHT, 16, "HEAD GEOM ERRS TERM ENDS "},
                 {CVOL_DFT, 8, "HEAD GEOM ERRS TERM ENDS "},
                 {CVOL_DFT, 0, "HEAD GEOM ERRS SPEC ENDS "}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        size_t size;
        uint8_t *data = make_file(&size, 140, cases[i].transform, cases[i].block);
        expect_whole(data, size, cases[i].tags);
        assert_int_equal(cvol_file_verify(context, NULL, file_path), CVOL_OK);
        free(data);
    }
}

/* Each byte of the file gets another value, one after the other. */
static void expect_flips_detected(const uint8_t *data, size_t size)
{
    uint8_t *copy = malloc(size);
    random_state r = {7};
    assert_non_null(copy);
    memcpy(copy, data, size);
    for (size_t at = 0; at < size; at += SUPPORT_DAMAGE) {
        cvol_file_layout layout;
        copy[at] ^= (uint8_t)(1 + random_below(&r, 255));
        const int walked = cvol_layout_walk(context, &layout, copy, size, "f");
        assert_int_not_equal(walked, CVOL_OK);
        assert_int_equal(cvol_layout_verify(context, &layout, copy, size, "f"), walked);
        assert_int_equal(walked, at < 8    ? CVOL_ERROR_FORMAT
                                 : at < 12 ? CVOL_ERROR_UNSUPPORTED
                                           : CVOL_ERROR_CORRUPT);
        container_expect_place(at);
        /* The section with the damaged byte is not valid. */
        for (int i = 0; i < layout.section_count; i++) {
            const cvol_file_section *s = &layout.sections[i];
            if (at >= s->offset && at < s->offset + 24)
                assert_int_equal(s->state, CVOL_SECTION_DAMAGED);
            else if (s->state == CVOL_SECTION_SOUND)
                assert_true(at < s->offset || at >= s->offset + 24 + s->length);
        }
        copy[at] = data[at];
    }
    assert_int_equal(cvol_layout_verify(context, &(cvol_file_layout){0}, copy, size, "f"), CVOL_OK);
    free(copy);
}

static void expect_cuts_detected(const uint8_t *data, size_t size)
{
    for (size_t length = 0; length < size; length += SUPPORT_DAMAGE) {
        cvol_file_layout layout;
        uint8_t *cut = malloc(length ? length : 1); /* so that reading beyond it is detected */
        assert_non_null(cut);
        memcpy(cut, data, length);
        assert_int_equal(cvol_layout_verify(context, &layout, cut, length, "f"),
                         CVOL_ERROR_CORRUPT);
        if (!strstr(cvol_context_message(context), "f: truncated: "))
            fail_msg("%zu bytes: '%s'", length, cvol_context_message(context));
        assert_int_equal(layout.file_bytes, length);
        free(cut);
    }
}

static void every_flip_and_cut_is_detected(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = make_file(&size, 140, CVOL_DCT, 8); /* three bricks */
    expect_flips_detected(data, size);
    expect_cuts_detected(data, size);
    free(data);
    data = make_file(&size, 20, CVOL_DHT, 8);
    expect_flips_detected(data, size);
    expect_cuts_detected(data, size);
    free(data);
    data = make_file(&size, 20, CVOL_DFT, 0);
    expect_flips_detected(data, size);
    expect_cuts_detected(data, size);
    free(data);
}

static void trailing_bytes_are_detected(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = make_file(&size, 20, CVOL_DCT, 8);
    cvol_file_layout layout;
    char wanted[64];
    data = realloc(data, size + 3);
    assert_non_null(data);
    memset(data + size, 0, 3);
    assert_int_equal(cvol_layout_verify(context, &layout, data, size + 3, "f"), CVOL_ERROR_CORRUPT);
    snprintf(wanted, sizeof wanted, "f: 3 bytes follow the end, at byte %zu", size);
    assert_string_equal(cvol_context_message(context), wanted);
    assert_int_equal(layout.section_count, 11);
    free(data);
}

static void damaged_sections_are_listed(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = make_file(&size, 140, CVOL_DCT, 8);
    cvol_file_layout layout, whole;
    assert_int_equal(cvol_layout_walk(context, &whole, data, size, "f"), CVOL_OK);
    /* If the index is damaged, the ends of runs are unknown, but the rest is checked. */
    data[whole.sections[5].offset + 24] ^= 1;
    assert_int_equal(cvol_layout_walk(context, &layout, data, size, "f"), CVOL_ERROR_CORRUPT);
    assert_non_null(strstr(cvol_context_message(context), "f: section INDX at byte "));
    assert_int_equal(layout.section_count, 11);
    assert_int_equal(layout.level, -1);
    assert_int_equal(layout.sections[4].state, CVOL_SECTION_SOUND);
    assert_int_equal(layout.sections[5].state, CVOL_SECTION_DAMAGED);
    for (int i = 6; i < 10; i++)
        assert_int_equal(layout.sections[i].state, CVOL_SECTION_UNCHECKED);
    assert_int_equal(layout.sections[10].state, CVOL_SECTION_SOUND);
    data[whole.sections[5].offset + 24] ^= 1;
    /* The last run is named, and the level before it is valid. */
    data[size - 25] ^= 1;
    assert_int_equal(cvol_layout_walk(context, &layout, data, size, "f"), CVOL_ERROR_CORRUPT);
    assert_non_null(strstr(cvol_context_message(context), "f: section SHL3 at byte "));
    assert_non_null(strstr(cvol_context_message(context), ": run 0 of 1, "));
    assert_int_equal(layout.sections[9].state, CVOL_SECTION_DAMAGED);
    assert_int_equal(layout.level, 1);
    free(data);
    assert_string_equal(cvol_section_state_name(CVOL_SECTION_TRUNCATED), "truncated");
    assert_null(cvol_section_state_name((cvol_section_state)9));
}

/* Errors that only decoding finds: the checksums are right, the content is not. */
static void invalid_values_are_reported_with_offset(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = make_file(&size, 20, CVOL_DCT, 8);
    cvol_file_layout layout;
    enum { HEAD_AT = 12, RANK_AT = HEAD_AT + 24 + 32 };
    data[RANK_AT] = 9;
    for (int i = 0; i < 2; i++) { /* of the content, then of the header that has it */
        const uint32_t sum = i ? cvol_crc32c(data + HEAD_AT, 20)
                               : cvol_crc32c(data + HEAD_AT + 24, 88);
        for (int b = 0; b < 4; b++)
            data[HEAD_AT + 16 + 4 * i + b] = (uint8_t)(sum >> 8 * b);
    }
    /* The number of bricks is then unknown. */
    assert_int_equal(cvol_layout_walk(context, &layout, data, size, "f"), CVOL_OK);
    assert_int_equal(layout.sections[6].state, CVOL_SECTION_UNCHECKED);
    assert_int_equal(cvol_layout_verify(context, &layout, data, size, "f"), CVOL_ERROR_CORRUPT);
    assert_string_equal(cvol_context_message(context), "f: section HEAD: rank is 9, must be 1, 2 "
                                                       "or 3 (section HEAD is at byte 12)");
    free(data);
}

static void other_files_do_not_verify(void **state)
{
    (void)state;
    char *other = support_path(folder, "other");
    cvol_file_layout layout;
    support_write_text(other, "NRRD0004\n");
    assert_int_equal(cvol_file_read_layout(context, &layout, other), CVOL_ERROR_FORMAT);
    assert_non_null(strstr(cvol_context_message(context),
                           "other: is not a .cvol file: byte 0 is 4e, must be 8b"));
    assert_int_equal(layout.section_count, 0);
    support_write_text(other, "");
    assert_int_not_equal(cvol_file_verify(context, &layout, other), CVOL_OK);
    free(other);
    other = support_path(folder, "missing");
    assert_int_equal(cvol_file_verify(context, &layout, other), CVOL_ERROR_IO);
    free(other);
}

/* Truncates the file as soon as verification reaches its bricks. */
static int empty_file(void *user, const char *what, double fraction)
{
    (void)what;
    (void)fraction;
    support_write_text(file_path, "");
    ++*(int *)user;
    return 0;
}

/* Reading pages of a mapping beyond a truncated file would kill the process. */
static void files_that_shrink_are_verified(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(200, 140, 70, CVOL_UINT8);
    const size_t count = cvol_grid_samples(&grid);
    uint8_t *samples = malloc(count);
    random_state r = {7};
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_file_layout layout;
    cvol_array *array;
    uint64_t bytes;
    int calls = 0;
    assert_non_null(samples);
    for (size_t i = 0; i < count; i++)
        samples[i] = (uint8_t)random_below(&r, 256);
    options.lossless = 1;
    assert_int_equal(cvol_compress(context, &array, NULL, samples, &grid, &options), CVOL_OK);
    assert_int_equal(cvol_array_write(context, array, file_path, &bytes), CVOL_OK);
    cvol_array_free(array);
    free(samples);
    cvol_context_set_progress(context, empty_file, &calls);
    const int code = cvol_file_verify(context, &layout, file_path);
    cvol_context_set_progress(context, NULL, NULL);
    assert_int_equal(code, CVOL_OK); /* it was whole when it was read */
    assert_true(calls && layout.file_bytes == bytes);
    assert_int_not_equal(cvol_file_verify(context, &layout, file_path), CVOL_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(complete_files_verify),
        cmocka_unit_test(every_flip_and_cut_is_detected),
        cmocka_unit_test(trailing_bytes_are_detected),
        cmocka_unit_test(damaged_sections_are_listed),
        cmocka_unit_test(invalid_values_are_reported_with_offset),
        cmocka_unit_test(other_files_do_not_verify),
        cmocka_unit_test(files_that_shrink_are_verified),
    };
    return cmocka_run_group_tests(tests, files_setup, files_teardown);
}
