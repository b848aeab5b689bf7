/* Planes of bytes, and zstd frames. */
#include "codec/section/packed.h"

#include <stdlib.h>
#include <string.h>
#include <zstd.h>
#include <zstd_errors.h>

#include "base/context.h"
#include "base/memory.h"

enum { ZSTD_LEVEL = 9 };

/* The search by rows of hashes (ZSTD_c_useRowMatchFinder): beyond this size zstd for x86-64 and ARM
 * uses it, but zstd for other processors only for larger frames, which gives them other bytes. */
enum {
    ROW_SEARCH = ZSTD_c_experimentalParam14,
    IS_ENABLED = 1,
    IS_DISABLED = 2,
    ROWS_AT = 1 << 14
};

void cvol_planes_put(cvol_bytes *out, const void *numbers, size_t count, int bytes)
{
    const uint8_t *from = numbers;
    if (!cvol_bytes_reserve(out, count * (size_t)bytes))
        return;
    for (int plane = 0; plane < bytes; plane++)
        for (size_t i = 0; i < count; i++) {
            uint32_t number;
            memcpy(&number, from + 4 * i, 4);
            out->data[out->size++] = (uint8_t)(number >> 8 * plane);
        }
}

void cvol_planes_take(void *numbers, size_t count, int bytes, cvol_cursor *from)
{
    uint8_t *to = numbers;
    if (count)
        memset(to, 0, 4 * count);
    for (int plane = 0; plane < bytes; plane++) {
        const uint8_t *data = cvol_cursor_take(from, count);
        for (size_t i = 0; i < count && data; i++) {
            uint32_t number;
            memcpy(&number, to + 4 * i, 4);
            number |= (uint32_t)data[i] << 8 * plane;
            memcpy(to + 4 * i, &number, 4);
        }
    }
}

size_t cvol_zstd_put(void *out, size_t room, const void *data, size_t size, int level)
{
    ZSTD_CCtx *coder = ZSTD_createCCtx();
    if (!coder)
        return (size_t)-ZSTD_error_memory_allocation;
    ZSTD_CCtx_setParameter(coder, ZSTD_c_compressionLevel, level);
    /* zstd before 1.5 has no such search, and refuses the parameter. */
    ZSTD_CCtx_setParameter(coder, (ZSTD_cParameter)ROW_SEARCH,
                           size > ROWS_AT ? IS_ENABLED : IS_DISABLED);
    const size_t packed = ZSTD_compress2(coder, out, room, data, size);
    ZSTD_freeCCtx(coder);
    return packed;
}

int cvol_packed_put(cvol_context *context, cvol_bytes *out, const cvol_bytes *raw)
{
    const size_t bound = ZSTD_compressBound(raw->size);
    if (raw->failed || !cvol_bytes_reserve(out, bound))
        return cvol_fail_memory(context, bound, "the file's terms");
    size_t packed = cvol_zstd_put(out->data + out->size, bound, raw->data, raw->size, ZSTD_LEVEL);
    if (ZSTD_isError(packed))
        return cvol_fail_memory(context, raw->size, "the file's terms");
    out->size += packed;
    return CVOL_OK;
}

int cvol_zstd_take(void *out, size_t size, const uint8_t *frame, size_t bytes)
{
    const size_t found = frame ? ZSTD_decompress(out, size, frame, bytes) : 0;
    if (frame && found == size)
        return CVOL_OK;
    return ZSTD_getErrorCode(found) == ZSTD_error_memory_allocation ? CVOL_ERROR_MEMORY
                                                                    : CVOL_ERROR_CORRUPT;
}

int cvol_packed_take(cvol_context *context, uint8_t **raw, uint64_t size, cvol_cursor *content,
                     const char *tag, const char *name)
{
    const size_t left = cvol_cursor_left(content);
    const uint8_t *frame = cvol_cursor_take(content, left);
    *raw = NULL;
    if (size / CVOL_PACKED_EXPANSION > left)
        return cvol_fail(context, CVOL_ERROR_CORRUPT,
                         "%s: section %s: %llu bytes of terms are more than %zu bytes can hold",
                         name, tag, (unsigned long long)size, left);
    if (size > cvol_context_limit_bytes(context) || size > SIZE_MAX)
        return cvol_fail(context, CVOL_ERROR_LIMIT, "%s: section %s: has %llu bytes of terms", name,
                         tag, (unsigned long long)size);
    *raw = cvol_allocate((size_t)size, 1);
    if (!*raw)
        return cvol_fail_memory(context, (size_t)size, "the file's terms");
    const int code = cvol_zstd_take(*raw, (size_t)size, frame, left);
    if (!code)
        return CVOL_OK;
    free(*raw);
    *raw = NULL;
    if (code == CVOL_ERROR_MEMORY)
        return cvol_fail_memory(context, (size_t)size, "unpacking the file's terms");
    return cvol_fail(context, CVOL_ERROR_CORRUPT,
                     "%s: section %s does not hold %llu bytes of terms", name, tag,
                     (unsigned long long)size);
}
