/* Data arrays of VTK's XML files (VTK file formats, kitware.com): an array is its size in bytes and
 * its bytes; or, compressed, the number of blocks, a block's size, the last one's if it is shorter,
 * and all compressed sizes, then the blocks. In base64 both parts are separate units. */
#include "volume/formats/vtk/vti_data.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "volume/io/inflate.h"

uint64_t cvol_vti_integer(const cvol_vti_coding *coding, const uint8_t *bytes)
{
    uint64_t value = 0;
    for (size_t i = 0; i < coding->word; i++)
        value = value << 8 | bytes[coding->big_endian ? i : coding->word - 1 - i];
    return value;
}

/* ---- base64 -------------------------------------------------------------------------- */

static int digit_of(uint8_t c)
{
    return c >= 'A' && c <= 'Z'   ? c - 'A'
           : c >= 'a' && c <= 'z' ? c - 'a' + 26
           : c >= '0' && c <= '9' ? c - '0' + 52
           : c == '+'             ? 62
           : c == '/'             ? 63
                                  : -1;
}

size_t cvol_vti_base64(uint8_t *text, size_t size)
{
    size_t out = 0, digits = 0;
    uint32_t bits = 0;
    for (size_t i = 0; i < size; i++) {
        const uint8_t c = text[i];
        if (c == ' ' || (c >= '\t' && c <= '\r'))
            continue;
        if (digit_of(c) < 0 && c != '=')
            break;
        if (c == '=') { /* the end of a unit: of two digits one byte, of three two */
            for (size_t b = 1; b < digits; b++)
                text[out++] = (uint8_t)(bits << (24 - 6 * digits) >> (24 - 8 * b));
            digits = 0;
            bits = 0;
            continue;
        }
        bits = bits << 6 | (uint32_t)digit_of(c);
        if (++digits == 4) {
            text[out++] = (uint8_t)(bits >> 16);
            text[out++] = (uint8_t)(bits >> 8);
            text[out++] = (uint8_t)bits;
            digits = 0;
            bits = 0;
        }
    }
    return out;
}

/* ---- arrays -------------------------------------------------------------------------- */

static int fail(cvol_context *context, const char *path, const char *what, uint64_t got,
                uint64_t wanted)
{
    return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: its array %s %llu bytes, not %llu", path,
                     what, (unsigned long long)got, (unsigned long long)wanted);
}

static int inflate_blocks(const cvol_vti_coding *coding, const uint8_t *bytes, size_t size,
                          uint64_t blocks, uint64_t block, uint8_t *out, size_t wanted)
{
    size_t at = (3 + (size_t)blocks) * coding->word, done = 0;
    for (uint64_t b = 0; b < blocks; b++) {
        const uint64_t packed = cvol_vti_integer(coding, bytes + (3 + (size_t)b) * coding->word);
        uLongf length = (uLongf)(wanted - done < block ? wanted - done : block);
        const size_t expected = length;
        if (packed > size - at ||
            uncompress(out + done, &length, bytes + at, (uLong)packed) != Z_OK ||
            length != expected)
            return 0;
        at += (size_t)packed;
        done += expected;
    }
    return done == wanted;
}

static int unpack_zlib(cvol_context *context, uint8_t *out, const cvol_vti_coding *coding,
                       const uint8_t *bytes, size_t size, size_t wanted, const char *path)
{
    const uint64_t blocks = cvol_vti_integer(coding, bytes);
    const uint64_t block = cvol_vti_integer(coding, bytes + coding->word);
    const uint64_t last = cvol_vti_integer(coding, bytes + 2 * coding->word);
    uint64_t total;
    if (blocks > size / coding->word - 3 || __builtin_mul_overflow(blocks, block, &total) ||
        last > block || (last && !blocks))
        return fail(context, path, "has blocks of", block, wanted);
    total -= last ? block - last : 0;
    if (total != wanted)
        return fail(context, path, "has", total, wanted);
    if (inflate_blocks(coding, bytes, size, blocks, block, out, wanted))
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: its compressed array is damaged or cut off",
                     path);
}

int cvol_vti_unpack(cvol_context *context, uint8_t **out, const cvol_vti_coding *coding,
                    const uint8_t *bytes, size_t size, size_t wanted, const char *path)
{
    const size_t head = (coding->is_zlib ? 3 : 1) * coding->word;
    if (size < head)
        return fail(context, path, "has a header cut off at", size, head);
    if (wanted > context->limit_bytes)
        return cvol_fail(context, CVOL_ERROR_LIMIT, "%s: %zu bytes are more than the limit of %llu",
                         path, wanted, (unsigned long long)context->limit_bytes);
    if (!coding->is_zlib && (cvol_vti_integer(coding, bytes) != wanted || size - head < wanted))
        return fail(context, path, "has",
                    size - head < wanted ? size - head : cvol_vti_integer(coding, bytes), wanted);
    if (wanted / CVOL_INFLATE_FACTOR > size)
        return fail(context, path, "cannot be so small:", size, wanted);
    *out = cvol_allocate(wanted, 1);
    if (!*out)
        return cvol_fail_memory(context, wanted, path);
    int code = CVOL_OK;
    if (coding->is_zlib)
        code = unpack_zlib(context, *out, coding, bytes, size, wanted, path);
    else
        memcpy(*out, bytes + head, wanted);
    if (code) {
        free(*out);
        *out = NULL;
    }
    return code;
}
