/* Files of arrays that are not volumes: whole ones, and blocks of any rank and transform. Round
 * trips, and cut, flipped, invalid and fuzzed files. */
#include "test.h"

#include "base/context.h"
#include "codec/container/array_file.h"
#include "codec/section/packed.h"
#include "codec/section/section.h"
#include "cvol/render.h"
#include "random.h"
#include "support.h"

#include "fuzz/fuzz_cvol.c"
#include "support_context.h"

/* Places in a file: signature 8, version 4, then HEAD, GEOM and ERRS, each behind a header of
 * 24. */
enum { HEAD_AT = 36, STEP_AT = HEAD_AT + 48, COUNT_AT = HEAD_AT + 80 };
enum { CONTENT_AT = HEAD_AT + 88 + 24 + 156 + 24 + 76 + 24 };

/* ---- arrays of any kind, of random terms ----------------------------------------------------- */

typedef struct kind {
    size_t dims[3];
    int rank;
    cvol_transform transform;
    int block;
    size_t k;
    int sparse; /* the number of a hundred other places, or places in a block, that have a term */
} kind;

static const kind kinds[] = {
    {{100, 1, 1}, 1, CVOL_DCT, 0, 5, 10},  {{101, 1, 1}, 1, CVOL_DFT, 0, 7, 20},
    {{24, 17, 1}, 2, CVOL_DHT, 0, 4, 5},   {{9, 8, 7}, 3, CVOL_DCT, 0, 3, 10},
    {{9, 8, 7}, 3, CVOL_DFT, 0, 0, 30},    {{6, 5, 4}, 3, CVOL_DHT, 0, 3, 0},
    {{1, 1, 1}, 1, CVOL_DCT, 0, 1, 0},     {{100, 1, 1}, 1, CVOL_DCT, 8, 0, 20},
    {{50, 40, 1}, 2, CVOL_DFT, 16, 0, 10}, {{20, 21, 22}, 3, CVOL_DHT, 8, 0, 3},
    {{40, 40, 33}, 3, CVOL_DFT, 32, 0, 1}, {{30, 30, 1}, 2, CVOL_DCT, 32, 0, 0},
};
enum { KINDS = sizeof kinds / sizeof *kinds };

static void fill_whole(cvol_array *array, const kind *k, random_state *r)
{
    const size_t *dims = array->grid.dims, count = cvol_grid_samples(&array->grid);
    cvol_spectrum *whole = &array->whole;
    const size_t low[3] = {k->k, k->k, k->k};
    assert_int_equal(cvol_spectrum_start(context, whole, array->transform, dims, low), CVOL_OK);
    assert_int_equal(cvol_spectrum_reserve(context, whole, count), CVOL_OK);
    for (size_t i = 0; i < whole->low_count; i++)
        whole->low_values[i] = (float)(100 * random_signed(r));
    for (size_t place = 0; place < count; place++) {
        const size_t at[3] = {place % dims[0], place / dims[0] % dims[1],
                              place / dims[0] / dims[1]};
        int inside = whole->low_count > 0;
        for (int a = 0; a < 3; a++)
            inside &= cvol_box_index(at[a], whole->low[a], whole->box[a], dims[a]) != SIZE_MAX;
        if (inside || (int)random_below(r, 100) >= k->sparse)
            continue;
        whole->places[whole->sparse_count] = (uint32_t)place;
        whole->values[whole->sparse_count++] = (float)random_signed(r);
    }
}

static void fill_blocks(cvol_array *array, const kind *k, random_state *r)
{
    const size_t per_block = cvol_array_block_terms(array);
    uint32_t *words = malloc(2 * per_block * array->block_count * sizeof *words + 1), *to = words;
    assert_non_null(words);
    for (size_t b = 0; b < array->block_count; b++) {
        cvol_block *block = &array->block_table[b];
        block->terms = to;
        for (uint32_t place = 0; place < per_block; place++) {
            if ((int)random_below(r, 100) >= k->sparse)
                continue;
            int32_t value = (int32_t)random_below(r, 40) - 20;
            if (random_below(r, 50) == 0)
                value = (int32_t)random_below(r, 2000000000) - 1000000000; /* escapes */
            if (!value)
                value = 1;
            to += cvol_term_pack(to, place, value, cvol_place_bits(array->block_log2));
            array->coefficients++;
        }
        block->words = (uint32_t)(to - block->terms);
        cvol_block_find_low(block, array->block_log2);
    }
    assert_int_equal(cvol_array_adopt_pool(context, array, words, (size_t)(to - words)), CVOL_OK);
    array->step = 0.25;
    array->offset = 12;
}

