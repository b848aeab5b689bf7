/* JSON texts. Jansson reports a lack of memory as an error of the text, and its message does not
 * always tell the two apart. */
#ifndef CVOL_BASE_JSON_TEXT_H
#define CVOL_BASE_JSON_TEXT_H

#include <jansson.h>

#include "cvol/base.h"

/* json_loadb: CVOL_OK and *out; FORMAT: an error of the text, with *error; MEMORY, with a message
 * on the context that names `what`. */
int cvol_json_load(cvol_context *context, json_t **out, const char *text, size_t size, size_t flags,
                   json_error_t *error, const char *what);

#endif
