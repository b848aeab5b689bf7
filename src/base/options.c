/* Copies option structs of callers. */
#include "base/options.h"

#include <string.h>

#include "base/context.h"

static size_t smaller(size_t a, size_t b)
{
    return a < b ? a : b;
}

static int check(cvol_context *context, size_t known, size_t least, const char *name,
                 const void *given, size_t size)
{
    if (size < least || size > CVOL_OPTIONS_SIZE_MAX)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: its size is %zu, must be sizeof(%s), at least %zu", name, size, name,
                         least);
    const uint8_t *bytes = given;
    for (size_t i = known; i < size; i++)
        if (bytes[i])
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "%s: its size is %zu, this library knows %zu bytes, and byte %zu is "
                             "set: use a newer library",
                             name, size, known, i);
    return CVOL_OK;
}

int cvol_options_copy(cvol_context *context, void *out, size_t known, size_t least,
                      const char *name, const void *given)
{
    size_t size;
    memcpy(&size, given, sizeof size);
    const int code = check(context, known, least, name, given, size);
    if (!code)
        memcpy(out, given, smaller(size, known));
    memcpy(out, &known, sizeof known);
    return code;
}

void cvol_options_fill(void *out, size_t size, const void *defaults, size_t known)
{
    if (size < sizeof size)
        return;
    memset(out, 0, size);
    memcpy(out, defaults, smaller(size, known));
    memcpy(out, &size, sizeof size);
}
