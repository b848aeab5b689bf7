/* Sections of files that are longer, unknown, missing, misplaced or invalid; attributes. */
#include "test.h"

#include "base/context.h"
#include "codec/brick/subbands.h"
#include "codec/container/container.h"
#include "codec/container/layout.h"
#include "random.h"
#include "support.h"
#include "support_container.h"
#include "support_terms.h"

static void expect_refused(const uint8_t *data, size_t size, int wanted, const char *sentence)
{
    cvol_file_layout layout;
    const int code = container_read_code(data, size);
    if (code != wanted || !strstr(cvol_context_message(context), sentence))
        fail_msg("%d, must be %d with '%s': '%s'", code, wanted, sentence,
                 cvol_context_message(context));
    assert_int_equal(cvol_layout_verify(context, &layout, data, size, "f"), wanted);
}

/* ---- sections --------------------------------------------------------------------------- */

/* The file with a section of `length` bytes at byte `at`. */
static uint8_t *insert(const uint8_t *data, size_t *size, size_t at, const char *tag,
                       uint32_t flags, size_t length)
{
    cvol_bytes out = {0};
    cvol_bytes_append(&out, data, at);
    uint8_t *content = malloc(length + 1);
    assert_non_null(content);
    memset(content, 'x', length + 1);
    cvol_bytes_append(&out, tag, 4);
    cvol_bytes_put_u32(&out, flags);
    cvol_bytes_put_u64(&out, length);
    cvol_bytes_put_u32(&out, cvol_crc32c(content, length));
    cvol_bytes_put_u32(&out, cvol_crc32c(out.data + at, 20));
    cvol_bytes_append(&out, content, length);
    cvol_bytes_append(&out, data + at, *size - at);
    assert_false(out.failed);
    free(content);
    *size = out.size;
    return out.data;
}

static void unknown_sections_are_skipped(void **state)
{
    (void)state;
    cvol_array *array = container_small_array(), *back;
    size_t size;
    uint8_t *data = container_file_of(array, &size);
    cvol_file_layout layout, with;
    assert_int_equal(cvol_layout_walk(context, &layout, data, size, "f"), CVOL_OK);
    for (int i = 0; i < layout.section_count; i++) {
        const size_t at = (size_t)layout.sections[i].offset;
        size_t more = size;
        uint8_t *longer = insert(data, &more, at, "neWs", 0xfffffffe, 5);
        assert_int_equal(cvol_layout_verify(context, &with, longer, more, "f"), CVOL_OK);
        assert_int_equal(with.section_count, layout.section_count + 1);
        assert_string_equal(with.sections[i].tag, "neWs");
        assert_string_equal(with.sections[i].content, "unknown");
        assert_int_equal(cvol_container_read(context, &back, longer, more, "f"), CVOL_OK);
        support_terms_expect_same(array, back);
        cvol_array_free(back);
        longer[at + 24] ^= 1;
        expect_refused(longer, more, CVOL_ERROR_CORRUPT, "section neWs at byte ");
        free(longer);
        more = size;
        longer = insert(data, &more, at, "neWs", 1, 5);
        expect_refused(longer, more, CVOL_ERROR_UNSUPPORTED,
                       "is needed to decode the file, and unknown to this library");
        assert_non_null(strstr(cvol_context_message(context), "section neWs"));
        free(longer);
    }
    /* Any number of them. */
    for (int i = 0; i < 100; i++) {
        uint8_t *longer = insert(data, &size, 12, "neWs", 0, 3);
        free(data);
        data = longer;
    }
    assert_int_equal(cvol_layout_verify(context, &with, data, size, "f"), CVOL_OK);
    assert_int_equal(with.section_count, CVOL_FILE_SECTIONS_MAX);
    data[size - 25] ^= 1;
    assert_int_equal(cvol_layout_verify(context, &with, data, size, "f"), CVOL_ERROR_CORRUPT);
    free(data);
    cvol_array_free(array);
}

static void put_u32(uint8_t *at, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        at[i] = (uint8_t)(value >> 8 * i);
}

/* Sets a section's flags, and its header's checksum. */
static void flag(uint8_t *data, const cvol_file_section *section, uint32_t flags)
{
    put_u32(data + section->offset + 4, flags);
    put_u32(data + section->offset + 20, cvol_crc32c(data + section->offset, 20));
}

