/* Files in parts: levels, prefixes, boxes; ranges; volumes of more than 2^32 samples. */
#include "test.h"

#include "base/context.h"
#include "codec/brick/subbands.h"
#include "codec/container/container.h"
#include "codec/container/layout.h"
#include "random.h"
#include "support.h"
#include "support_container.h"
#include "support_terms.h"

static int read_part(cvol_array **out, cvol_file_report *report, const uint8_t *data, size_t size,
                     cvol_file_part part)
{
    return cvol_container_read_part(context, out, report, data, size, &part, "f");
}

/* ---- all kinds -------------------------------------------------------------------------- */

static void every_kind_round_trips(void **state)
{
    (void)state;
    static const support_terms kinds[] = {
        {.dims = {70, 33, 20}, .block = 16},
        {.dims = {70, 33, 20}, .block = 16, .split = 1},
        {.dims = {130, 65, 17}, .block = 16, .split = 1, .lapped = 1, .seed = 5},
        {.dims = {65, 66, 9}, .block = 8},
        {.dims = {100, 40, 33}, .block = 32},
        {.dims = {1, 1, 1}, .block = 8},
        {.dims = {1, 200, 1}, .block = 16, .split = 1, .lapped = 1}};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        cvol_array *array = support_terms_make(context, &kinds[i]);
        cvol_array *back;
        size_t size;
        uint8_t *data = container_file_of(array, &size);
        assert_int_equal(cvol_file_verify(context, NULL, file_path), CVOL_OK);
        assert_int_equal(cvol_array_read(context, &back, file_path, NULL), CVOL_OK);
        support_terms_expect_same(array, back);
        assert_true(back->error_bound.l2_error == array->error_bound.l2_error);
        cvol_array_free(array);
        cvol_array_free(back);
        free(data);
    }
}

static void bytes_do_not_depend_on_threads(void **state)
{
    (void)state;
    cvol_array *array = support_terms_make(
        context,
        &(support_terms){.dims = {200, 200, 90}, .block = 16, .split = 1, .lapped = 1, .seed = 8});
    size_t size, other;
    uint8_t *data = container_file_of(array, &size);
    for (int threads = 1; threads <= 3; threads++) {
        cvol_context_set_threads(context, threads);
        uint8_t *again = container_file_of(array, &other);
        assert_int_equal(size, other);
        assert_memory_equal(data, again, size);
        free(again);
    }
    cvol_context_set_threads(context, 2);
    free(data);
    cvol_array_free(array);
}

/* ---- levels and prefixes ---------------------------------------------------------------- */

/* Tests if block i of `part` has exactly the array's terms of subbands 0 .. 3 - level. */
static void expect_block_level(const cvol_array *array, const cvol_array *part, size_t i, int level)
{
    const int bits = cvol_place_bits(array->block_log2);
    const cvol_block *x = &array->block_table[i], *y = &part->block_table[i];
    const uint32_t *a = x->terms, *b = y->terms;
    assert_int_equal(x->split, y->split);
    while (a < x->terms + x->words) {
        uint32_t p, q;
        const int32_t value = cvol_term_unpack(&a, &p, bits);
        if (cvol_subband_of(p, array->block_log2, x->split) > 3 - level)
            continue;
        assert_true(b < y->terms + y->words);
        assert_int_equal(cvol_term_unpack(&b, &q, bits), value);
        assert_int_equal(p, q);
    }
    assert_true(b == y->terms + y->words);
}

static void expect_level(const cvol_array *array, const cvol_array *part, int level)
{
    for (size_t i = 0; i < array->block_count; i++)
        expect_block_level(array, part, i, level);
}

/* The L2 distance of two evaluated arrays. */
static double distance_of(const cvol_array *a, const cvol_array *b)
{
    const size_t count = cvol_grid_samples(&a->grid), zero[3] = {0, 0, 0};
    float *x = malloc(4 * count), *y = malloc(4 * count);
    double sum = 0;
    assert_true(x && y);
    assert_int_equal(cvol_array_evaluate_real(context, x, a, zero, a->grid.dims), CVOL_OK);
    assert_int_equal(cvol_array_evaluate_real(context, y, b, zero, a->grid.dims), CVOL_OK);
    for (size_t i = 0; i < count; i++)
        sum += pow((double)x[i] - (double)y[i], 2);
    free(x);
    free(y);
    return sqrt(sum);
}

