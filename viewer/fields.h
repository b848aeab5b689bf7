/* Fields of JSON objects, taken one by one and strictly: of the first that is wrong there is a
 * sentence, and so there is of those that nobody asked for. */
#ifndef CVOL_VIEWER_FIELDS_H
#define CVOL_VIEWER_FIELDS_H

#include <jansson.h>
#include <stddef.h>

typedef struct fields {
    json_t *object;     /* taken fields are deleted from it */
    json_t *held;       /* the same, where it was taken from another; fields_end frees it */
    const char *within; /* "view.camera." begins the names in sentences */
    char *error;        /* "" while all is well */
    size_t error_bytes;
} fields;

/* Of text, which must be a JSON object; the caller decrefs *object, which is NULL after an error.
 */
void fields_parse(json_t **object, const char *text, size_t length, char *error,
                  size_t error_bytes);
/* A field that is left out leaves *out as it is; the functions tell whether it was there. */
int take_number(fields *f, const char *name, double *out, double least, double most);
int take_integer(fields *f, const char *name, int *out, int least, int most);
int take_bool(fields *f, const char *name, int *out);
/* Of a text of at most bytes - 1 bytes. */
int take_text(fields *f, const char *name, char *out, size_t bytes);
/* `count` finite numbers. */
int take_numbers(fields *f, const char *name, double *out, int count);
/* Any value, which the caller decrefs; NULL: it was not there. */
json_t *take_any(fields *f, const char *name);
/* An object: its fields, with `within` for its name and the dot (the result's object is NULL if it
 * was not there); to be ended by fields_end. */
fields take_object(fields *f, const char *name, const char *within);
/* After the last: what is left is an error. */
void fields_end(fields *f);
/* Whether all was well so far. */
int fields_ok(const fields *f);
/* Says what is wrong, unless something was before. */
void fields_fail(fields *f, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
