/* Names of outputs: {name} stands for the input, {n} for a number. */
#include <stdlib.h>
#include <string.h>

#include "tools/render/render_picture.h"

/* A file name without folder and without the extension of a volume. */
static const char *base_of(const char *path, size_t *length)
{
    static const char *const endings[] = {".nii.gz", ".nii",  ".nrrd", ".nhdr", ".mha",
                                          ".mhd",    ".cvol", ".raw",  ".img",  ".hdr"};
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
    *length = strlen(base);
    for (size_t k = 0; k < sizeof endings / sizeof *endings; k++)
        if (has_ending(base, endings[k])) {
            *length -= strlen(endings[k]);
            break;
        }
    return base;
}

/* If `at` begins with `what`, appends `text` to `out`. Returns the length of `what`, or 0. */
static size_t put(char *out, size_t *size, const char *at, const char *what, const char *text,
                  size_t length)
{
    if (!text || strncmp(at, what, strlen(what)))
        return 0;
    memcpy(out + *size, text, length);
    *size += length;
    return strlen(what);
}

char *output_name(const char *pattern, const char *path, int number, int digits)
{
    char digits_text[32];
    size_t name_length = 0, size = 0, places = 1;
    const char *name = path ? base_of(path, &name_length) : NULL;
    snprintf(digits_text, sizeof digits_text, "%0*d", digits, number);
    for (const char *at = pattern; *at; at++)
        places += *at == '{';
    char *out = malloc(strlen(pattern) + places * (name_length + sizeof digits_text));
    if (!out)
        return NULL;
    for (const char *at = pattern; *at;) {
        size_t taken = put(out, &size, at, "{name}", name, name_length);
        if (!taken)
            taken = put(out, &size, at, "{n}", digits > 0 ? digits_text : NULL,
                        strlen(digits_text));
        if (!taken) {
            out[size++] = *at;
            taken = 1;
        }
        at += taken;
    }
    out[size] = '\0';
    return out;
}
