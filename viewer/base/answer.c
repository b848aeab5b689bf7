/* The answer to a request. */
#include "viewer/base/answer.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char no_memory[] = "{\"error\": \"not enough memory for the answer\"}";

static answer no_answer(void)
{
    union {
        const char *text;
        void *bytes;
    } content = {.text = no_memory};
    return (answer){
        500, "application/json", content.bytes, sizeof no_memory - 1, NULL, 0, {NULL}, {NULL}, 0};
}

/* Frees the object. */
static answer answer_digits(int status, json_t *object, size_t digits)
{
    char *text = object ? json_dumps(object, JSON_COMPACT | JSON_REAL_PRECISION(digits)) : NULL;
    json_decref(object);
    if (!text)
        return no_answer();
    answer a = answer_bytes("application/json", text, strlen(text), free);
    a.status = status;
    return a;
}

answer answer_json(int status, json_t *object)
{
    return answer_digits(status, object, 15);
}

answer answer_exact_json(int status, json_t *object)
{
    return answer_digits(status, object, 17);
}

answer answer_error(int status, const char *format, ...)
{
    char message[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    return answer_json(status, json_pack("{s:o}", "error", answer_text(message)));
}

const char *answer_message(const cvol_context *context, int code)
{
    const char *message = cvol_context_message(context);
    return code == CVOL_ERROR_MEMORY && !strstr(message, "memory") ? "not enough memory" : message;
}

answer answer_failure(const cvol_context *context, int code)
{
    const int theirs = code == CVOL_ERROR_ARGUMENT || code == CVOL_ERROR_TARGET ||
                       code == CVOL_ERROR_UNSUPPORTED || code == CVOL_ERROR_FORMAT;
    return answer_error(theirs ? 400 : 500, "%s", answer_message(context, code));
}

answer answer_bytes(const char *type, void *bytes, size_t size, void (*release)(void *))
{
    return (answer){200, type, bytes, size, release, 0, {NULL}, {NULL}, 0};
}

void answer_header(answer *a, const char *name, const char *value)
{
    char *copy = a->header_count < ANSWER_HEADERS_MAX ? strdup(value) : NULL;
    if (!copy)
        return;
    a->header_names[a->header_count] = name;
    a->headers[a->header_count++] = copy;
}

void answer_header_json(answer *a, const char *name, json_t *object)
{
    char *text = object
                     ? json_dumps(object, JSON_COMPACT | JSON_REAL_PRECISION(6) | JSON_ENSURE_ASCII)
                     : NULL;
    json_decref(object);
    if (text)
        answer_header(a, name, text);
    free(text);
}

json_t *answer_number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

json_t *answer_text(const char *text)
{
    json_t *string = text ? json_string(text) : json_null();
    if (string)
        return string;
    /* Names and units of files, and messages that are cut inside a character. */
    char *ascii = strdup(text);
    for (char *c = ascii; c && *c; c++)
        if ((unsigned char)*c > '~')
            *c = '?';
    string = ascii ? json_string(ascii) : NULL;
    free(ascii);
    return string;
}

void answer_free(answer *a)
{
    if (a->release)
        a->release(a->bytes);
    if (a->fd > 0)
        close(a->fd);
    for (int i = 0; i < a->header_count; i++)
        free(a->headers[i]);
    *a = (answer){0};
}
