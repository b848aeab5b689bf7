/* Reading stored samples: raw, deflated, text. */
#include "volume/stored.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "volume/dense.h"
#include "volume/inflate.h"
#include "volume/input.h"
#include "volume/text.h"

/* Between two reports of progress. */
#define STEP_BYTES ((size_t)8 << 20)

/* What the three encodings share while one file is read. */
typedef struct reading {
    cvol_context *context;
    const cvol_grid *grid;
    const cvol_stored *stored;
    cvol_input input;
    uint64_t offset; /* behind skipped lines */
    size_t bytes;    /* of all samples */
} reading;

static int fail_short(const reading *r, uint64_t got)
{
    return cvol_fail(r->context, CVOL_ERROR_FORMAT,
                     "%s: holds %llu of the %zu bytes of samples that its header announces",
                     r->stored->path, (unsigned long long)got, r->bytes);
}

static int fail_long(const reading *r, const char *by)
{
    return cvol_fail(r->context, CVOL_ERROR_FORMAT,
                     "%s: holds %s more than the %zu bytes of samples that its header announces",
                     r->stored->path, by, r->bytes);
}

static int report(const reading *r, size_t done)
{
    return cvol_report_progress(r->context, "reading", (double)done / (double)r->bytes);
}

/* ---- byte order ---------------------------------------------------------------------- */

int cvol_machine_is_big_endian(void)
{
    const uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 0;
}

void cvol_swap_bytes(void *data, size_t count, size_t size)
{
    uint8_t *bytes = data;
    for (size_t i = 0; i < count && size == 2; i++) {
        uint16_t v;
        memcpy(&v, bytes + 2 * i, 2);
        v = __builtin_bswap16(v);
        memcpy(bytes + 2 * i, &v, 2);
    }
    for (size_t i = 0; i < count && size == 4; i++) {
        uint32_t v;
        memcpy(&v, bytes + 4 * i, 4);
        v = __builtin_bswap32(v);
        memcpy(bytes + 4 * i, &v, 4);
    }
    for (size_t i = 0; i < count && size == 8; i++) {
        uint64_t v;
        memcpy(&v, bytes + 8 * i, 8);
        v = __builtin_bswap64(v);
        memcpy(bytes + 8 * i, &v, 8);
    }
}

/* ---- raw ----------------------------------------------------------------------------- */

static int find_raw(const reading *r, uint64_t *offset)
{
    uint64_t size = r->input.size, skip = r->stored->byte_skip;
    uint64_t available = size > r->offset ? size - r->offset : 0;
    available = available > skip ? available - skip : 0;
    if (available < r->bytes)
        return fail_short(r, available);
    *offset = r->stored->at_end ? size - r->bytes : r->offset + skip;
    if (available > r->bytes && !r->stored->at_end && !r->stored->may_go_on) {
        char more[32];
        snprintf(more, sizeof more, "%llu bytes", (unsigned long long)(available - r->bytes));
        return fail_long(r, more);
    }
    return CVOL_OK;
}

static int read_raw(reading *r, cvol_volume **out)
{
    uint64_t offset = 0;
    int code = find_raw(r, &offset);
    if (!code)
        code = cvol_dense_create(r->context, out, r->grid, 0);
    for (size_t done = 0; !code && done < r->bytes;) {
        size_t step = r->bytes - done < STEP_BYTES ? r->bytes - done : STEP_BYTES, got;
        code = cvol_input_read(r->context, &r->input, offset + done, (uint8_t *)(*out)->data + done,
                               step, &got);
        if (!code && got < step)
            code = fail_short(r, done + got);
        done += step;
        if (!code)
            code = report(r, done);
    }
    return code;
}

/* ---- deflated ------------------------------------------------------------------------ */

static int check_claim(const reading *r, uint64_t stored)
{
    uint64_t claimed = r->bytes, skip = r->stored->byte_skip, most;
    if (__builtin_mul_overflow(stored, (uint64_t)CVOL_INFLATE_FACTOR, &most) ||
        __builtin_add_overflow(most, (uint64_t)CVOL_INFLATE_SLACK, &most))
        most = UINT64_MAX;
    if (!__builtin_add_overflow(claimed, skip, &claimed) && claimed <= most)
        return CVOL_OK;
    return cvol_fail(r->context, CVOL_ERROR_FORMAT,
                     "%s: %llu compressed bytes cannot hold the %zu bytes of samples that its "
                     "header announces",
                     r->stored->path, (unsigned long long)stored, r->bytes);
}