static void flags_are_checked(void **state)
{
    (void)state;
    cvol_array *array = container_small_array();
    size_t size;
    assert_int_equal(cvol_array_set_attributes(context, array, "{}"), CVOL_OK);
    uint8_t *data = container_file_of(array, &size);
    cvol_file_layout layout;
    assert_int_equal(cvol_layout_walk(context, &layout, data, size, "f"), CVOL_OK);
    for (int i = 0; i < layout.section_count; i++) {
        const cvol_file_section *section = &layout.sections[i];
        if (!strcmp(section->tag, "ATTR") || !strcmp(section->tag, "SUMM")) {
            assert_int_equal(section->flags, 0);
            flag(data, section, 0x80000000);
            assert_int_equal(container_read_code(data, size), CVOL_OK);
            continue;
        }
        assert_int_equal(section->flags, 1);
        flag(data, section, 0);
        expect_refused(data, size, CVOL_ERROR_CORRUPT, "is not flagged as required");
        flag(data, section, 3);
        expect_refused(data, size, CVOL_ERROR_UNSUPPORTED, "has the flags 00000003");
        flag(data, section, 1);
    }
    assert_int_equal(container_read_code(data, size), CVOL_OK);
    free(data);
    cvol_array_free(array);
}

/* Copies sections in this order; HEAD, GEOM, ERRS and ENDS are longer by `more`. */
static uint8_t *arrange(const uint8_t *data, size_t *size, const int *order, int count, size_t more)
{
    cvol_file_layout layout;
    cvol_bytes out = {0};
    static const uint8_t extra[64] = {7};
    assert_int_equal(cvol_layout_walk(context, &layout, data, *size, "f"), CVOL_OK);
    cvol_bytes_append(&out, data, 12);
    for (int i = 0; i < count; i++) {
        const cvol_file_section *s = &layout.sections[order[i]];
        const size_t at = out.size, add = strstr("HEAD GEOM ERRS ENDS", s->tag) ? more : 0;
        cvol_bytes_append(&out, data + s->offset, 24 + (size_t)s->length);
        cvol_bytes_append(&out, extra, add);
        put_u32(out.data + at + 8, (uint32_t)(s->length + add));
        if (add)
            put_u32(out.data + at + 16, cvol_crc32c(out.data + at + 24, (size_t)s->length + add));
        put_u32(out.data + at + 20, cvol_crc32c(out.data + at, 20));
    }
    *size = out.size;
    return out.data;
}

static void longer_sections_are_read(void **state)
{
    (void)state;
    cvol_array *array = container_small_array(), *back;
    const int order[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
    for (size_t more = 1; more < 60; more += 17) {
        size_t size;
        uint8_t *data = container_file_of(array, &size);
        uint8_t *longer = arrange(data, &size, order, 11, more);
        cvol_file_layout layout;
        assert_int_equal(cvol_layout_verify(context, &layout, longer, size, "f"), CVOL_OK);
        assert_int_equal(cvol_container_read(context, &back, longer, size, "f"), CVOL_OK);
        support_terms_expect_same(array, back);
        assert_true(back->error_bound.l2_error == array->error_bound.l2_error);
        cvol_array_free(back);
        free(longer);
        free(data);
    }
    cvol_array_free(array);
}

/* HEAD GEOM ERRS SUMM TABL INDX SHL0 SHL1 SHL2 SHL3 ENDS */
static void other_orders_are_refused(void **state)
{
    (void)state;
    static const struct {
        int order[12], count;
        const char *sentence;
    } cases[] = {
        {{0, 2, 3, 4, 5, 6, 7, 8, 9, 10}, 10, "section ERRS at byte 124 stands where GEOM must be"},
        {{1, 0, 2, 3, 4, 5, 6, 7, 8, 9, 10}, 11, "section GEOM at byte 12 stands where HEAD or "},
        {{0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, 12, "stands where GEOM must be"},
        {{0, 1, 3, 4, 5, 6, 7, 8, 9, 10},
         10,
         "section SUMM at byte 304 stands where ATTR or ERRS must"},
        {{0, 1, 2, 3, 5, 6, 7, 8, 9, 10}, 10, "stands where RNGE or TABL must be"},
        {{0, 1, 2, 5, 6, 7, 8, 9, 10},
         9,
         "stands where MODE or BRKS or TRUE or SMAL or SUMM or RNGE or TABL or TERM or SPEC must "
         "be"},
        {{0, 1, 2, 3, 4, 5, 6, 8, 7, 9, 10}, 11, "section SHL2 at byte "},
        {{0, 1, 2, 3, 4, 5, 6, 7, 8, 10}, 10, "stands where SHL3 must be"},
        {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 10}, 12, "24 bytes follow the end"},
        {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}, 10, "truncated: section CORR or ENDS at byte "},
        {{0}, 0, " at byte 12 has only 0 of the 24 bytes of its header"},
    };
    cvol_array *array = container_small_array();
    size_t size;
    uint8_t *data = container_file_of(array, &size);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        size_t other = size;
        uint8_t *moved = arrange(data, &other, cases[i].order, cases[i].count, 0);
        expect_refused(moved, other, CVOL_ERROR_CORRUPT, cases[i].sentence);
        free(moved);
    }
    free(data);
    cvol_array_free(array);
}

