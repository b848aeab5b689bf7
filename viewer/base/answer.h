/* The answer to a request. */
#ifndef CVOL_VIEWER_BASE_ANSWER_H
#define CVOL_VIEWER_BASE_ANSWER_H

#include <jansson.h>
#include <stddef.h>

#include "cvol/base.h"

#define ANSWER_HEADERS_MAX 3

typedef struct answer {
    int status;       /* of HTTP; 0: a job answers later */
    const char *type; /* of the content; static storage */
    void *bytes;      /* the content, freed with `release` (NULL: static storage) */
    size_t size;
    void (*release)(void *);
    int fd; /* above 0: the content is this file instead, which the answer closes */
    const char *header_names[ANSWER_HEADERS_MAX]; /* static storage */
    char *headers[ANSWER_HEADERS_MAX];            /* freed with free() */
    int header_count;
} answer;

/* {"error": message}. */
answer answer_error(int status, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* The message of a failure of the library, or of a function of the viewer, which reports no other
 * failure than a lack of memory, and that without a message. */
const char *answer_message(const cvol_context *context, int code);
/* The same as an answer: 400 if the request asks for something impossible, else 500. */
answer answer_failure(const cvol_context *context, int code);
/* With 15 digits of numbers. Frees the object; NULL: there was no memory for it. */
answer answer_json(int status, json_t *object);
/* The same with all digits of numbers, for values that must reproduce a picture. */
answer answer_exact_json(int status, json_t *object);
/* The answer owns the bytes. */
answer answer_bytes(const char *type, void *bytes, size_t size, void (*release)(void *));
/* Adds a header; copies the value. */
void answer_header(answer *a, const char *name, const char *value);
/* Adds a header with JSON in one line; frees the object. */
void answer_header_json(answer *a, const char *name, json_t *object);
/* The finite number, or null. */
json_t *answer_number(double value);
/* The text, or null for NULL; if it is not UTF-8, with '?' for bytes that are not ASCII. NULL: no
 * memory. */
json_t *answer_text(const char *text);
/* Frees the content and headers. */
void answer_free(answer *a);

#endif