static void levels_have_the_low_frequencies(void **state)
{
    (void)state;
    for (int block = 8; block <= 32; block *= 2) {
        cvol_array *array = support_terms_make(context, &(support_terms){.dims = {70, 50, 40},
                                                                         .block = block,
                                                                         .split = block == 16,
                                                                         .lapped = block == 16,
                                                                         .seed = (uint64_t)block});
        size_t size;
        uint8_t *data = container_written(array, &size);
        for (int level = 0; level < 4; level++) {
            const cvol_file_part part = {.size = sizeof(cvol_file_part), .level = level};
            cvol_file_report report;
            cvol_array *coarse;
            assert_int_equal(cvol_array_read_part(context, &coarse, &report, file_path, &part),
                             CVOL_OK);
            assert_true(report.level == level && !report.cut && report.file_bytes == size);
            expect_level(array, coarse, level);
            const double distance = distance_of(array, coarse);
            const double said = coarse->error_bound.l2_error - array->error_bound.l2_error;
            if (!(distance <= said * 1.00001 + 1e-6 * array->error_bound.max_abs))
                fail_msg("block %d, level %d: %g is beyond %g", block, level, distance, said);
            assert_true(level ? said > 0 && said < 1e3 * (distance + 1) : said <= 0);
            cvol_array_free(coarse);
        }
        cvol_array_free(array);
        free(data);
    }
    for (int level = -1; level < 5; level += 5) {
        const cvol_file_part part = {.size = sizeof(cvol_file_part), .level = level};
        cvol_array *none;
        assert_int_equal(cvol_array_read_part(context, &none, NULL, file_path, &part),
                         CVOL_ERROR_ARGUMENT);
        assert_null(none);
    }
}

/* The ends of the content of each subband. */
static void find_subband_ends(uint64_t ends[4], const uint8_t *data, size_t size)
{
    cvol_file_layout layout;
    int subbands = 0;
    assert_int_equal(cvol_layout_walk(context, &layout, data, size, "f"), CVOL_OK);
    assert_int_equal(layout.level, 0);
    for (int i = 0; i < layout.section_count; i++)
        if (!strncmp(layout.sections[i].tag, "SHL", 3))
            ends[subbands++] = layout.sections[i].offset + 24 + layout.sections[i].length;
    assert_int_equal(subbands, 4);
}

static void every_prefix_decodes_its_level(void **state)
{
    (void)state;
    cvol_array *array = container_small_array(), *got;
    size_t size;
    uint8_t *data = container_file_of(array, &size);
    uint64_t ends[4];
    cvol_context_set_threads(context, 1); /* many short readings */
    find_subband_ends(ends, data, size);
    for (size_t cut = 0; cut < size; cut++) {
        int subbands = 0;
        cvol_file_report report;
        cvol_file_layout layout;
        uint8_t *exact = malloc(cut ? cut : 1); /* so that reading beyond it is detected */
        assert_non_null(exact);
        memcpy(exact, data, cut);
        while (subbands < 4 && cut >= ends[subbands])
            subbands++;
        const int code = read_part(&got, &report, exact, cut,
                                   (cvol_file_part){.size = sizeof(cvol_file_part), .cut = 1});
        assert_int_equal(code, subbands  ? CVOL_OK
                               : cut < 8 ? CVOL_ERROR_FORMAT
                                         : CVOL_ERROR_CORRUPT);
        if (subbands) {
            assert_true(report.cut && report.level == 4 - subbands);
            if (cut % 50 == 0 || cut == ends[subbands - 1])
                expect_level(array, got, report.level);
        }
        cvol_array_free(got);
        /* A request for all levels fails with the level that exists. */
        char sentence[64];
        snprintf(sentence, sizeof sentence, "; it is whole up to level %d", 4 - subbands);
        assert_int_equal(container_read_code(exact, cut),
                         cut < 8 ? CVOL_ERROR_FORMAT : CVOL_ERROR_CORRUPT);
        assert_true(!strstr(cvol_context_message(context), "; it is whole") == !subbands);
        assert_true(!subbands || strstr(cvol_context_message(context), sentence));
        assert_int_equal(cvol_layout_walk(context, &layout, exact, cut, "f"), CVOL_ERROR_CORRUPT);
        assert_int_equal(layout.level, subbands ? 4 - subbands : -1);
        /* A complete level is read as if the file were whole. */
        for (int level = 1; level < 4 && (cut % 11 == 0 || (subbands && cut == ends[subbands - 1]));
             level++) {
            assert_int_equal(
                !read_part(&got, &report, exact, cut,
                           (cvol_file_part){.size = sizeof(cvol_file_part), .level = level}),
                level >= 4 - subbands);
            cvol_array_free(got);
        }
        free(exact);
    }
    cvol_context_set_threads(context, 2);
    free(data);
    cvol_array_free(array);
}