/* ---- INDX ------------------------------------------------------------------------------- */

/* The file with other bytes in INDX, from its byte `at` on, and valid checksums of that section. */
static void expect_index_refused(const uint8_t *file, size_t size, size_t at, uint8_t value,
                                 const char *sentence)
{
    cvol_file_layout layout;
    uint8_t *data = malloc(size);
    assert_non_null(data);
    memcpy(data, file, size);
    assert_int_equal(cvol_layout_walk(context, &layout, data, size, "f"), CVOL_OK);
    const cvol_file_section *index = &layout.sections[5];
    assert_string_equal(index->tag, "INDX");
    data[index->offset + 24 + at] = value;
    put_u32(data + index->offset + 16,
            cvol_crc32c(data + index->offset + 24, (size_t)index->length));
    put_u32(data + index->offset + 20, cvol_crc32c(data + index->offset, 20));
    expect_refused(data, size, CVOL_ERROR_CORRUPT, sentence);
    free(data);
}

static void invalid_indexes_are_refused(void **state)
{
    (void)state;
    /* One brick: four lengths of two bytes at most, four checksums. */
    cvol_array *array = support_terms_make(
        context,
        &(support_terms){.dims = {16, 16, 16}, .block = 16, .split = 0, .lapped = 0, .seed = 2});
    size_t size;
    uint8_t *data = container_file_of(array, &size);
    expect_index_refused(data, size, 0, 0, "section ");
    expect_index_refused(data, size, 0, 127, "section ");
    expect_index_refused(data, size, 0, 255, "section ");
    for (size_t at = 0; at < 20; at++)
        expect_index_refused(data, size, at, 0xf0, "f: ");
    free(data);
    cvol_array_free(array);
}

/* ---- attributes ------------------------------------------------------------------------- */

static void attributes_are_kept(void **state)
{
    (void)state;
    static const char *const texts[] = {"{}", "{\"a\": [1.50, \"\xc3\xbc\"],\n  \"b\":null}", "3",
                                        " [ ]\n"};
    for (int kind = 0; kind < 2; kind++)
        for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
            cvol_array *array = container_small_array(), *back;
            if (kind) {
                const cvol_grid grid = cvol_grid_make(9, 1, 1, CVOL_FLOAT32);
                cvol_array_free(array);
                assert_int_equal(cvol_array_create_as(context, &array, &grid, 1, CVOL_DHT, 0),
                                 CVOL_OK);
            }
            assert_null(cvol_array_attributes(array));
            assert_int_equal(cvol_array_set_attributes(context, array, texts[i]), CVOL_OK);
            assert_int_equal(cvol_array_write(context, array, file_path, NULL), CVOL_OK);
            assert_int_equal(cvol_array_read(context, &back, file_path, NULL), CVOL_OK);
            assert_string_equal(cvol_array_attributes(back), texts[i]);
            assert_int_equal(cvol_array_set_attributes(context, back, NULL), CVOL_OK);
            assert_null(cvol_array_attributes(back));
            assert_int_equal(cvol_array_write(context, back, file_path, NULL), CVOL_OK);
            cvol_array_free(back);
            assert_int_equal(cvol_array_read(context, &back, file_path, NULL), CVOL_OK);
            assert_null(cvol_array_attributes(back));
            cvol_array_free(back);
            cvol_array_free(array);
        }
}