static cvol_array *make_array(const kind *k, uint64_t seed)
{
    cvol_grid grid = cvol_grid_make(k->dims[0], k->dims[1], k->dims[2], CVOL_FLOAT32);
    random_state r = {seed};
    cvol_array *array;
    int code = cvol_array_create_as(context, &array, &grid, k->rank, k->transform, k->block);
    assert_int_equal(code, CVOL_OK);
    if (k->block)
        fill_blocks(array, k, &r);
    else
        fill_whole(array, k, &r);
    array->error_bound = (cvol_error_bound){
        .l2_error = 0.5, .max_abs = 77.25, .value_min = -70.5, .value_max = 80};
    array->threshold = 0.125;
    cvol_array_derive_figures(array);
    return array;
}

static uint8_t *make_file(const kind *k, uint64_t seed, size_t *size)
{
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvol");
    cvol_array *array = make_array(k, seed);
    uint64_t file_bytes;
    assert_int_equal(cvol_array_write(context, array, path, &file_bytes), CVOL_OK);
    uint8_t *data = support_read(path, size);
    assert_int_equal(*size, file_bytes);
    cvol_array_free(array);
    free(path);
    support_folder_remove(folder);
    return data;
}

static int read_code(const uint8_t *data, size_t size)
{
    cvol_array *array = NULL;
    int code = cvol_container_read(context, &array, data, size, "f.cvol");
    cvol_array_free(array);
    return code;
}

/* ---- whole files ----------------------------------------------------------------------------- */

static void expect_same_terms(const cvol_array *a, const cvol_array *b)
{
    const cvol_spectrum *s = &a->whole, *t = &b->whole;
    assert_memory_equal(s->low, t->low, sizeof s->low);
    assert_memory_equal(s->box, t->box, sizeof s->box);
    assert_int_equal(s->low_count, t->low_count);
    assert_int_equal(s->sparse_count, t->sparse_count);
    if (s->low_count)
        assert_memory_equal(s->low_values, t->low_values, s->low_count * 4);
    if (s->sparse_count) {
        assert_memory_equal(s->places, t->places, s->sparse_count * 4);
        assert_memory_equal(s->values, t->values, s->sparse_count * 4);
    }
    assert_int_equal(a->coefficients, b->coefficients);
    for (size_t i = 0; a->block && i < a->block_count; i++) {
        const cvol_block *x = &a->block_table[i], *y = &b->block_table[i];
        assert_int_equal(x->words, y->words);
        assert_memory_equal(x->low, y->low, 3);
        if (x->words)
            assert_memory_equal(x->terms, y->terms, 4 * x->words);
    }
}

static void files_keep_everything(void **state)
{
    (void)state;
    for (int i = 0; i < KINDS; i++) {
        size_t size;
        cvol_array *array = make_array(&kinds[i], (uint64_t)i + 1), *back;
        uint8_t *data = make_file(&kinds[i], (uint64_t)i + 1, &size);
        void *memory; /* the same bytes */
        size_t held;
        assert_int_equal(cvol_array_write_memory(context, array, &memory, &held), CVOL_OK);
        assert_int_equal(held, size);
        assert_memory_equal(memory, data, size);
        int code = cvol_array_read_memory(context, &back, memory, held, "f.cvol");
        free(memory);
        if (code)
            print_message("kind %d: %s\n", i, cvol_context_message(context));
        assert_int_equal(code, CVOL_OK);
        cvol_array_info a, b;
        cvol_array_get_info(&a, array);
        cvol_array_get_info(&b, back);
        assert_true(a.rank == b.rank && a.transform == b.transform && a.block == b.block);
        assert_true(a.l2_error == b.l2_error && a.max_abs == b.max_abs);
        assert_true(a.value_min == b.value_min && a.value_max == b.value_max);
        assert_true(a.measured == b.measured && a.psnr_db == b.psnr_db);
        assert_true(a.max_error == b.max_error && a.step == b.step && a.rho == b.rho);
        assert_true(array->threshold == back->threshold && array->offset == back->offset);
        expect_same_terms(array, back);
        free(data);
        cvol_array_free(array);
        cvol_array_free(back);
    }
}

