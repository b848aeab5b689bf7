/* Lines of text headers, strict numbers. */
#define _GNU_SOURCE
#include "volume/io/text.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/context.h"

/* ---- lines --------------------------------------------------------------------------- */

static int read_beginning(cvol_context *context, cvol_header *header, const cvol_input *input)
{
    size_t size = CVOL_HEADER_LIMIT_BYTES;
    header->whole = input->size <= size;
    if (header->whole)
        size = (size_t)input->size;
    header->data = malloc(size + 1);
    if (!header->data)
        return cvol_fail_memory(context, size, input->path);
    return cvol_input_read(context, input, 0, header->data, size, &header->size);
}

int cvol_header_open(cvol_context *context, cvol_header *header, const char *path)
{
    *header = (cvol_header){.path = path};
    cvol_input input;
    int code = cvol_input_open(context, &input, path);
    if (!code)
        code = read_beginning(context, header, &input);
    cvol_input_close(&input);
    return code;
}

void cvol_header_close(cvol_header *header)
{
    free(header->data);
    header->data = NULL;
}

int cvol_header_next(cvol_context *context, cvol_header *header, char **line)
{
    *line = NULL;
    if (header->at == header->size && header->whole)
        return CVOL_OK;
    char *start = header->data + header->at;
    size_t left = header->size - header->at;
    char *end = memchr(start, '\n', left);
    if (!end && !header->whole)
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: its header has no end within %zu bytes",
                         header->path, CVOL_HEADER_LIMIT_BYTES);
    header->line_number++;
    size_t length = end ? (size_t)(end - start) : left;
    header->at += length + (end != NULL);
    if (memchr(start, '\0', length))
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: line %zu of its header has a NUL byte",
                         header->path, header->line_number);
    if (length && start[length - 1] == '\r')
        length--;
    start[length] = '\0';
    for (size_t i = 0; i < length; i++)
        if (((unsigned char)start[i] < ' ' && start[i] != '\t') || start[i] == 0x7f)
            start[i] = '?';
    *line = start;
    return CVOL_OK;
}

/* ---- words --------------------------------------------------------------------------- */

static int is_blank(char c)
{
    return c == ' ' || c == '\t';
}

char *cvol_text_trim(char *text)
{
    while (is_blank(*text))
        text++;
    size_t length = strlen(text);
    while (length && is_blank(text[length - 1]))
        text[--length] = '\0';
    return text;
}

const char *cvol_text_word(const char **text, size_t *length)
{
    while (is_blank(**text))
        ++*text;
    const char *word = *text;
    while (**text && !is_blank(**text))
        ++*text;
    *length = (size_t)(*text - word);
    return *length ? word : NULL;
}

int cvol_text_equal(const char *a, const char *b)
{
    return !strcasecmp(a, b);
}

int cvol_text_ends(const char *text, const char *ending)
{
    size_t length = strlen(text), tail = strlen(ending);
    return length >= tail && cvol_text_equal(text + length - tail, ending);
}

int cvol_text_names_many_files(const char *value)
{
    size_t length;
    const char *rest = value, *word = cvol_text_word(&rest, &length);
    if (length == 4 && !strncmp(word, "LIST", 4))
        return 1;
    return memchr(word, '%', length) && cvol_text_word(&rest, &length);
}

/* ---- numbers ------------------------------------------------------------------------- */

/* No useful number is longer. */
#define NUMBER_BYTES 128

/* Copies a word with a NUL; 0 for texts that strtod and strtoll would accept: none, leading white
 * space, or too many digits. */
static int copy_number(char out[NUMBER_BYTES], const char *text, size_t length)
{
    if (length == 0 || length >= NUMBER_BYTES || (unsigned char)text[0] <= ' ')
        return 0;
    memcpy(out, text, length);
    out[length] = '\0';
    return 1;
}

int cvol_text_number(const char *text, size_t length, double *out)
{
    char copy[NUMBER_BYTES], *end;
    if (!copy_number(copy, text, length) || strpbrk(copy, "xX"))
        return 0;
    errno = 0;
    *out = strtod(copy, &end);
    int overflows = errno == ERANGE && isinf(*out);
    return end == copy + length && !overflows;
}

int cvol_text_integer(const char *text, size_t length, int64_t *out)
{
    char copy[NUMBER_BYTES], *end;
    if (!copy_number(copy, text, length))
        return 0;
    errno = 0;
    long long value = strtoll(copy, &end, 10);
    *out = value;
    return end == copy + length && errno == 0;
}

static int count_is(cvol_context *context, const char *path, const char *field, const char *text,
                    size_t count, const char *count_name)
{
    size_t words = 0, length;
    while (cvol_text_word(&text, &length))
        words++;
    if (words == count)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: %s has %zu values, %s is %zu", path, field,
                     words, count_name, count);
}

int cvol_text_numbers(cvol_context *context, const char *path, const char *field, const char *text,
                      double *out, size_t count, const char *count_name)
{
    int code = count_is(context, path, field, text, count, count_name);
    for (size_t i = 0; !code && i < count; i++) {
        size_t length;
        const char *word = cvol_text_word(&text, &length);
        if (!cvol_text_number(word, length, &out[i]))
            code = cvol_fail(context, CVOL_ERROR_FORMAT,
                             "%s: %s has the value '%.*s', not a number", path, field,
                             length < 80 ? (int)length : 80, word);
    }
    return code;
}

int cvol_text_sizes(cvol_context *context, const char *path, const char *field, const char *text,
                    size_t *out, size_t count, const char *count_name)
{
    int code = count_is(context, path, field, text, count, count_name);
    for (size_t i = 0; !code && i < count; i++) {
        size_t length;
        const char *word = cvol_text_word(&text, &length);
        int64_t value = 0;
        if (!cvol_text_integer(word, length, &value) || value <= 0)
            code = cvol_fail(context, CVOL_ERROR_FORMAT,
                             "%s: %s has the value '%.*s', not a positive integer", path, field,
                             length < 80 ? (int)length : 80, word);
        else
            code = cvol_check_size(context, path, field, (uint64_t)value);
        out[i] = code ? 0 : (size_t)value;
    }
    return code;
}

int cvol_text_field_integer(cvol_context *context, const char *path, const char *field,
                            const char *text, int64_t min, int64_t max, int64_t *out)
{
    if (!cvol_text_integer(text, strlen(text), out))
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: %s is '%.80s', not an integer", path,
                         field, text);
    if (*out < min || *out > max)
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: %s is %lld, must be %lld to %lld", path,
                         field, (long long)*out, (long long)min, (long long)max);
    return CVOL_OK;
}

void cvol_text_format(char out[CVOL_TEXT_NUMBER_BYTES], double value)
{
    char text[CVOL_TEXT_NUMBER_BYTES] = "";
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    memcpy(out, text, sizeof text);
}

void cvol_text_put_number(cvol_bytes *bytes, const char *before, double value)
{
    char number[CVOL_TEXT_NUMBER_BYTES];
    cvol_text_format(number, value);
    cvol_bytes_put_text(bytes, before);
    cvol_bytes_put_text(bytes, number);
}