/* ---- boxes ------------------------------------------------------------------------------ */

static void boxes_of_any_level_equal_crops(void **state)
{
    (void)state;
    cvol_array *array = support_terms_make(
        context,
        &(support_terms){.dims = {150, 140, 70}, .block = 16, .split = 1, .lapped = 1, .seed = 12});
    const size_t *dims = array->grid.dims;
    random_state r = {4};
    size_t size;
    free(container_file_of(array, &size));
    for (int i = 0; i < 60; i++) {
        size_t begin[3], end[3];
        for (int a = 0; a < 3; a++) {
            begin[a] = random_below(&r, 2) ? 64 * random_below(&r, (uint32_t)dims[a] / 64 + 1)
                                           : random_below(&r, (uint32_t)dims[a]);
            if (begin[a] == dims[a])
                begin[a]--;
            end[a] = begin[a] + 1 + random_below(&r, (uint32_t)(dims[a] - begin[a]));
        }
        const cvol_file_part all = {.size = sizeof(cvol_file_part), .level = i % 4},
                             part = {.size = sizeof(cvol_file_part),
                                     .begin = begin,
                                     .end = end,
                                     .level = i % 4};
        cvol_array *whole, *box;
        const cvol_grid grid = cvol_grid_box(&array->grid, begin, end);
        assert_int_equal(cvol_array_read_part(context, &whole, NULL, file_path, &all), CVOL_OK);
        assert_int_equal(cvol_array_read_part(context, &box, NULL, file_path, &part), CVOL_OK);
        void *x = malloc(cvol_grid_bytes(&grid)), *y = malloc(cvol_grid_bytes(&grid));
        assert_int_equal(cvol_array_evaluate_box(context, x, whole, begin, end), CVOL_OK);
        assert_int_equal(cvol_array_evaluate_box(context, y, box, begin, end), CVOL_OK);
        assert_memory_equal(x, y, cvol_grid_bytes(&grid));
        free(x);
        free(y);
        cvol_array_free(whole);
        cvol_array_free(box);
    }
    cvol_array_free(array);
}

static void boxes_ignore_other_bricks(void **state)
{
    (void)state;
    cvol_array *array = support_terms_make(
        context, &(support_terms){
                     .dims = {64 * 40, 16, 16}, .block = 16, .split = 1, .lapped = 0, .seed = 12});
    cvol_array *box;
    size_t size;
    uint64_t ends[4];
    uint8_t *data = container_file_of(array, &size);
    find_subband_ends(ends, data, size);
    data[ends[3] - 1] ^= 1; /* the last brick, so the third run, of the finest subband */
    const size_t zero[3] = {0, 0, 0}, near[3] = {64 * 32, 16, 16}, far[3] = {64 * 32 + 1, 16, 16};
    assert_int_equal(container_read_code(data, size), CVOL_ERROR_CORRUPT);
    assert_int_equal(
        read_part(&box, NULL, data, size,
                  (cvol_file_part){.size = sizeof(cvol_file_part), .begin = zero, .end = near}),
        CVOL_OK);
    cvol_array_free(box);
    assert_int_equal(
        read_part(&box, NULL, data, size,
                  (cvol_file_part){.size = sizeof(cvol_file_part), .begin = zero, .end = far}),
        CVOL_ERROR_CORRUPT);
    assert_non_null(strstr(cvol_context_message(context),
                           "section SHL3: the run of bricks from brick 32 of 40 is damaged"));
    free(data);
    cvol_array_free(array);
}