static void truncation_is_detected(void **state)
{
    (void)state;
    for (int i = 0; i < KINDS; i++) {
        size_t size;
        uint8_t *data = make_file(&kinds[i], 5, &size);
        for (size_t cut = 0; cut < size; cut += cut < CONTENT_AT + 64 ? 1 : 1 + size / 200) {
            uint8_t *exact = malloc(cut ? cut : 1);
            assert_non_null(exact);
            memcpy(exact, data, cut);
            assert_int_equal(read_code(exact, cut),
                             cut < 8 ? CVOL_ERROR_FORMAT : CVOL_ERROR_CORRUPT);
            free(exact);
        }
        free(data);
    }
}

static void flipped_bytes_are_detected(void **state)
{
    (void)state;
    for (int i = 0; i < KINDS; i++) {
        size_t size;
        uint8_t *data = make_file(&kinds[i], 5, &size);
        random_state r = {17};
        for (size_t at = 0; at < size; at += at < CONTENT_AT + 64 ? 1 : 1 + size / 500) {
            const uint8_t flip = (uint8_t)(1u << random_below(&r, 8));
            data[at] ^= flip;
            assert_int_not_equal(read_code(data, size), CVOL_OK);
            data[at] ^= flip;
        }
        assert_int_equal(read_code(data, size), CVOL_OK);
        free(data);
    }
}

static void trailing_bytes_are_refused(void **state)
{
    (void)state;
    for (int i = 0; i < KINDS; i++) {
        size_t size;
        uint8_t *data = make_file(&kinds[i], 5, &size);
        data = realloc(data, size + 1);
        assert_non_null(data);
        data[size] = 0;
        assert_int_equal(read_code(data, size + 1), CVOL_ERROR_CORRUPT);
        assert_non_null(strstr(cvol_context_message(context), "f.cvol: 1 bytes follow the end"));
        free(data);
    }
}

/* ---- invalid values with valid checksums ----------------------------------------------------- */

static int overwrite_u64(const kind *k, size_t at, uint64_t value)
{
    size_t size;
    uint8_t *data = make_file(k, 5, &size);
    for (int i = 0; i < 8; i++)
        data[at + (size_t)i] = (uint8_t)(value >> 8 * i);
    fuzz_repair(data, size);
    int code = read_code(data, size);
    free(data);
    return code;
}

static void expect_refused_value(const kind *k, size_t at, uint64_t value, const char *sentence)
{
    int code = overwrite_u64(k, at, value);
    assert_int_not_equal(code, CVOL_OK);
    if (!strstr(cvol_context_message(context), sentence))
        fail_msg("'%s' must be in: %s", sentence, cvol_context_message(context));
}

