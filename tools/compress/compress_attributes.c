/* cvol compress: the attributes of a file. */
#define _GNU_SOURCE
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "tools/compress/compress.h"

char *read_text(const char *path)
{
    FILE *file = fopen(path, "rb");
    char *text = NULL;
    size_t size = 0;
    if (!file) {
        report_error(EXIT_FAILED, "%s: %s", path, strerror(errno));
        return NULL;
    }
    for (size_t capacity = 4096;; capacity *= 2) {
        char *more = realloc(text, capacity);
        if (!more) {
            report_error(EXIT_FAILED, "%s: not enough memory", path);
            break;
        }
        text = more;
        size += fread(text + size, 1, capacity - 1 - size, file);
        if (size < capacity - 1) {
            const int trouble = ferror(file) ? errno : 0;
            fclose(file);
            text[size] = '\0';
            if (!trouble && strlen(text) == size)
                return text;
            report_error(EXIT_FAILED, "%s: %s", path,
                         trouble ? strerror(trouble) : "is not a text file");
            free(text);
            return NULL;
        }
    }
    fclose(file);
    free(text);
    return NULL;
}

int find_attributes(char **text, const input *in, const char *path)
{
    const char *old = in->array ? cvol_array_attributes(in->array) : NULL;
    json_error_t error;
    *text = NULL;
    if (!path && old && !(*text = strdup(old)))
        return report_error(EXIT_FAILED, "not enough memory");
    if (!path)
        return EXIT_DONE;
    *text = read_text(path);
    if (!*text)
        return EXIT_FAILED;
    json_t *value = json_loads(*text, JSON_DECODE_ANY | JSON_ALLOW_NUL, &error);
    json_decref(value);
    return value ? EXIT_DONE
           : json_lacks_memory()
               ? report_error(EXIT_FAILED, "%s: not enough memory", path)
               : report_error(EXIT_FAILED, "%s: is not valid JSON: line %d, column %d: %s", path,
                              error.line, error.column, error.text);
}