/* ---- levels of bricks ------------------------------------------------------------------- */

/* The content of a section of a file that is not packed. */
static size_t find_section(const uint8_t *data, size_t size, const char *tag)
{
    for (size_t at = 12; at + 24 <= size;) {
        uint64_t length = 0;
        if (!memcmp(data + at, tag, 4))
            return at + 24;
        for (size_t b = 0; b < 8; b++)
            length |= (uint64_t)data[at + 8 + b] << 8 * b;
        at += 24 + (size_t)length;
    }
    fail_msg("no section %s", tag);
    return 0;
}

/* Inverts the bytes of all runs of bricks that these levels do not need. Returns their number. */
static size_t damage_unneeded(uint8_t *data, size_t size, const uint8_t *levels, size_t bricks,
                              size_t run)
{
    const uint8_t *index = data + find_section(data, size, "INDX");
    size_t damaged = 0;
    for (int s = 0; s < 4; s++) {
        const char tag[] = {'S', 'H', 'L', (char)('0' + s), 0};
        uint8_t *at = data + find_section(data, size, tag);
        for (size_t first = 0; first < bricks; first += run) {
            size_t length = 0;
            int needed = 0;
            for (size_t b = first; b < first + run && b < bricks; b++) {
                size_t own = 0;
                for (int shift = 0;; shift += 7) {
                    own |= (size_t)(*index & 127) << shift;
                    if (*index++ < 128)
                        break;
                }
                length += own;
                needed |= levels[b] <= 3 - s;
            }
            for (size_t i = 0; i < length && !needed; i++)
                at[i] ^= 255;
            at += length;
            damaged += needed ? 0 : length;
        }
    }
    return damaged;
}

static void bricks_have_their_own_levels(void **state)
{
    (void)state;
    const struct {
        support_terms terms;
        int run; /* 1: bricks with runs of one */
    } kinds[] = {
        {{.dims = {200, 200, 90}, .block = 16, .split = 1, .lapped = 1, .seed = 21}, 1},
        {{.dims = {64 * 40, 16, 16}, .block = 16, .split = 1, .seed = 22}, 16},
        {{.dims = {130, 70, 100}, .block = 8, .seed = 23}, 1},
        {{.dims = {100, 130, 70}, .block = 32, .seed = 24}, 1},
    };
    const uint64_t seed = 77;
    random_state r = {seed};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        cvol_array *array = support_terms_make(context, &kinds[k].terms);
        if (kinds[k].run == 1)
            assert_int_equal(cvol_array_set_bricks(context, array, (int[3]){32, 64, 32}), CVOL_OK);
        const size_t bricks = cvol_brick_count(array);
        uint8_t *levels = malloc(bricks);
        size_t size, all_damaged = 0;
        uint8_t *data = container_file_of(array, &size);
        for (int i = 0; i < 12; i++) {
            const int finest = i % 3;
            int coarsest = finest;
            const uint32_t odds = 1 + random_below(&r, 20);
            for (size_t b = 0; b < bricks; b++) {
                levels[b] = (uint8_t)finest;
                if (random_below(&r, odds))
                    levels[b] = (uint8_t)(finest + (int)random_below(&r, 4 - (uint32_t)finest));
                coarsest = levels[b] > coarsest ? levels[b] : coarsest;
            }
            uint8_t *sparse = memcpy(malloc(size), data, size);
            all_damaged += damage_unneeded(sparse, size, levels, bricks, (size_t)kinds[k].run);
            cvol_array *mixed, *coarse;
            cvol_file_report report;
            const cvol_file_part part = {.size = sizeof part,
                                         .level = finest,
                                         .brick_levels = levels,
                                         .brick_count = bricks},
                                 whole = {.size = sizeof whole, .level = coarsest};
            assert_int_equal(read_part(&mixed, &report, sparse, size, part), CVOL_OK);
            assert_int_equal(report.level, finest);
            assert_int_equal(read_part(&coarse, NULL, data, size, whole), CVOL_OK);
            assert_true(mixed->error_bound.l2_error == coarse->error_bound.l2_error);
            assert_true(mixed->error_bound.max_abs == coarse->error_bound.max_abs);
            for (size_t b = 0; b < bricks; b++) {
                const cvol_brick_box box = cvol_brick_box_of(array, b);
                for (size_t j = 0; j < cvol_brick_box_blocks(&box); j++)
                    expect_block_level(array, mixed, cvol_brick_block_index(array, &box, j),
                                       levels[b]);
            }
            const double said = mixed->error_bound.l2_error - array->error_bound.l2_error;
            const double distance = distance_of(array, mixed);
            if (!(distance <= said * 1.00001 + 1e-6 * array->error_bound.max_abs))
                fail_msg("kind %zu, seed %llu, step %d: %g is beyond %g", k,
                         (unsigned long long)seed, i, distance, said);
            cvol_array_free(mixed);
            cvol_array_free(coarse);
            free(sparse);
        }
        assert_true(all_damaged > size);
        free(levels);
        free(data);
        cvol_array_free(array);
    }
}