/* The stream must end where the samples do, and its check sum must hold. */
static int check_stream_end(const reading *r, cvol_inflater *inflater)
{
    uint8_t more;
    uint64_t got;
    int code = cvol_inflater_read(r->context, inflater, &more, 1, &got);
    if (code)
        return code;
    if (got)
        return fail_long(r, "compressed");
    if (!cvol_inflater_ended(inflater))
        return cvol_fail(r->context, CVOL_ERROR_FORMAT,
                         "%s: is cut off within the check sum of its compressed samples",
                         r->stored->path);
    return CVOL_OK;
}

static int inflate_samples(const reading *r, cvol_inflater *inflater, uint8_t *data)
{
    uint64_t got;
    int code = cvol_inflater_read(r->context, inflater, NULL, r->stored->byte_skip, &got);
    if (!code && got < r->stored->byte_skip)
        code = fail_short(r, 0);
    for (size_t done = 0; !code && done < r->bytes;) {
        size_t step = r->bytes - done < STEP_BYTES ? r->bytes - done : STEP_BYTES;
        code = cvol_inflater_read(r->context, inflater, data + done, step, &got);
        if (!code && got < step)
            code = fail_short(r, done + got);
        done += step;
        if (!code)
            code = report(r, done);
    }
    return code ? code : check_stream_end(r, inflater);
}

static int read_deflated(reading *r, cvol_volume **out)
{
    uint64_t size = r->input.size > r->offset ? r->input.size - r->offset : 0;
    if (r->stored->stored_size > size)
        return cvol_fail(r->context, CVOL_ERROR_FORMAT,
                         "%s: holds %llu of the %llu compressed bytes that its header announces",
                         r->stored->path, (unsigned long long)size,
                         (unsigned long long)r->stored->stored_size);
    if (r->stored->stored_size)
        size = r->stored->stored_size;
    int code = check_claim(r, size);
    cvol_inflater *inflater = NULL;
    if (!code)
        code = cvol_inflater_open(r->context, &inflater, &r->input, r->offset, size);
    if (!code)
        code = cvol_dense_create(r->context, out, r->grid, 0);
    if (!code)
        code = inflate_samples(r, inflater, (*out)->data);
    cvol_inflater_close(inflater);
    return code;
}

/* ---- text ---------------------------------------------------------------------------- */

static int is_separator(char c)
{
    return c == ' ' || c == ',' || (c >= '\t' && c <= '\r');
}

/* The next word of text[*at .. size), its length 0 at the end. */
static const char *next_value(const char *text, size_t size, size_t *at, size_t *length)
{
    while (*at < size && is_separator(text[*at]))
        ++*at;
    const char *word = text + *at;
    while (*at < size && !is_separator(text[*at]))
        ++*at;
    *length = (size_t)(text + *at - word);
    return word;
}

/* Stores one value in its type; 0 if it is no number or none of this type. */
static int store_value(void *data, size_t i, cvol_type type, const char *word, size_t length)
{
    int64_t integer = 0;
    double real = 0;
    int fits = cvol_type_is_integer(type) ? cvol_text_integer(word, length, &integer)
                                          : cvol_text_number(word, length, &real);
    switch (type) {
#define STORE(constant, ctype, low, high)                     \
    case constant:                                            \
        fits = fits && integer >= (low) && integer <= (high); \
        ((ctype *)data)[i] = (ctype)integer;                  \
        break
        STORE(CVOL_UINT8, uint8_t, 0, UINT8_MAX);
        STORE(CVOL_INT8, int8_t, INT8_MIN, INT8_MAX);
        STORE(CVOL_UINT16, uint16_t, 0, UINT16_MAX);
        STORE(CVOL_INT16, int16_t, INT16_MIN, INT16_MAX);
        STORE(CVOL_UINT32, uint32_t, 0, (int64_t)UINT32_MAX);
        STORE(CVOL_INT32, int32_t, INT32_MIN, INT32_MAX);
#undef STORE
    case CVOL_FLOAT32:
        ((float *)data)[i] = (float)real;
        break;
    case CVOL_FLOAT64:
        ((double *)data)[i] = real;
        break;
    }
    return fits;
}

