/* Samples stored as text: decimal numbers between blanks, line ends or commas. */
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "volume/io/dense.h"
#include "volume/io/stored.h"
#include "volume/io/text.h"

typedef struct reading {
    cvol_context *context;
    const cvol_grid *grid;
    cvol_wide wide;
    const char *path;
} reading;

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

/* Stores an integer of 64 bits; 0 if it is none. */
static int store_wide(void *data, size_t i, cvol_wide wide, const char *word, size_t length)
{
    int64_t integer;
    const int fits = cvol_text_integer(word, length, &integer) &&
                     (wide == CVOL_WIDE_INT64 || integer >= 0);
    if (fits)
        ((int64_t *)data)[i] = integer;
    return fits;
}

/* Stores one value in its type; 0 if it is not a number of this type. */
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
        const int fits = r->wide ? store_wide(data, i, r->wide, word, length)
                                 : store_value(data, i, r->grid->type, word, length);
        if (!fits) {
            char shown[33] = "";
            for (size_t c = 0; c < length && c < sizeof shown - 1; c++)
                shown[c] = word[c] >= ' ' && word[c] <= '~' ? word[c] : '?';
            return cvol_fail(r->context, CVOL_ERROR_FORMAT, "%s: sample %zu is '%s', no %s",
                             r->path, i, shown,
                             r->wide == CVOL_WIDE_INT64    ? "int64"
                             : r->wide == CVOL_WIDE_UINT64 ? "uint64"
                                                           : cvol_type_name(r->grid->type));
        }
        if (i % (1 << 20) == 0) {
            int code = cvol_report_progress(r->context, "reading",
                                            (double)(i + 1) / (double)samples);
            if (code)
                return code;
        }
    }
    return CVOL_OK;
}

static int check_count(const reading *r, const char *text, size_t size, int may_go_on)
{
    size_t words = 0, at = 0, length, samples = cvol_grid_samples(r->grid);
    for (next_value(text, size, &at, &length); length; next_value(text, size, &at, &length))
        words++;
    if (words == samples || (may_go_on && words > samples))
        return CVOL_OK;
    return cvol_fail(r->context, CVOL_ERROR_FORMAT,
                     "%s: holds %zu of the %zu samples that its header announces", r->path, words,
                     samples);
}

int cvol_stored_read_text(cvol_context *context, cvol_volume **out, const cvol_grid *grid,
                          cvol_wide wide, const cvol_input *input, uint64_t offset, uint64_t stored,
                          int may_go_on)
{
    *out = NULL;
    reading r = {.context = context, .grid = grid, .wide = wide, .path = input->path};
    uint64_t size = offset < input->size ? input->size - offset : 0;
    if (stored && stored < size)
        size = stored;
    if (size > context->limit_bytes)
        return cvol_fail(context, CVOL_ERROR_LIMIT,
                         "%s: %llu bytes of text are more than the limit of %llu", r.path,
                         (unsigned long long)size, (unsigned long long)context->limit_bytes);
    char *text = cvol_allocate((size_t)size, 1);
    if (!text)
        return cvol_fail_memory(context, (size_t)size, r.path);
    size_t got;
    int code = cvol_input_read(context, input, offset, text, (size_t)size, &got);
    if (!code)
        code = check_count(&r, text, got, may_go_on);
    if (!code)
        code = cvol_dense_create(context, out, grid, 0);
    if (!code)
        code = parse_values(&r, text, got, (*out)->data);
    free(text);
    if (code) {
        cvol_volume_free(*out);
        *out = NULL;
    }
    return code;
}
