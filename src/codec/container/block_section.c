/* Section TERM: a frame of each block's number of terms, their places and their values.
 *
 * A place is coded as its distance to the previous place in the block, minus one; a value v as 2
 * |v| - 1 if it is negative, else 2 v. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/container/terms.h"
#include "codec/quantize/quantize.h"

/* All numbers of the section. */
typedef struct term_lists {
    uint32_t *counts, *places, *values; /* counts: terms of each block */
    size_t blocks, terms;
} term_lists;

static void lists_free(term_lists *lists)
{
    free(lists->counts);
    free(lists->places);
    free(lists->values);
}

static int lists_make(cvol_context *context, term_lists *lists, size_t blocks, size_t terms)
{
    *lists = (term_lists){cvol_allocate(blocks, 4), cvol_allocate(terms, 4),
                          cvol_allocate(terms, 4), blocks, terms};
    if (lists->counts && lists->places && lists->values)
        return CVOL_OK;
    lists_free(lists);
    return cvol_fail_memory(context, 4 * (blocks + 2 * terms), "the file's terms");
}

static uint32_t fold(int32_t value)
{
    return value < 0 ? 2 * (0 - (uint32_t)value) - 1 : 2 * (uint32_t)value;
}

static int32_t unfold(uint32_t number)
{
    return number & 1 ? -(int32_t)(number / 2) - 1 : (int32_t)(number / 2);
}

/* ---- writing ---------------------------------------------------------------------------- */

int cvol_terms_check(cvol_context *context, const cvol_array *array)
{
    for (size_t b = 0; b < array->block_count; b++) {
        const uint32_t *words = array->block_table[b].terms;
        const uint32_t *end = cvol_block_end(&array->block_table[b]);
        double sum = 0, largest = 0;
        while (words < end) {
            uint32_t place;
            const double size = fabs(
                (double)cvol_term_unpack(&words, &place, cvol_place_bits(array->block_log2)));
            sum += size;
            largest = fmax(largest, size);
        }
        if (!(sum * array->step < (double)FLT_MAX) || largest > (double)CVOL_VALUE_LIMIT)
            return cvol_fail(context, CVOL_ERROR_DATA,
                             "the terms of block %zu are too large for a file: scale the array "
                             "down, or keep it with a larger step",
                             b);
    }
    return CVOL_OK;
}

static void fill_lists(term_lists *lists, const cvol_array *array)
{
    size_t t = 0;
    for (size_t b = 0; b < lists->blocks; b++) {
        const uint32_t *words = array->block_table[b].terms;
        const uint32_t *end = cvol_block_end(&array->block_table[b]);
        const size_t first = t;
        uint32_t next = 0;
        for (; words < end; t++) {
            uint32_t place;
            int32_t value = cvol_term_unpack(&words, &place, cvol_place_bits(array->block_log2));
            lists->places[t] = place - next;
            lists->values[t] = fold(value);
            next = place + 1;
        }
        lists->counts[b] = (uint32_t)(t - first);
    }
}

int cvol_terms_put(cvol_context *context, cvol_bytes *out, const cvol_array *array)
{
    term_lists lists;
    cvol_bytes raw = {0};
    int code = lists_make(context, &lists, array->block_count, (size_t)array->coefficients);
    if (code)
        return code;
    fill_lists(&lists, array);
    cvol_planes_put(&raw, lists.counts, lists.blocks, 4);
    cvol_planes_put(&raw, lists.places, lists.terms, 2);
    cvol_planes_put(&raw, lists.values, lists.terms, 4);
    lists_free(&lists);
    code = cvol_packed_put(context, out, &raw);
    cvol_bytes_free(&raw);
    return code;
}

/* ---- reading ---------------------------------------------------------------------------- */

static uint64_t raw_size(uint64_t blocks, uint64_t terms)
{
    return 4 * blocks + 6 * terms;
}

