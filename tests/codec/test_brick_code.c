/* The brick coder: bricks round trip; subbands decode without finer ones; damage does not crash. */
#include "test.h"

#include "codec/brick/brick_code.h"
#include "codec/entropy/token_stream.h"
#include "random.h"
#include "transform/cell.h"

static cvol_token_tables *default_tables(void)
{
    cvol_token_tables *tables = cvol_token_tables_create();
    assert_non_null(tables);
    return tables;
}

/* ---- tables ----------------------------------------------------------------------------- */

static void test_rows_are_whole(void **state)
{
    (void)state;
    cvol_token_tables *tables = default_tables();
    for (int r = 0; r < CVOL_ROWS; r++) {
        for (int t = 0; t < CVOL_TOKENS; t++)
            assert_true(tables->rows[r].bounds[8 + t] > tables->rows[r].bounds[7 + t]);
        assert_int_equal(tables->rows[r].bounds[23], 1 << CVOL_TOKEN_SCALE);
    }
    free(tables);
}

static void test_tables_pass_through_their_section(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    for (uint64_t seed = 1; seed <= 20; seed++) {
        random_state random = (random_state){seed};
        cvol_token_tables *tables = default_tables(), *read = default_tables();
        for (int i = 0; i < 300; i++) {
            const int r = (int)random_below(&random, CVOL_ROWS);
            const int t = (int)random_below(&random, CVOL_TOKEN_CODES);
            const int code = cvol_token_defaults[r][t] +
                             CVOL_CODE_STEP * ((int)random_below(&random, 200) - 100);
            tables->codes[r][t] = (uint8_t)(code < 0 || code > 255 ? cvol_token_defaults[r][t]
                                                                   : code);
        }
        cvol_token_tables_commit(tables);
        cvol_bytes bytes = {0};
        assert_int_equal(cvol_token_tables_put(context, &bytes, tables), CVOL_OK);
        cvol_cursor cursor = cvol_cursor_make(bytes.data, bytes.size);
        assert_int_equal(cvol_token_tables_take(context, read, &cursor, "file"), CVOL_OK);
        if (memcmp(read->codes, tables->codes, sizeof read->codes) ||
            memcmp(read->rows, tables->rows, sizeof read->rows))
            fail_msg("seed %llu: other tables", (unsigned long long)seed);
        cvol_bytes_free(&bytes);
        free(tables);
        free(read);
    }
    cvol_context_free(context);
}

static void test_fitted_tables_save_bits(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_token_tables *tables = default_tables(), *fitted = default_tables();
    cvol_token_counts *counts = calloc(1, sizeof *counts);
    assert_non_null(counts);
    const int row = CVOL_ROW_VALUE + 700;
    for (int t = 0; t < CVOL_TOKENS; t++)
        counts->of[row][t] = t == 9 ? 5000 : 10;
    cvol_token_tables_fit(fitted, counts);
    cvol_bytes before = {0}, after = {0}, section = {0};
    cvol_token_writer writer = {0};
    for (int way = 0; way < 2; way++) {
        cvol_token_writer_start(&writer);
        for (uint32_t t = 0; t < CVOL_TOKENS; t++)
            for (uint64_t i = 0; i < counts->of[row][t]; i++)
                cvol_token_put(&writer, row, t);
        assert_true(
            cvol_token_writer_finish(&writer, way ? fitted : tables, way ? &after : &before));
    }
    assert_int_equal(cvol_token_tables_put(context, &section, fitted), CVOL_OK);
    assert_true(after.size + section.size < before.size / 2);
    for (int r = 0; r < CVOL_ROWS; r++)
        if (r != row)
            assert_memory_equal(fitted->codes[r], cvol_token_defaults[r], CVOL_TOKEN_CODES);
    cvol_token_writer_free(&writer);
    cvol_bytes_free(&before);
    cvol_bytes_free(&after);
    cvol_bytes_free(&section);
    free(tables);
    free(fitted);
    free(counts);
    cvol_context_free(context);
}