static int parse_values(const reading *r, const char *text, size_t size, void *data)
{
    size_t samples = cvol_grid_samples(r->grid), at = 0, length;
    for (size_t i = 0; i < samples; i++) {
        const char *word = next_value(text, size, &at, &length);
        if (!store_value(data, i, r->grid->type, word, length)) {
            char shown[33] = "";
            for (size_t c = 0; c < length && c < sizeof shown - 1; c++)
                shown[c] = word[c] >= ' ' && word[c] <= '~' ? word[c] : '?';
            return cvol_fail(r->context, CVOL_ERROR_FORMAT, "%s: sample %zu is '%s', no %s",
                             r->stored->path, i, shown, cvol_type_name(r->grid->type));
        }
        if (i % (1 << 20) == 0) {
            int code = report(r, i * cvol_type_size(r->grid->type));
            if (code)
                return code;
        }
    }
    return CVOL_OK;
}

static int check_count(const reading *r, const char *text, size_t size)
{
    size_t words = 0, at = 0, length, samples = cvol_grid_samples(r->grid);
    for (next_value(text, size, &at, &length); length; next_value(text, size, &at, &length))
        words++;
    if (words == samples)
        return CVOL_OK;
    return cvol_fail(r->context, CVOL_ERROR_FORMAT,
                     "%s: holds %zu of the %zu samples that its header announces", r->stored->path,
                     words, samples);
}

static int read_text(reading *r, cvol_volume **out)
{
    uint64_t start = r->offset, size = 0;
    if (!__builtin_add_overflow(start, r->stored->byte_skip, &start) && start < r->input.size)
        size = r->input.size - start;
    if (size > r->context->limit_bytes)
        return cvol_fail(r->context, CVOL_ERROR_LIMIT,
                         "%s: %llu bytes of text are more than the limit of %llu", r->stored->path,
                         (unsigned long long)size, (unsigned long long)r->context->limit_bytes);
    char *text = cvol_allocate((size_t)size, 1);
    if (!text)
        return cvol_fail_memory(r->context, (size_t)size, r->stored->path);
    size_t got;
    int code = cvol_input_read(r->context, &r->input, start, text, (size_t)size, &got);
    if (!code)
        code = check_count(r, text, got);
    if (!code)
        code = cvol_dense_create(r->context, out, r->grid, 0);
    if (!code)
        code = parse_values(r, text, got, (*out)->data);
    free(text);
    return code;
}

/* ---- all three ----------------------------------------------------------------------- */

int cvol_stored_read(cvol_context *context, cvol_volume **out, const cvol_grid *grid,
                     const char *name, const cvol_stored *stored)
{
    *out = NULL;
    int code = cvol_grid_check(context, grid, name);
    if (code)
        return code;
    reading r = {.context = context, .grid = grid, .stored = stored, .offset = stored->offset};
    r.bytes = cvol_grid_bytes(grid);
    code = cvol_input_open(context, &r.input, stored->path);
    if (code && strcmp(name, stored->path)) { /* a missing file: say who wanted it */
        char reason[CVOL_MESSAGE_BYTES];
        snprintf(reason, sizeof reason, "%s", cvol_context_message(context));
        cvol_fail(context, code, "%s: its data file %s", name, reason);
    }
    if (!code)
        code = cvol_input_skip_lines(context, &r.input, &r.offset, stored->line_skip);
    if (!code && stored->encoding == CVOL_ENCODING_RAW)
        code = read_raw(&r, out);
    else if (!code && stored->encoding == CVOL_ENCODING_TEXT)
        code = read_text(&r, out);
    else if (!code)
        code = read_deflated(&r, out);
    cvol_input_close(&r.input);
    if (!code && stored->encoding != CVOL_ENCODING_TEXT &&
        stored->big_endian != cvol_machine_is_big_endian())
        cvol_swap_bytes((*out)->data, cvol_grid_samples(grid), cvol_type_size(grid->type));
    if (code) {
        cvol_volume_free(*out);
        *out = NULL;
    }
    return code;
}
