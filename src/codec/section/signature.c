/* The signature and the version of .cvol files. */
#include "codec/section/signature.h"

#include "base/context.h"

/* A byte with the high bit (detects 7-bit lines), the name, CR LF (detects conversions), ^Z (ends
 * TYPE), LF. */
static const uint8_t signature[CVOL_SIGNATURE_BYTES] = {0x8B, 'C',  'V',  'L',
                                                        0x0D, 0x0A, 0x1A, 0x0A};

size_t cvol_container_matches(const uint8_t *data, size_t size)
{
    size_t same = 0;
    while (same < sizeof signature && same < size && data[same] == signature[same])
        same++;
    return same;
}

uint8_t cvol_container_signature(size_t i)
{
    return signature[i];
}

int cvol_container_is(const uint8_t *data, size_t size)
{
    return cvol_container_matches(data, size) == sizeof signature;
}

int cvol_container_check_version(cvol_context *context, uint32_t version, const char *name)
{
    if (version == CVOL_FORMAT_VERSION)
        return CVOL_OK;
    if (version < CVOL_FORMAT_VERSION)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: is a .cvol of version %u (at byte %d), which is no longer read: "
                         "compress the volume again, or decompress the file with the cvol that "
                         "wrote it",
                         name, version, (int)CVOL_SIGNATURE_BYTES);
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                     "%s: is a .cvol of version %u (at byte %d), this library reads version %d",
                     name, version, (int)CVOL_SIGNATURE_BYTES, (int)CVOL_FORMAT_VERSION);
}

int cvol_container_take_start(cvol_context *context, cvol_cursor *file, const char *name)
{
    if (!cvol_container_is(file->data, file->size))
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: is not a .cvol file", name);
    cvol_cursor_take(file, CVOL_SIGNATURE_BYTES);
    const uint32_t version = cvol_cursor_u32(file);
    if (file->failed)
        return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: truncated: within its version", name);
    return cvol_container_check_version(context, version, name);
}