/* ---- streams ---------------------------------------------------------------------------- */

static void test_streams_round_trip(void **state)
{
    (void)state;
    cvol_token_tables *tables = default_tables();
    cvol_token_writer writer = {0};
    for (uint64_t seed = 1; seed <= 60; seed++) {
        random_state random = (random_state){seed};
        const size_t count = random_below(&random, seed % 3 ? 40 : 20000);
        cvol_bytes bytes = {0};
        cvol_token_writer_start(&writer);
        random_state again = random;
        for (size_t i = 0; i < count; i++) {
            const int row = (int)random_below(&random, CVOL_ROWS);
            cvol_token_put(&writer, row, random_below(&random, CVOL_TOKENS));
            const int bits = (int)random_below(&random, 33);
            cvol_raw_put(&writer, (uint32_t)random_u64(&random), bits);
        }
        assert_true(cvol_token_writer_finish(&writer, tables, &bytes));
        cvol_token_reader reader;
        cvol_token_reader_start(&reader, tables, bytes.data, bytes.size);
        for (size_t i = 0; i < count; i++) {
            const int row = (int)random_below(&again, CVOL_ROWS);
            const uint32_t token = (uint32_t)random_below(&again, CVOL_TOKENS);
            const int bits = (int)random_below(&again, 33);
            const uint32_t raw = (uint32_t)(random_u64(&again) & ((UINT64_C(1) << bits) - 1));
            if (cvol_token_take(&reader, row) != token || cvol_raw_take(&reader, bits) != raw)
                fail_msg("seed %llu: number %zu is another", (unsigned long long)seed, i);
        }
        if (!cvol_token_reader_ended(&reader))
            fail_msg("seed %llu: not at the end", (unsigned long long)seed);
        cvol_bytes_free(&bytes);
    }
    cvol_token_writer_free(&writer);
    free(tables);
}

/* ---- bricks ----------------------------------------------------------------------------- */

/* Fills an array with random terms, of all valid magnitudes, and random splits. */
static cvol_array *random_array(cvol_context *context, random_state *random, int block,
                                const size_t dims[3])
{
    const cvol_grid grid = cvol_grid_make(dims[0], dims[1], dims[2], CVOL_FLOAT32);
    cvol_array *array;
    assert_int_equal(cvol_array_create(context, &array, &grid, block), CVOL_OK);
    array->step = 1e-6;
    const int count = block * block * block, bits = cvol_place_bits(array->block_log2);
    for (size_t b = 0; b < array->block_count; b++) {
        cvol_block *to = &array->block_table[b];
        uint32_t *words = malloc(2 * sizeof *words * (size_t)count), n = 0;
        assert_non_null(words);
        const uint32_t density = random_below(random, 3) ? 1 + random_below(random, 40) : 4000;
        const int magnitude = 1 + (int)random_below(random, 30);
        if (block == 16 && random_below(random, 2))
            to->split = random_below(random, 3) == 0
                            ? CVOL_CELL_FOURS
                            : (uint16_t)(1 | random_below(random, 256) << 1);
        for (int place = 0; place < count; place++) {
            if (random_below(random, density))
                continue;
            int32_t value = (int32_t)(random_u64(random) & ((1u << magnitude) - 1));
            value = random_below(random, 2) ? -value : value;
            if (value)
                n += cvol_term_pack(words + n, (uint32_t)place, value, bits);
        }
        assert_int_equal(cvol_array_adopt_pool(context, array, words, n), CVOL_OK);
        to->terms = words;
        to->words = n;
    }
    return array;
}