int cvol_terms_check_length(cvol_context *context, const cvol_header *header,
                            const cvol_cursor *content, const char *name)
{
    uint64_t blocks = 1, per_block = 1;
    for (uint32_t a = 0; a < header->rank; a++) {
        blocks *= (header->grid.dims[a] - 1) / header->block + 1; /* at most the number of
                                                                     samples */
        per_block *= header->block;
    }
    if (blocks > UINT64_MAX / 16 / per_block ||
        raw_size(blocks, 0) / CVOL_PACKED_EXPANSION > content->size)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: %llu blocks are more than a file of this size can hold", name,
                         (unsigned long long)blocks);
    if (header->coefficients > blocks * per_block)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section HEAD: %llu coefficients in %llu blocks", name,
                         (unsigned long long)header->coefficients, (unsigned long long)blocks);
    return CVOL_OK;
}

/* The number of words for the values: two for an escaped value. */
static size_t count_words(const term_lists *lists, int place_bits)
{
    const int32_t escape = cvol_term_escape(place_bits);
    size_t words = lists->terms;
    for (size_t t = 0; t < lists->terms; t++) {
        const int32_t value = unfold(lists->values[t]);
        words += value <= escape || value >= -escape;
    }
    return words;
}

/* Converts the lists to blocks' words. Returns an error text, or NULL. */
static const char *pack(cvol_array *array, uint32_t *words, const term_lists *lists)
{
    const size_t per_block = cvol_array_block_terms(array);
    uint32_t *to = words;
    size_t t = 0;
    for (size_t b = 0; b < lists->blocks; b++) {
        cvol_block *block = &array->block_table[b];
        uint64_t next = 0;
        double sum = 0;
        block->terms = to;
        if (lists->counts[b] > lists->terms - t)
            return "blocks have more terms than there are";
        for (const size_t end = t + lists->counts[b]; t < end; t++) {
            const uint64_t place = next + lists->places[t];
            const int32_t value = unfold(lists->values[t]);
            if (place >= per_block)
                return "a place is beyond its block";
            if (value == 0 || value > CVOL_VALUE_LIMIT || value < -CVOL_VALUE_LIMIT)
                return "a value is 0, or beyond 2^30";
            to += cvol_term_pack(to, (uint32_t)place, value, cvol_place_bits(array->block_log2));
            next = place + 1;
            sum += fabs((double)value);
        }
        if (!(sum * array->step < (double)FLT_MAX))
            return "terms are too large for float32";
        block->words = (uint32_t)(to - block->terms);
        cvol_block_find_low(block, array->block_log2);
    }
    return t == lists->terms ? NULL : "blocks have fewer terms than there are";
}

static int adopt(cvol_context *context, cvol_array *array, const term_lists *lists,
                 const char *name)
{
    const size_t count = count_words(lists, cvol_place_bits(array->block_log2));
    uint32_t *words = malloc(count ? count * sizeof *words : 1);
    if (!words)
        return cvol_fail_memory(context, count * sizeof *words, "the coefficients");
    const char *wrong = pack(array, words, lists);
    if (wrong) {
        free(words);
        return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: section TERM: %s", name, wrong);
    }
    int code = cvol_array_adopt_pool(context, array, words, count);
    if (code)
        free(words);
    else
        array->coefficients = lists->terms;
    return code;
}

int cvol_terms_take(cvol_context *context, cvol_array *array, const cvol_header *header,
                    cvol_cursor *content, const char *name)
{
    const uint64_t size = raw_size(array->block_count, header->coefficients);
    term_lists lists;
    uint8_t *raw;
    int code = cvol_packed_take(context, &raw, size, content, "TERM", name);
    if (code)
        return code;
    code = lists_make(context, &lists, array->block_count, (size_t)header->coefficients);
    if (!code) {
        cvol_cursor cursor = cvol_cursor_make(raw, (size_t)size);
        cvol_planes_take(lists.counts, lists.blocks, 4, &cursor);
        cvol_planes_take(lists.places, lists.terms, 2, &cursor);
        cvol_planes_take(lists.values, lists.terms, 4, &cursor);
        code = adopt(context, array, &lists, name);
        lists_free(&lists);
    }
    free(raw);
    return code;
}