static void invalid_json_is_refused(void **state)
{
    (void)state;
    static const char *const texts[] = {"", "{", "{a}", "{} {}", "\"\xff\"", "nil"};
    cvol_array *array = container_small_array();
    assert_int_equal(cvol_array_set_attributes(context, array, "1"), CVOL_OK);
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        assert_int_equal(cvol_array_set_attributes(context, array, texts[i]), CVOL_ERROR_ARGUMENT);
        assert_non_null(
            strstr(cvol_context_message(context), "attributes are not JSON text: line "));
    }
    assert_string_equal(cvol_array_attributes(array), "1");
    cvol_array_free(array);
    /* In a file: any text. */
    array = container_small_array();
    static const struct {
        const char *text;
        size_t size;
        int is;
    } cases[] = {{"{a", 2, 1},
                 {"\0", 1, 0},
                 {"\xc3", 1, 0},
                 {"\xe2\x82\xac", 3, 1},
                 {"\xe2\x82", 2, 0},
                 {"\xed\xa0\x80", 3, 0},
                 {"\xc0\x80", 2, 0},
                 {"\xf4\x90\x80\x80", 4, 0},
                 {"\xf0\x9f\x98\x80", 4, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        cvol_array *back;
        assert_int_equal(cvol_array_keep_attributes(context, array, cases[i].text, cases[i].size),
                         CVOL_OK);
        assert_int_equal(cvol_attributes_are_text(cases[i].text, cases[i].size), cases[i].is);
        if (memchr(cases[i].text, 0, cases[i].size))
            continue;
        assert_int_equal(cvol_array_write(context, array, file_path, NULL), CVOL_OK);
        assert_int_equal(cvol_array_read(context, &back, file_path, NULL),
                         cases[i].is ? CVOL_OK : CVOL_ERROR_CORRUPT);
        cvol_array_free(back);
    }
    cvol_array_free(array);
}

static void results_have_no_attributes(void **state)
{
    (void)state;
    cvol_array *array = container_small_array(), *twice;
    assert_int_equal(cvol_array_set_attributes(context, array, "[]"), CVOL_OK);
    assert_int_equal(cvol_array_scale(context, &twice, 2, array, 0), CVOL_OK);
    assert_null(cvol_array_attributes(twice));
    cvol_array_free(twice);
    cvol_array_free(array);
}

/* A PSNR of 999, which files of other programs may have, means infinite. */
static void large_psnr_round_trips(void **state)
{
    (void)state;
    cvol_array *array = container_small_array(), *back;
    size_t size;
    uint8_t *data = container_file_of(array, &size);
    cvol_file_layout layout;
    const double stored[] = {998.5, 999, 1e6, (double)INFINITY};
    assert_int_equal(cvol_layout_walk(context, &layout, data, size, "f"), CVOL_OK);
    for (size_t i = 0; i < sizeof stored / sizeof *stored; i++) {
        cvol_array_info info;
        for (int s = 0; s < layout.section_count; s++) {
            const cvol_file_section *section = &layout.sections[s];
            uint8_t *content = data + section->offset + 24;
            if (strcmp(section->tag, "ERRS"))
                continue;
            uint64_t bits;
            memcpy(&bits, &stored[i], sizeof bits);
            for (int b = 0; b < 8; b++)
                content[b] = (uint8_t)(bits >> 8 * b);
            put_u32(data + section->offset + 16, cvol_crc32c(content, (size_t)section->length));
            flag(data, section, section->flags);
        }
        assert_int_equal(cvol_container_read(context, &back, data, size, "f"), CVOL_OK);
        cvol_array_get_info(&info, back);
        assert_true(i ? isinf(info.psnr_db) && info.psnr_db > 0 : info.psnr_db == stored[0]);
        cvol_array_free(back);
    }
    free(data);
    cvol_array_free(array);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(unknown_sections_are_skipped),
        cmocka_unit_test(flags_are_checked),
        cmocka_unit_test(longer_sections_are_read),
        cmocka_unit_test(other_orders_are_refused),
        cmocka_unit_test(invalid_indexes_are_refused),
        cmocka_unit_test(attributes_are_kept),
        cmocka_unit_test(invalid_json_is_refused),
        cmocka_unit_test(results_have_no_attributes),
        cmocka_unit_test(large_psnr_round_trips),
    };
    return cmocka_run_group_tests(tests, files_setup, files_teardown);
}