static void invalid_fields_are_refused(void **state)
{
    (void)state;
    const kind *line = &kinds[0], *whole = &kinds[3], *blocks = &kinds[9];
    assert_int_equal(overwrite_u64(line, CONTENT_AT, 5), CVOL_OK); /* the unchanged value */
    expect_refused_value(line, CONTENT_AT, 101, "k along x is 101, must be 1 to 100");
    expect_refused_value(line, CONTENT_AT, UINT64_MAX, "k along x");
    expect_refused_value(line, CONTENT_AT + 8, 2, "k along y is 2");
    expect_refused_value(line, CONTENT_AT + 8, 0, "k along y is 0");
    expect_refused_value(line, CONTENT_AT, 4, "section SPEC");
    expect_refused_value(line, CONTENT_AT + 24, 96, "s is 96, there are 95 other places");
    expect_refused_value(line, CONTENT_AT + 24, UINT64_MAX, "s is 184467");
    expect_refused_value(line, CONTENT_AT + 24, 3, "section SPEC");
    expect_refused_value(line, COUNT_AT, 3, "section HEAD says 3");
    expect_refused_value(whole, HEAD_AT, UINT64_C(1) << 33, "f.cvol");
    expect_refused_value(whole, HEAD_AT, UINT64_C(1) << 27,
                         SIZE_MAX > UINT32_MAX ? "a whole array" : "limit of 4294967295 bytes");
    expect_refused_value(whole, CONTENT_AT, 4, "section SPEC");
    expect_refused_value(&kinds[7], HEAD_AT, UINT64_C(1) << 33,
                         SIZE_MAX > UINT32_MAX ? "more than a file of this size can hold"
                                               : "more than a program of 32 bits can address");
    expect_refused_value(blocks, HEAD_AT, 40, "section TERM");
    expect_refused_value(blocks, COUNT_AT, 1, "section TERM");
    expect_refused_value(blocks, COUNT_AT, UINT64_C(1) << 60, "coefficients in 27 blocks");
    expect_refused_value(blocks, STEP_AT, UINT64_C(0x47E0000000000000),
                         "section TERM"); /* step 2^127 */
}

/* A file with given content and valid checksums. */
static int read_content(const kind *k, uint64_t coefficients, const cvol_bytes *prefix,
                        const cvol_bytes *raw)
{
    size_t size;
    uint8_t *data = make_file(k, 5, &size);
    cvol_bytes content = {0}, file = {0};
    cvol_bytes_append(&content, prefix->data, prefix->size);
    assert_int_equal(cvol_packed_put(context, &content, raw), CVOL_OK);
    cvol_bytes_append(&file, data, CONTENT_AT - 24);
    cvol_section_put(&file, k->block ? CVOL_TERM : CVOL_SPEC, &content);
    cvol_section_put(&file, CVOL_ENDS, &(cvol_bytes){0});
    for (int i = 0; i < 8; i++)
        file.data[COUNT_AT + i] = (uint8_t)(coefficients >> 8 * i);
    fuzz_repair(file.data, file.size);
    int code = read_code(file.data, file.size);
    cvol_bytes_free(&content);
    cvol_bytes_free(&file);
    free(data);
    return code;
}

/* A line of 100 with k = 5 and two others. */
static int read_line(float low, uint32_t first, uint32_t second, float value)
{
    cvol_bytes prefix = {0}, raw = {0};
    const float box[5] = {low, 1, 1, 1, 1}, others[2] = {1, value};
    const uint32_t places[2] = {first, second};
    cvol_bytes_put_u64(&prefix, 5);
    cvol_bytes_put_u64(&prefix, 1);
    cvol_bytes_put_u64(&prefix, 1);
    cvol_bytes_put_u64(&prefix, 2);
    cvol_planes_put(&raw, box, 5, 4);
    cvol_planes_put(&raw, places, 2, 4);
    cvol_planes_put(&raw, others, 2, 4);
    int code = read_content(&kinds[0], 7, &prefix, &raw);
    cvol_bytes_free(&prefix);
    cvol_bytes_free(&raw);
    return code;
}

static void places_and_values_are_checked(void **state)
{
    (void)state;
    const float huge = 3e38f;
    assert_int_equal(read_line(1, 5, 0, 1), CVOL_OK);
    assert_int_equal(read_line(1, 5, 93, 1), CVOL_OK);
    assert_int_equal(read_line(1, 5, 94, 1), CVOL_ERROR_CORRUPT);
    assert_non_null(strstr(cvol_context_message(context), "a place is beyond the array"));
    assert_int_equal(read_line(1, 5, UINT32_MAX, 1), CVOL_ERROR_CORRUPT);
    assert_int_equal(read_line(1, 4, 0, 1), CVOL_ERROR_CORRUPT);
    assert_non_null(strstr(cvol_context_message(context), "a place is within the low box"));
    assert_int_equal(read_line((float)NAN, 5, 0, 1), CVOL_ERROR_CORRUPT);
    assert_int_equal(read_line(1, 5, 0, -(float)INFINITY), CVOL_ERROR_CORRUPT);
    assert_int_equal(read_line(huge, 5, 0, 1), CVOL_ERROR_CORRUPT);
}

