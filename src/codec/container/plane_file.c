/* Files of planes: sections in order, and their errors. */
#include "codec/container/plane_file.h"

#include <string.h>

#include "base/context.h"
#include "base/file.h"
#include "codec/section/signature.h"

int cvol_plane_file_put(cvol_context *context, cvol_bytes *out, cvol_section_kind head,
                        const cvol_bytes *head_content, const cvol_bytes *planes)
{
    for (size_t i = 0; i < CVOL_SIGNATURE_BYTES; i++)
        cvol_bytes_put_u8(out, cvol_container_signature(i));
    cvol_bytes_put_u32(out, CVOL_FORMAT_VERSION);
    cvol_section_put(out, head, head_content);
    cvol_section_put(out, CVOL_PLNS, planes);
    cvol_section_put(out, CVOL_ENDS, &(cvol_bytes){0});
    return out->failed ? cvol_fail_memory(context, out->size, "the file") : CVOL_OK;
}

int cvol_plane_file_end(cvol_context *context, cvol_bytes *bytes, int code, const char *path,
                        uint64_t *file_bytes)
{
    if (!code)
        code = cvol_file_write(context, bytes->data, bytes->size, path);
    if (!code && file_bytes)
        *file_bytes = bytes->size;
    cvol_bytes_free(bytes);
    return code;
}

int cvol_plane_file_take(cvol_context *context, cvol_section *head, cvol_section *planes,
                         cvol_section_kind kind, const uint8_t *data, size_t size, const char *name)
{
    cvol_cursor file = cvol_cursor_make(data, size);
    int found = 0, code = cvol_container_take_start(context, &file, name);
    if (code)
        return code;
    cvol_section_walk walk = cvol_section_walk_make(file);
    while (!code && !cvol_section_walk_ended(&walk)) {
        cvol_section section;
        code = cvol_section_next(context, &section, &walk, name);
        if (!code)
            code = cvol_section_check(context, &section, name);
        if (section.kind == kind)
            *head = section;
        if (section.kind == CVOL_PLNS)
            *planes = section;
        found |= section.kind == kind;
        if (!code && section.kind != CVOL_SECTION_UNKNOWN && !found)
            code = cvol_fail(
                context, CVOL_ERROR_FORMAT, "%s: is not a %s: it begins with section %s", name,
                kind == CVOL_PICT ? "compressed picture" : "baked volume", section.tag);
    }
    return code;
}

int cvol_plane_file_check(cvol_context *context, const cvol_plane_shape *shape, uint64_t planes,
                          uint64_t bytes, const char *name)
{
    /* dims are below 2^16, planes below 2^18 */
    const uint64_t tiles = cvol_plane_tiles(shape), places = cvol_plane_places(shape);
    if (tiles * planes / CVOL_TILE_EXPANSION > bytes + 8)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: %llu planes of %zu x %zu are more than %llu bytes can hold", name,
                         (unsigned long long)planes, shape->dims[0], shape->dims[1],
                         (unsigned long long)bytes);
    if (32 * places > cvol_context_limit_bytes(context) ||
        64 * tiles * planes > cvol_context_limit_bytes(context))
        return cvol_fail(context, CVOL_ERROR_LIMIT, "%s: has planes of %zu x %zu places", name,
                         shape->dims[0], shape->dims[1]);
    return CVOL_OK;
}

/* ---- kinds ---------------------------------------------------------------------------------- */

cvol_file_kind cvol_plane_file_kind(const uint8_t *data, size_t size)
{
    if (!cvol_container_is(data, size))
        return CVOL_FILE_OTHER;
    if (size >= CVOL_SECTIONS_AT + 4 && !memcmp(data + CVOL_SECTIONS_AT, "PICT", 4))
        return CVOL_FILE_PICTURE;
    if (size >= CVOL_SECTIONS_AT + 4 && !memcmp(data + CVOL_SECTIONS_AT, "BAKE", 4))
        return CVOL_FILE_BAKED;
    if (size >= CVOL_SECTIONS_AT + 4 && !memcmp(data + CVOL_SECTIONS_AT, "LIST", 4))
        return CVOL_FILE_SERIES;
    return CVOL_FILE_ARRAY;
}

int cvol_file_read_kind(cvol_context *context, cvol_file_kind *out, const char *path)
{
    uint8_t data[CVOL_SECTIONS_AT + 4];
    size_t size;
    *out = CVOL_FILE_OTHER;
    const int code = cvol_file_peek(context, data, &size, sizeof data, path);
    if (!code)
        *out = cvol_plane_file_kind(data, size);
    return code == CVOL_ERROR_IO && cvol_file_may_be_regular(path) ? code : CVOL_OK;
}

cvol_file_kind cvol_file_kind_of(const char *path)
{
    cvol_context context = {.limit_bytes = 0}; /* for discarded messages */
    cvol_file_kind kind;
    return cvol_file_read_kind(&context, &kind, path) ? CVOL_FILE_OTHER : kind;
}
