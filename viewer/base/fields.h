/* Strict reading of the fields of JSON objects: reports the first invalid field, and unknown
 * fields. */
#ifndef CVOL_VIEWER_BASE_FIELDS_H
#define CVOL_VIEWER_BASE_FIELDS_H

#include <jansson.h>
#include <stddef.h>

typedef struct fields {
    json_t *object;     /* taken fields are deleted from it */
    json_t *held;       /* the same object if take_object made it; fields_end frees it */
    const char *within; /* "view.camera." begins names in messages */
    char *error;        /* "": no error */
    size_t error_bytes;
} fields;

/* Parses a text, which must be a JSON object; the caller decrefs *object, which is NULL after an
 * error. */
void fields_parse(json_t **object, const char *text, size_t length, char *error,
                  size_t error_bytes);
/* These return 1 if the field is there; otherwise they do not change *out. */
int take_number(fields *f, const char *name, double *out, double least, double most);
int take_integer(fields *f, const char *name, int *out, int least, int most);
int take_bool(fields *f, const char *name, int *out);
/* A string of at most bytes - 1 bytes. */
int take_text(fields *f, const char *name, char *out, size_t bytes);
/* `count` finite numbers. */
int take_numbers(fields *f, const char *name, double *out, int count);
/* Any value, which the caller decrefs; NULL: not there. */
json_t *take_any(fields *f, const char *name);
/* The fields of an object; `within`: its name with a dot, for messages. The object of the result is
 * NULL if it is not there. End it with fields_end. */
fields take_object(fields *f, const char *name, const char *within);
/* Call it after the last field: remaining fields are an error. */
void fields_end(fields *f);
/* 1 if there was no error. */
int fields_ok(const fields *f);
/* Sets the error message, unless there is one. */
void fields_fail(fields *f, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