/* 13 blocks of 8 with two terms in the first. */
static int read_blocks(uint32_t count, uint32_t first, uint32_t second, uint32_t value)
{
    cvol_bytes prefix = {0}, raw = {0};
    const uint32_t counts[13] = {count}, places[2] = {first, second}, values[2] = {2, value};
    cvol_planes_put(&raw, counts, 13, 4);
    cvol_planes_put(&raw, places, 2, 2);
    cvol_planes_put(&raw, values, 2, 4);
    int code = read_content(&kinds[7], 2, &prefix, &raw);
    cvol_bytes_free(&raw);
    return code;
}

static void blocks_are_checked(void **state)
{
    (void)state;
    assert_int_equal(read_blocks(2, 3, 0, 1), CVOL_OK);
    assert_int_equal(read_blocks(2, 3, 3, 1), CVOL_OK);
    assert_int_equal(read_blocks(2, 3, 4, 1), CVOL_ERROR_CORRUPT);
    assert_non_null(strstr(cvol_context_message(context), "a place is beyond its block"));
    assert_int_equal(read_blocks(2, 3, 65535, 1), CVOL_ERROR_CORRUPT);
    assert_int_equal(read_blocks(1, 3, 0, 1), CVOL_ERROR_CORRUPT);
    assert_int_equal(read_blocks(3, 3, 0, 1), CVOL_ERROR_CORRUPT);
    assert_int_equal(read_blocks(UINT32_MAX, 3, 0, 1), CVOL_ERROR_CORRUPT);
    assert_int_equal(read_blocks(2, 3, 0, 0), CVOL_ERROR_CORRUPT);
    assert_int_equal(read_blocks(2, 3, 0, UINT32_MAX), CVOL_ERROR_CORRUPT);
    assert_int_equal(read_blocks(2, 3, 0, UINT32_C(2) << 30), CVOL_OK);
    assert_int_equal(read_blocks(2, 3, 0, (UINT32_C(2) << 30) + 2), CVOL_ERROR_CORRUPT);
}

static void sizes_are_checked_against_limits(void **state)
{
    (void)state;
    cvol_bytes raw = {0}, packed = {0};
    uint8_t *out;
    assert_true(cvol_bytes_reserve(&raw, 1000000));
    memset(raw.data, 0, raw.size = 1000000);
    assert_int_equal(cvol_packed_put(context, &packed, &raw), CVOL_OK);
    cvol_cursor cursor = cvol_cursor_make(packed.data, packed.size);
    assert_int_equal(cvol_packed_take(context, &out, 1000000, &cursor, "TERM", "f"), CVOL_OK);
    free(out);
    static const uint64_t wrong[] = {0, 999999, 1000001, UINT64_C(1) << 40, UINT64_MAX};
    for (int i = 0; i < 5; i++) {
        cursor = cvol_cursor_make(packed.data, packed.size);
        assert_int_equal(cvol_packed_take(context, &out, wrong[i], &cursor, "TERM", "f"),
                         CVOL_ERROR_CORRUPT);
    }
    cvol_context_set_limit_bytes(context, 999999);
    cursor = cvol_cursor_make(packed.data, packed.size);
    assert_int_equal(cvol_packed_take(context, &out, 1000000, &cursor, "TERM", "f"),
                     CVOL_ERROR_LIMIT);
    cvol_context_set_limit_bytes(context, UINT64_C(1) << 36);
    cvol_bytes_free(&raw);
    cvol_bytes_free(&packed);
}

static void too_large_terms_are_not_written(void **state)
{
    (void)state;
    char *folder = support_folder_make(), *path = support_path(folder, "a.cvol");
    for (int i = 0; i < 2; i++) {
        cvol_array *array = make_array(&kinds[i ? 9 : 3], 3);
        if (i)
            array->step = 3e38;
        else
            array->whole.low_values[0] = 3e38f;
        assert_int_equal(cvol_array_write(context, array, path, NULL), CVOL_ERROR_DATA);
        assert_int_equal(support_folder_count(folder), 0);
        cvol_array_free(array);
    }
    free(path);
    support_folder_remove(folder);
}