static void check_brick(cvol_context *context, const cvol_array *array, cvol_brick_coder *coder,
                        size_t brick, uint64_t seed)
{
    cvol_bytes subbands[CVOL_SUBBANDS] = {{0}};
    cvol_span spans[CVOL_SUBBANDS];
    cvol_array *decoded;
    cvol_brick_terms terms;
    assert_int_equal(cvol_array_create(context, &decoded, &array->grid, array->block), CVOL_OK);
    decoded->step = array->step;
    assert_true(cvol_brick_encode(coder, subbands, array, brick));
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        spans[s] = (cvol_span){subbands[s].data, subbands[s].size};
    for (int count = 1; count <= CVOL_SUBBANDS; count++) {
        assert_int_equal(cvol_brick_decode(coder, &terms, decoded, brick, spans, count), CVOL_OK);
        const cvol_brick_box box = cvol_brick_box_of(array, brick);
        const uint32_t *words = terms.words;
        for (size_t i = 0; i < cvol_brick_box_blocks(&box); i++) {
            const size_t index = cvol_brick_block_index(array, &box, i);
            const cvol_block *in = &array->block_table[index], *out = &decoded->block_table[index];
            assert_int_equal(in->split, out->split);
            const uint32_t *from = in->terms, *to = words;
            while (from < in->terms + in->words) {
                uint32_t place, place_out;
                const int bits = cvol_place_bits(array->block_log2);
                const int32_t value = cvol_term_unpack(&from, &place, bits);
                const uint32_t side = (uint32_t)array->block >> (CVOL_SUBBANDS - count);
                const uint32_t mask = (uint32_t)array->block - 1,
                               log2 = (uint32_t)array->block_log2;
                const int low = (place & mask) < side && (place >> log2 & mask) < side &&
                                place >> 2 * log2 < side;
                /* Split cells use their sub-blocks' own subbands; this checks whole cells. */
                if (in->split ? count < CVOL_SUBBANDS : !low && count < CVOL_SUBBANDS)
                    continue;
                if (to >= words + out->words || cvol_term_unpack(&to, &place_out, bits) != value ||
                    place_out != place)
                    fail_msg("seed %llu: brick %zu, block %zu, %d shells: another term",
                             (unsigned long long)seed, brick, i, count);
            }
            if (!in->split || count == CVOL_SUBBANDS)
                assert_ptr_equal(to, words + out->words);
            words += out->words;
        }
    }
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        cvol_bytes_free(&subbands[s]);
    cvol_array_free(decoded);
}

static void test_bricks_round_trip(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_token_tables *tables = default_tables();
    cvol_brick_coder *coder = cvol_brick_coder_create(tables);
    assert_non_null(coder);
    for (uint64_t seed = 1; seed <= 24; seed++) {
        random_state random = (random_state){seed};
        const size_t dims[3] = {1 + random_below(&random, 100), 1 + random_below(&random, 70),
                                1 + random_below(&random, 70)};
        const int block = seed % 4 == 1 ? 8 : seed % 4 == 3 ? 32 : 16;
        cvol_array *array = random_array(context, &random, block, dims);
        for (size_t b = 0; b < cvol_brick_count(array); b++)
            check_brick(context, array, coder, b, seed);
        cvol_array_free(array);
    }
    cvol_brick_coder_free(coder);
    free(tables);
    cvol_context_free(context);
}

static void test_damage_is_detected_or_harmless(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_token_tables *tables = default_tables();
    cvol_brick_coder *coder = cvol_brick_coder_create(tables);
    const size_t dims[3] = {50, 40, 30};
    int found = 0, all = 0;
    for (uint64_t seed = 1; seed <= 6; seed++) {
        random_state random = (random_state){seed};
        cvol_array *array = random_array(context, &random, 16, dims);
        cvol_bytes subbands[CVOL_SUBBANDS] = {{0}};
        assert_true(cvol_brick_encode(coder, subbands, array, 0));
        for (int i = 0; i < 200; i++, all++) {
            cvol_span spans[CVOL_SUBBANDS];
            cvol_brick_terms terms;
            const size_t s = random_below(&random, CVOL_SUBBANDS);
            for (int k = 0; k < CVOL_SUBBANDS; k++)
                spans[k] = (cvol_span){subbands[k].data, subbands[k].size};
            if (!subbands[s].size)
                continue;
            const size_t at = random_below(&random, (uint32_t)subbands[s].size);
            const uint8_t flip = (uint8_t)(1 + random_below(&random, 255));
            subbands[s].data[at] ^= flip;
            if (i % 2)
                spans[s].size = at;
            const int code = cvol_brick_decode(coder, &terms, array, 0, spans, CVOL_SUBBANDS);
            assert_true(code == CVOL_OK || code == CVOL_ERROR_CORRUPT);
            found += code != CVOL_OK;
            subbands[s].data[at] ^= flip;
        }
        for (int s = 0; s < CVOL_SUBBANDS; s++)
            cvol_bytes_free(&subbands[s]);
        cvol_array_free(array);
    }
    assert_true(found > all / 2); /* only checksums find all */
    cvol_brick_coder_free(coder);
    free(tables);
    cvol_context_free(context);
}

