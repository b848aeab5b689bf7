/* Strict reading of the fields of JSON objects. */
#include "viewer/base/fields.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void fields_parse(json_t **object, const char *text, size_t length, char *error, size_t error_bytes)
{
    json_error_t e;
    *object = json_loadb(text ? text : "", text ? length : 0, JSON_REJECT_DUPLICATES, &e);
    if (!*object)
        snprintf(error, error_bytes, "the body is not JSON: line %d, column %d: %.100s", e.line,
                 e.column, e.text);
    else if (!json_is_object(*object)) {
        snprintf(error, error_bytes, "the body must be a JSON object");
        json_decref(*object);
        *object = NULL;
    }
}

void fields_fail(fields *f, const char *format, ...)
{
    if (f->error[0])
        return;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(f->error, f->error_bytes, format, arguments);
    va_end(arguments);
}

int fields_ok(const fields *f)
{
    return !f->error[0];
}

json_t *take_any(fields *f, const char *name)
{
    json_t *value = f->object ? json_object_get(f->object, name) : NULL;
    json_incref(value);
    if (value)
        json_object_del(f->object, name);
    return value;
}

int take_number(fields *f, const char *name, double *out, double least, double most)
{
    json_t *value = take_any(f, name);
    if (!value)
        return 0;
    const double number = json_number_value(value);
    if (!json_is_number(value))
        fields_fail(f, "%s%s must be a number", f->within, name);
    else if (!(number >= least && number <= most))
        fields_fail(f, "%s%s is %g, must be %g to %g", f->within, name, number, least, most);
    else
        *out = number;
    json_decref(value);
    return 1;
}

int take_integer(fields *f, const char *name, int *out, int least, int most)
{
    double number = least;
    if (!take_number(f, name, &number, least, most))
        return 0;
    if (number != floor(number))
        fields_fail(f, "%s%s is %g, must be a whole number", f->within, name, number);
    *out = (int)number;
    return 1;
}

int take_bool(fields *f, const char *name, int *out)
{
    json_t *value = take_any(f, name);
    if (!value)
        return 0;
    if (!json_is_boolean(value))
        fields_fail(f, "%s%s must be true or false", f->within, name);
    *out = json_is_true(value);
    json_decref(value);
    return 1;
}

int take_text(fields *f, const char *name, char *out, size_t bytes)
{
    json_t *value = take_any(f, name);
    if (!value)
        return 0;
    if (!json_is_string(value))
        fields_fail(f, "%s%s must be a string", f->within, name);
    else if (json_string_length(value) >= bytes)
        fields_fail(f, "%s%s has %zu bytes, must have at most %zu", f->within, name,
                    json_string_length(value), bytes - 1);
    else if (strlen(json_string_value(value)) != json_string_length(value))
        fields_fail(f, "%s%s has a zero byte", f->within, name);
    else
        snprintf(out, bytes, "%s", json_string_value(value));
    json_decref(value);
    return 1;
}

int take_numbers(fields *f, const char *name, double *out, int count)
{
    json_t *value = take_any(f, name);
    if (!value)
        return 0;
    int good = json_is_array(value) && json_array_size(value) == (size_t)count;
    for (int i = 0; good && i < count; i++) {
        const json_t *number = json_array_get(value, (size_t)i);
        good = json_is_number(number) && isfinite(json_number_value(number));
        if (good)
            out[i] = json_number_value(number);
    }
    if (!good)
        fields_fail(f, "%s%s must be %d numbers", f->within, name, count);
    json_decref(value);
    return 1;
}

fields take_object(fields *f, const char *name, const char *within)
{
    json_t *value = take_any(f, name);
    if (value && !json_is_object(value)) {
        fields_fail(f, "%s%s must be an object", f->within, name);
        json_decref(value);
        value = NULL;
    }
    return (fields){value, value, within, f->error, f->error_bytes};
}

void fields_end(fields *f)
{
    void *first = f->object ? json_object_iter(f->object) : NULL;
    if (first)
        fields_fail(f, "unknown field %s%.60s", f->within, json_object_iter_key(first));
    json_decref(f->held);
    f->object = f->held = NULL;
}
