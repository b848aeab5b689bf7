/* Sections: headers, checksums, and the sentences about broken ones. */
#include "codec/section.h"

#include <string.h>

#include "base/context.h"

void cvol_section_put_header(cvol_bytes *out, const char *tag, uint64_t length, uint32_t checksum)
{
    size_t start = out->size;
    cvol_bytes_append(out, tag, 4);
    cvol_bytes_put_u64(out, length);
    cvol_bytes_put_u32(out, checksum);
    if (!out->failed)
        cvol_bytes_put_u32(out, cvol_crc32c(out->data + start, out->size - start));
}

void cvol_section_put(cvol_bytes *out, const char *tag, const cvol_bytes *content)
{
    cvol_section_put_header(out, tag, content->size, cvol_crc32c(content->data, content->size));
    cvol_bytes_append(out, content->data, content->size);
    out->failed |= content->failed;
}

int cvol_section_check(cvol_context *context, uint32_t stored, uint32_t found, const char *tag,
                       const char *name)
{
    if (stored == found)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_CORRUPT,
                     "%s: section %.4s: checksum is %08x, its content gives %08x", name, tag,
                     stored, found);
}

int cvol_section_take(cvol_context *context, cvol_cursor *content, uint32_t *checksum,
                      cvol_cursor *file, const char *tag, const char *name)
{
    const size_t left = cvol_cursor_left(file);
    const uint8_t *header = cvol_cursor_take(file, CVOL_SECTION_HEADER_BYTES);
    if (!header)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: truncated in section %.4s, its header has %zu of %d bytes", name, tag,
                         left, (int)CVOL_SECTION_HEADER_BYTES);
    cvol_cursor fields = cvol_cursor_make(header + 4, CVOL_SECTION_HEADER_BYTES - 4);
    const uint64_t length = cvol_cursor_u64(&fields);
    *checksum = cvol_cursor_u32(&fields);
    const uint32_t stored = cvol_cursor_u32(&fields), found = cvol_crc32c(header, 16);
    if (stored != found)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: header of section %.4s: checksum is %08x, its content gives %08x",
                         name, tag, stored, found);
    if (memcmp(header, tag, 4))
        return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: another section where %.4s must be",
                         name, tag);
    if (length > cvol_cursor_left(file))
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: truncated in section %.4s, %zu of %llu bytes", name, tag,
                         cvol_cursor_left(file), (unsigned long long)length);
    *content = cvol_cursor_make(cvol_cursor_take(file, (size_t)length), (size_t)length);
    return CVOL_OK;
}
