/* JSON texts (json_text.h). */
#include "base/json_text.h"

#include <stdlib.h>

#include "base/context.h"

/* The memory of a parse, for a text of this size: more than the parse of most texts needs. */
static size_t parse_bytes(size_t size)
{
    return 4096 + 16 * size;
}

int cvol_json_load(cvol_context *context, json_t **out, const char *text, size_t size, size_t flags,
                   json_error_t *error, const char *what)
{
    *out = json_loadb(text, size, flags, error);
    if (*out)
        return CVOL_OK;
    /* Parses again, once there is memory: only an error of the text repeats. */
    void *memory = malloc(parse_bytes(size));
    if (!memory)
        return cvol_fail_memory(context, parse_bytes(size), what);
    free(memory);
    *out = json_loadb(text, size, flags, error);
    return *out ? CVOL_OK : CVOL_ERROR_FORMAT;
}