static void expect_refused_levels(const uint8_t *data, size_t size, cvol_file_part part, int code,
                                  const char *words)
{
    cvol_array *array;
    part.size = sizeof part;
    assert_int_equal(read_part(&array, NULL, data, size, part), code);
    assert_null(array);
    if (!strstr(cvol_context_message(context), words))
        fail_msg("'%s' is not in: %s", words, cvol_context_message(context));
}

static void wrong_levels_of_bricks_are_refused(void **state)
{
    (void)state;
    cvol_array *array = support_terms_make(
        context, &(support_terms){.dims = {130, 70, 20}, .block = 16, .seed = 3});
    const size_t zero[3] = {0}, one[3] = {1, 1, 1};
    uint8_t levels[6] = {0, 0, 3, 1, 2, 0};
    size_t size, packed_size;
    uint8_t *data = container_file_of(array, &size);
    expect_refused_levels(data, size, (cvol_file_part){.brick_levels = levels, .brick_count = 5},
                          CVOL_ERROR_ARGUMENT, "there are levels of 5 bricks, the volume has 6");
    expect_refused_levels(data, size,
                          (cvol_file_part){.level = 1, .brick_levels = levels, .brick_count = 6},
                          CVOL_ERROR_ARGUMENT, "the level of brick 0 is 0, must be 1 to 3");
    expect_refused_levels(
        data, size,
        (cvol_file_part){.begin = zero, .end = one, .brick_levels = levels, .brick_count = 6},
        CVOL_ERROR_UNSUPPORTED, "without a box");
    levels[4] = 4;
    expect_refused_levels(data, size, (cvol_file_part){.brick_levels = levels, .brick_count = 6},
                          CVOL_ERROR_ARGUMENT, "the level of brick 4 is 4, must be 0 to 3");
    uint8_t *packed = container_written(array, &packed_size);
    expect_refused_levels(packed, packed_size,
                          (cvol_file_part){.brick_levels = levels, .brick_count = 6},
                          CVOL_ERROR_UNSUPPORTED, "not packed");
    free(packed);
    free(data);
    cvol_array_free(array);
}

/* ---- ranges and size -------------------------------------------------------------------- */

/* 8 blocks, of which one has all terms, or none has any. */
static cvol_array *ranged_array(int dense)
{
    const cvol_grid grid = cvol_grid_make(64, 64, 64, CVOL_FLOAT32);
    const uint32_t places = 32 * 32 * 32;
    random_state r = {7};
    cvol_array *array;
    uint32_t *words = malloc(8 * places), *to = words;
    assert_non_null(words);
    assert_int_equal(cvol_array_create(context, &array, &grid, 32), CVOL_OK);
    for (uint32_t place = 0; dense && place < places; place++)
        to += cvol_term_pack(to, place, 1 + (int32_t)random_below(&r, 9), cvol_place_bits(5));
    array->block_table[3].terms = words;
    array->block_table[3].words = (uint32_t)(to - words);
    cvol_block_find_low(&array->block_table[3], 5);
    array->coefficients = (uint64_t)(to - words);
    assert_int_equal(cvol_array_adopt_pool(context, array, words, (size_t)(to - words)), CVOL_OK);
    return array;
}

