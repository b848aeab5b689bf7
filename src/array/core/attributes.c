/* Attributes: a JSON text (RFC 8259) of the volume, stored byte for byte. */
#include <stdlib.h>
#include <string.h>

#include "array/core/array.h"
#include "base/context.h"
#include "base/json_text.h"

/* Length of the UTF-8 sequence at p, with `left` bytes available; 0 if invalid (Unicode, table
 * 3-7). */
static size_t sequence_length(const unsigned char *p, size_t left)
{
    if (p[0] < 0x80)
        return 1;
    const size_t length = p[0] >= 0xF0 ? 4 : p[0] >= 0xE0 ? 3 : 2;
    if (p[0] < 0xC2 || p[0] > 0xF4 || length > left)
        return 0;
    for (size_t i = 1; i < length; i++)
        if ((p[i] & 0xC0) != 0x80)
            return 0;
    if ((p[0] == 0xE0 && p[1] < 0xA0) || (p[0] == 0xED && p[1] > 0x9F) ||
        (p[0] == 0xF0 && p[1] < 0x90) || (p[0] == 0xF4 && p[1] > 0x8F))
        return 0;
    return length;
}

int cvol_attributes_are_text(const char *text, size_t size)
{
    const unsigned char *p = (const unsigned char *)text;
    for (size_t at = 0; at < size;) {
        const size_t length = p[at] ? sequence_length(p + at, size - at) : 0;
        if (!length)
            return 0;
        at += length;
    }
    return 1;
}

int cvol_array_keep_attributes(cvol_context *context, cvol_array *array, const char *text,
                               size_t size)
{
    char *copy = malloc(size + 1);
    if (!copy)
        return cvol_fail_memory(context, size + 1, "the attributes");
    if (size)
        memcpy(copy, text, size);
    copy[size] = '\0';
    free(array->attributes);
    array->attributes = copy;
    return CVOL_OK;
}

int cvol_array_set_attributes(cvol_context *context, cvol_array *array, const char *json)
{
    if (!json) {
        free(array->attributes);
        array->attributes = NULL;
        return CVOL_OK;
    }
    const size_t size = strlen(json);
    json_error_t error;
    if (size > CVOL_ATTRIBUTES_MAX)
        return cvol_fail(context, CVOL_ERROR_LIMIT, "attributes have %zu bytes, may have %d", size,
                         (int)CVOL_ATTRIBUTES_MAX);
    json_t *value;
    const int code = cvol_json_load(context, &value, json, size, JSON_DECODE_ANY | JSON_ALLOW_NUL,
                                    &error, "the attributes");
    if (code == CVOL_ERROR_MEMORY)
        return code;
    if (code)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "attributes are not JSON text: line %d, column %d: %s", error.line,
                         error.column, error.text);
    json_decref(value);
    return cvol_array_keep_attributes(context, array, json, size);
}

const char *cvol_array_attributes(const cvol_array *array)
{
    return array->attributes;
}