/* ---- only volumes ---------------------------------------------------------------------------- */

static void only_volumes_are_rendered(void **state)
{
    (void)state;
    for (int i = 0; i < KINDS; i++) {
        cvol_array *array = make_array(&kinds[i], 3);
        cvol_renderer *renderer;
        cvol_histogram histogram;
        assert_int_equal(cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET,
                                              CVOL_SOURCE(.array = array)),
                         CVOL_ERROR_UNSUPPORTED);
        assert_null(renderer);
        assert_int_equal(cvol_array_compute_histogram(context, &histogram, array),
                         CVOL_ERROR_UNSUPPORTED);
        assert_non_null(strstr(cvol_context_message(context), "needs a volume in DCT blocks"));
        cvol_array_free(array);
    }
}

/* ---- fuzzing --------------------------------------------------------------------------------- */

static void mutations_do_not_crash(void **state)
{
    (void)state;
    random_state r = {2025};
    for (int i = 0; i < KINDS; i++) {
        size_t size;
        uint8_t *data = make_file(&kinds[i], 5, &size), *changed = malloc(size);
        assert_non_null(changed);
        for (int attempt = 0; attempt < 300; attempt += SUPPORT_STRIDE) {
            memcpy(changed, data, size);
            for (uint32_t changes = 1 + random_below(&r, 4); changes > 0; changes--) {
                /* Half of them in fields. */
                const uint32_t among = random_below(&r, 2) && size > 400 ? 400 : (uint32_t)size;
                changed[random_below(&r, among)] ^= (uint8_t)(1u << random_below(&r, 8));
            }
            LLVMFuzzerTestOneInput(changed, size);
        }
        free(changed);
        free(data);
    }
}

/* Only volumes in dct blocks of 16 may have lapped or split blocks; no operation makes others. */
static void lapped_blocks_are_of_volumes(void **state)
{
    (void)state;
    const cvol_grid grid = cvol_grid_make(20, 20, 20, CVOL_FLOAT32);
    cvol_array *array;
    uint64_t bytes;
    check_ok(cvol_array_create_as(context, &array, &grid, 3, CVOL_DHT, 16));
    check_ok(cvol_array_file_bytes(context, array, &bytes));
    array->lapped = 1;
    assert_int_equal(cvol_array_file_bytes(context, array, &bytes), CVOL_ERROR_UNSUPPORTED);
    assert_string_equal(cvol_context_message(context),
                        "only volumes in dct blocks may be lapped or split in a file");
    cvol_array_free(array);
}

static void sizes_of_options_are_checked(void **state)
{
    (void)state;
    const cvol_file_part part = {.size = 3};
    cvol_grid grid;
    cvol_array *array;
    assert_int_equal(cvol_file_read_grid(context, &grid, "a.cvol", &part), CVOL_ERROR_ARGUMENT);
    assert_non_null(strstr(cvol_context_message(context), "cvol_file_part"));
    assert_int_equal(cvol_array_read_part(context, &array, NULL, "a.cvol", &part),
                     CVOL_ERROR_ARGUMENT);
    assert_null(array);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_keep_everything),
        cmocka_unit_test(truncation_is_detected),
        cmocka_unit_test(flipped_bytes_are_detected),
        cmocka_unit_test(trailing_bytes_are_refused),
        cmocka_unit_test(invalid_fields_are_refused),
        cmocka_unit_test(places_and_values_are_checked),
        cmocka_unit_test(blocks_are_checked),
        cmocka_unit_test(sizes_are_checked_against_limits),
        cmocka_unit_test(too_large_terms_are_not_written),
        cmocka_unit_test(only_volumes_are_rendered),
        cmocka_unit_test(lapped_blocks_are_of_volumes),
        cmocka_unit_test(sizes_of_options_are_checked),
        cmocka_unit_test(mutations_do_not_crash),
    };
    return cmocka_run_group_tests(tests, context_setup_two, context_teardown);
}