static void ranges_are_stored_if_cheap(void **state)
{
    (void)state;
    for (int dense = 0; dense < 2; dense++) {
        cvol_array *array = ranged_array(dense), *back;
        cvol_file_layout layout;
        assert_int_equal(cvol_array_ensure_ranges(context, array), CVOL_OK);
        assert_int_equal(cvol_array_write(context, array, file_path, NULL), CVOL_OK);
        assert_int_equal(cvol_file_verify(context, &layout, file_path), CVOL_OK);
        int has = 0;
        for (int i = 0; i < layout.section_count; i++)
            if (!strcmp(layout.sections[i].tag, "RNGE")) {
                has = 1;
                assert_true(24 + layout.sections[i].length <= layout.file_bytes / 100);
            }
        assert_int_equal(has, dense);
        assert_int_equal(cvol_array_read(context, &back, file_path, NULL), CVOL_OK);
        assert_int_equal(back->has_ranges, dense);
        for (size_t b = 0; b < array->block_count && dense; b++)
            assert_memory_equal(array->block_table[b].range, back->block_table[b].range, 2);
        cvol_array_free(back);
        /* They belong to all subbands. */
        assert_int_equal(
            cvol_array_read_part(context, &back, NULL, file_path, CVOL_FILE_PART(.level = 1)),
            CVOL_OK);
        assert_false(back->has_ranges);
        cvol_array_free(back);
        cvol_array_free(array);
    }
}

static void more_than_2_32_samples(void **state)
{
    (void)state;
    if (SIZE_MAX == UINT32_MAX) {
        print_message("skipped: a program of 32 bits refuses such sizes\n");
        return;
    }
    const cvol_grid grid = cvol_grid_make(5000, 1000, 1000, CVOL_UINT8);
    cvol_array *array, *back;
    uint32_t *words = malloc(4);
    assert_non_null(words);
    assert_true(cvol_grid_samples(&grid) > UINT32_MAX);
    assert_int_equal(cvol_array_create(context, &array, &grid, 32), CVOL_OK);
    /* One term, in the last block. */
    cvol_block *last = &array->block_table[array->block_count - 1];
    last->words = cvol_term_pack(words, 0, 1000, cvol_place_bits(5));
    last->terms = words;
    cvol_block_find_low(last, 5);
    assert_int_equal(cvol_array_adopt_pool(context, array, words, 1), CVOL_OK);
    array->coefficients = 1;
    array->error_bound.value_max = 255;
    assert_int_equal(cvol_array_write(context, array, file_path, NULL), CVOL_OK);
    assert_int_equal(cvol_array_read(context, &back, file_path, NULL), CVOL_OK);
    support_terms_expect_same(array, back);
    cvol_array_free(back);
    const size_t begin[3] = {4990, 990, 990}, end[3] = {4994, 994, 994};
    uint8_t samples[64];
    assert_int_equal(cvol_array_read_box(context, &back, file_path, begin, end, NULL), CVOL_OK);
    assert_int_equal(back->coefficients, 1);
    assert_int_equal(cvol_array_evaluate_box(context, samples, back, begin, end), CVOL_OK);
    assert_int_equal(samples[63], 6); /* 1000 / 32^1.5 = 5.5 */
    cvol_array_free(back);
    cvol_array_free(array);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kind_round_trips),
        cmocka_unit_test(bytes_do_not_depend_on_threads),
        cmocka_unit_test(levels_have_the_low_frequencies),
        cmocka_unit_test(every_prefix_decodes_its_level),
        cmocka_unit_test(boxes_of_any_level_equal_crops),
        cmocka_unit_test(boxes_ignore_other_bricks),
        cmocka_unit_test(bricks_have_their_own_levels),
        cmocka_unit_test(wrong_levels_of_bricks_are_refused),
        cmocka_unit_test(ranges_are_stored_if_cheap),
        cmocka_unit_test(more_than_2_32_samples),
    };
    return cmocka_run_group_tests(tests, files_setup, files_teardown);
}