/* Garbage may decode to anything within bounds. */
static void test_garbage_decodes_within_bounds(void **state)
{
    (void)state;
    cvol_context *context = cvol_context_create();
    cvol_token_tables *tables = default_tables();
    cvol_brick_coder *coder = cvol_brick_coder_create(tables);
    random_state r = {42};
    uint8_t data[3000];
    for (int attempt = 0; attempt < 1500; attempt++) {
        const int block = attempt % 3 == 0 ? 8 : attempt % 3 == 1 ? 16 : 32;
        const cvol_grid grid = cvol_grid_make(40, 35, 33, CVOL_UINT8);
        cvol_array *array;
        cvol_brick_terms terms;
        cvol_span spans[CVOL_SUBBANDS];
        uint8_t *exact[CVOL_SUBBANDS]; /* the sanitizer detects a read beyond it */
        for (size_t i = 0; i < sizeof data; i++) {
            const uint64_t bits = random_u64(&r);
            data[i] = (uint8_t)(attempt & 1 ? bits : bits & random_u64(&r));
        }
        assert_int_equal(cvol_array_create(context, &array, &grid, block), CVOL_OK);
        for (int s = 0; s < CVOL_SUBBANDS; s++) {
            const size_t size = random_below(&r, sizeof data);
            exact[s] = malloc(size ? size : 1);
            assert_non_null(exact[s]);
            memcpy(exact[s], data, size);
            spans[s] = (cvol_span){exact[s], size};
        }
        const int code = cvol_brick_decode(coder, &terms, array, 0, spans, CVOL_SUBBANDS);
        assert_true(code == CVOL_OK || code == CVOL_ERROR_CORRUPT);
        for (int s = 0; s < CVOL_SUBBANDS; s++)
            free(exact[s]);
        cvol_array_free(array);
    }
    cvol_brick_coder_free(coder);
    free(tables);
    cvol_context_free(context);
}

static void test_scans_are_permutations(void **state)
{
    (void)state;
    for (int size_class = 0; size_class < CVOL_SUB_BLOCK_SIZES; size_class++) {
        const cvol_scan *scan = cvol_sub_block_scan_of(size_class);
        const int side = scan->side;
        for (int i = 0; i < scan->count; i++) {
            const int place = scan->entries[i].place;
            const int u = place % side, v = place / side % side, w = place / side / side;
            const int most = u > v ? (u > w ? u : w) : (v > w ? v : w);
            int cube = 1;
            while (cube <= most)
                cube *= 2;
            assert_int_equal(scan->index_of_place[place], i);
            assert_true(most == 0 ? i == 0 : i < cube * cube * cube && i >= cube * cube * cube / 8);
        }
        assert_int_equal(cvol_subband_end(size_class, CVOL_SUBBANDS - 1), scan->count);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rows_are_whole),
        cmocka_unit_test(test_tables_pass_through_their_section),
        cmocka_unit_test(test_fitted_tables_save_bits),
        cmocka_unit_test(test_streams_round_trip),
        cmocka_unit_test(test_bricks_round_trip),
        cmocka_unit_test(test_damage_is_detected_or_harmless),
        cmocka_unit_test(test_garbage_decodes_within_bounds),
        cmocka_unit_test(test_scans_are_permutations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
