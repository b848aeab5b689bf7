/* JSON files of Zarr folders. */
#define _GNU_SOURCE
#include "volume/formats/zarr/json.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/bytes.h"
#include "base/context.h"
#include "base/file.h"
#include "base/json_text.h"

/* The largest file; consolidated metadata of large groups has some MB. */
#define JSON_BYTES_MAX ((size_t)64 << 20)
/* Sizes up to here are exact in JSON numbers of all programs. */
#define SIZE_LARGEST (INT64_C(1) << 53)

char *cvol_zarr_join(const char *folder, const char *name)
{
    char *path;
    const size_t length = strlen(folder);
    return asprintf(&path, "%s%s%s", folder, length && folder[length - 1] == '/' ? "" : "/", name) <
                   0
               ? NULL
               : path;
}

/* Puts quotes around integers that a signed integer of 64 bits cannot hold, which Jansson refuses.
 * *out NULL: there is none. The caller frees it. 0 without memory. */
static int quote_large_integers(char **out, size_t *size, const char *text)
{
    cvol_bytes copy = {0};
    size_t done = 0;
    int within = 0; /* a text in quotes */
    for (size_t at = 0; at < *size;) {
        const char c = text[at];
        size_t digits = 0;
        while (!within && at + digits < *size && text[at + digits] >= '0' &&
               text[at + digits] <= '9')
            digits++;
        const char next = at + digits < *size ? text[at + digits] : ' ';
        const char before = at ? text[at - 1] : ' ';
        if ((digits == 19 || digits == 20) && !strchr("+-.eE", before) && !strchr(".eE", next)) {
            char number[24];
            snprintf(number, sizeof number, "\"%.*s\"", (int)digits, text + at);
            errno = 0;
            if (strtoll(number + 1, NULL, 10) == LLONG_MAX && errno == ERANGE) {
                cvol_bytes_append(&copy, text + done, at - done);
                cvol_bytes_put_text(&copy, number);
                done = at + digits;
            }
        }
        within ^= c == '"';
        at += digits ? digits : within && c == '\\' ? 2 : 1;
    }
    if (done)
        cvol_bytes_append(&copy, text + done, *size - done);
    if (copy.failed) {
        cvol_bytes_free(&copy);
        return 0;
    }
    *size = done ? copy.size : *size;
    *out = (char *)copy.data;
    return 1;
}

int cvol_zarr_json_open(cvol_context *context, cvol_zarr_json *json, const char *folder,
                        const char *name)
{
    uint8_t *data;
    size_t size;
    *json = (cvol_zarr_json){.context = context, .path = cvol_zarr_join(folder, name)};
    if (!json->path)
        return cvol_fail_memory(context, strlen(folder), folder);
    if (access(json->path, F_OK) && (errno == ENOENT || errno == ENOTDIR))
        return CVOL_OK;
    int code = cvol_file_read(context, &data, &size, json->path, 0, JSON_BYTES_MAX + 1);
    if (code)
        return code;
    json_error_t error = {.line = 0};
    char *quoted = NULL;
    if (size > JSON_BYTES_MAX)
        code = cvol_fail(context, CVOL_ERROR_FORMAT, "%s: has more than %zu bytes of metadata",
                         json->path, JSON_BYTES_MAX);
    else if (!quote_large_integers(&quoted, &size, (const char *)data))
        code = cvol_fail_memory(context, size, json->path);
    else if ((code = cvol_json_load(context, &json->root, quoted ? quoted : (const char *)data,
                                    size, 0, &error, json->path)) == CVOL_ERROR_FORMAT)
        code = cvol_fail(context, code, "%s: is not JSON: line %d", json->path, error.line);
    else if (!code && !json_is_object(json->root))
        code = cvol_fail(context, CVOL_ERROR_FORMAT, "%s: is JSON, but not an object", json->path);
    free(quoted);
    free(data);
    return code;
}

void cvol_zarr_json_close(cvol_zarr_json *json)
{
    json_decref(json->root);
    free(json->path);
    *json = (cvol_zarr_json){0};
}

int cvol_zarr_json_fail(const cvol_zarr_json *json, int code, const char *field,
                        const json_t *value, const char *must)
{
    char *text = value ? json_dumps(value, JSON_ENCODE_ANY | JSON_ENSURE_ASCII) : NULL;
    const int is_long = text && strlen(text) > 80;
    cvol_fail(json->context, code, "%s: '%s' is %.80s%s, %s", json->path, field,
              text ? text : "missing", is_long ? "..." : "", must);
    free(text);
    return code;
}

int cvol_zarr_json_sizes(const cvol_zarr_json *json, const char *field, const json_t *list,
                         uint64_t least, uint64_t *out, int *count)
{
    char must[96];
    const size_t size = json_array_size(list);
    int right = json_is_array(list) && size >= 1 && size <= CVOL_ZARR_AXES &&
                (!*count || size == (size_t)*count);
    for (size_t i = 0; right && i < size; i++) {
        const json_t *entry = json_array_get(list, i);
        const json_int_t value = json_integer_value(entry);
        right = json_is_integer(entry) && value >= (json_int_t)least && value <= SIZE_LARGEST;
        out[i] = (uint64_t)value;
    }
    if (right) {
        *count = (int)size;
        return CVOL_OK;
    }
    if (*count)
        snprintf(must, sizeof must, "must be %d integers from %d to 2^53", *count, (int)least);
    else
        snprintf(must, sizeof must, "must be 1 to %d integers from %d to 2^53", CVOL_ZARR_AXES,
                 (int)least);
    return cvol_zarr_json_fail(json, CVOL_ERROR_FORMAT, field, list, must);
}
