/* Chunks of Zarr arrays: their files, shards, check sums, and compression by zlib, gzip and zstd.
 */
#define _GNU_SOURCE
#include "volume/formats/zarr/chunk.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>
#include <zstd.h>

#include "base/byte_order.h"
#include "base/bytes.h"
#include "base/context.h"
#include "base/memory.h"
#include "volume/io/input.h"
#include "volume/io/unpack_blosc.h"

/* ---- bytes --------------------------------------------------------------------------- */

/* The most bytes that a packed chunk may have: packing adds little. */
static size_t most_bytes(const cvol_zarr_array *array)
{
    return 2 * array->chunk_bytes + ((size_t)1 << 20);
}

/* The file of a chunk or shard; the caller frees it. NULL without memory. */
static char *name_file(const cvol_zarr_array *array, const uint64_t place[CVOL_ZARR_AXES])
{
    char key[32 * CVOL_ZARR_AXES];
    int length = snprintf(key, sizeof key, "%s", array->prefix);
    for (int a = 0; a < array->rank; a++) {
        const char between[2] = {length ? array->separator : '\0', '\0'};
        length += snprintf(key + length, sizeof key - (size_t)length, "%s%llu", between,
                           (unsigned long long)(place[a] / array->shard[a]));
    }
    return cvol_zarr_join(array->path, key);
}

/* Checks the CRC-32C behind the `size` bytes of a shard's index at `begin`. */
static int check_index(cvol_context *context, const cvol_input *input, uint64_t begin,
                       uint64_t size)
{
    uint8_t part[16384], sum[4];
    uint32_t crc = 0;
    size_t got = 0;
    int code = CVOL_OK;
    for (uint64_t at = 0; at < size && !code; at += got) {
        const size_t step = size - at < sizeof part ? (size_t)(size - at) : sizeof part;
        code = cvol_input_read(context, input, begin + at, part, step, &got);
        if (!code && got != step)
            code = cvol_fail(context, CVOL_ERROR_FORMAT, "%s: is cut off", input->path);
        crc = cvol_crc32c_more(crc, part, got);
    }
    if (!code)
        code = cvol_input_read(context, input, begin + size, sum, sizeof sum, &got);
    if (code)
        return code;
    cvol_cursor cursor = cvol_cursor_make(sum, got);
    if (cvol_cursor_u32(&cursor) == crc && !cursor.failed)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: the check sum of the shard's index is wrong",
                     input->path);
}

/* The same once for each shard, as long as other shards do not take its place. */
static int check_index_once(cvol_context *context, const cvol_input *input, uint64_t begin,
                            uint64_t size, const cvol_zarr_array *array,
                            const uint64_t place[CVOL_ZARR_AXES])
{
    uint64_t shard = 0;
    for (int a = 0; a < array->rank; a++)
        shard = shard * (array->shape[a] / array->chunk[a] / array->shard[a] + 1) +
                place[a] / array->shard[a];
    _Atomic uint64_t *checked = &array->checked[shard % CVOL_ZARR_CHECKED];
    if (!array->index_checksum || *checked == shard + 1)
        return CVOL_OK;
    const int code = check_index(context, input, begin, size);
    if (!code)
        *checked = shard + 1;
    return code;
}

/* Finds the bytes of a chunk of a shard. *size 0: the shard does not have it. */
static int find_in_shard(cvol_context *context, const cvol_input *input, uint64_t *offset,
                         uint64_t *size, const cvol_zarr_array *array,
                         const uint64_t place[CVOL_ZARR_AXES])
{
    uint64_t number = 0, count = 1;
    uint8_t entry[16];
    size_t got = 0;
    for (int a = 0; a < array->rank; a++) {
        number = number * array->shard[a] + place[a] % array->shard[a];
        count *= array->shard[a];
    }
    const uint64_t index = 16 * count + array->index_checksum;
    if (input->size < index)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: has %llu bytes, but the index of its %llu chunks needs %llu",
                         input->path, (unsigned long long)input->size, (unsigned long long)count,
                         (unsigned long long)index);
    const uint64_t begin = array->index_at_start ? 0 : input->size - index;
    int code = check_index_once(context, input, begin, 16 * count, array, place);
    if (!code)
        code = cvol_input_read(context, input, begin + 16 * number, entry, sizeof entry, &got);
    cvol_cursor cursor = cvol_cursor_make(entry, got);
    *offset = cvol_cursor_u64(&cursor);
    *size = cvol_cursor_u64(&cursor);
    if (code || (*offset == UINT64_MAX && *size == UINT64_MAX)) {
        *size = 0;
        return code;
    }
    if (cursor.failed || *offset > input->size || *size > input->size - *offset || !*size)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: chunk %llu has %llu bytes from byte %llu, but the shard has %llu",
                         input->path, (unsigned long long)number, (unsigned long long)*size,
                         (unsigned long long)*offset, (unsigned long long)input->size);
    return CVOL_OK;
}

/* Reads a chunk's packed bytes. *data NULL: there is no such chunk. */
static int read_bytes(cvol_context *context, uint8_t **data, size_t *size, const char *path,
                      const cvol_zarr_array *array, const uint64_t place[CVOL_ZARR_AXES])
{
    cvol_input input;
    uint64_t offset = 0, bytes;
    *data = NULL;
    if (access(path, F_OK) && (errno == ENOENT || errno == ENOTDIR))
        return CVOL_OK;
    int code = cvol_input_open(context, &input, path);
    bytes = input.size;
    if (!code && array->is_sharded)
        code = find_in_shard(context, &input, &offset, &bytes, array, place);
    if (!code && bytes > most_bytes(array))
        code = cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: a chunk has %llu bytes, more than its %zu bytes of samples can take",
                         path, (unsigned long long)bytes, array->chunk_bytes);
    if (!code && bytes && !(*data = malloc((size_t)bytes)))
        code = cvol_fail_memory(context, (size_t)bytes, path);
    if (!code && *data)
        code = cvol_input_read(context, &input, offset, *data, (size_t)bytes, size);
    cvol_input_close(&input);
    if (!code && *data && *size != bytes)
        code = cvol_fail(context, CVOL_ERROR_FORMAT, "%s: is cut off", path);
    return code;
}

/* ---- unpacking ----------------------------------------------------------------------- */

static int fail_size(cvol_context *context, const char *path, const char *how, size_t got,
                     size_t room)
{
    return cvol_fail(context, CVOL_ERROR_FORMAT,
                     "%s: a chunk holds %s%zu bytes of samples, must hold %zu", path, how, got,
                     room);
}

static int inflate_all(cvol_context *context, uint8_t *out, size_t room, const uint8_t *data,
                       size_t size, const char *path)
{
    z_stream z = {.next_in = (Bytef *)(uintptr_t)data};
    uint8_t more;
    size_t left = size, done = 0;
    if (inflateInit2(&z, 15 + 32) != Z_OK) /* zlib or gzip */
        return cvol_fail_memory(context, size, path);
    int status = Z_OK;
    while (status == Z_OK && done <= room) { /* one byte more than expected is an error */
        const size_t step = room - done < ((size_t)1 << 30) ? room - done : (size_t)1 << 30;
        const size_t feed = left < ((size_t)1 << 30) ? left : (size_t)1 << 30;
        z.next_out = step ? out + done : &more;
        z.avail_out = step ? (uInt)step : 1;
        z.avail_in = (uInt)feed;
        const uInt had = z.avail_out;
        status = inflate(&z, Z_NO_FLUSH);
        left -= feed - z.avail_in;
        done += had - z.avail_out;
    }
    inflateEnd(&z);
    if (done > room)
        return fail_size(context, path, "more than ", room, room);
    if (status != Z_STREAM_END)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: its compressed samples (zlib or gzip) are damaged or cut off", path);
    return done == room ? CVOL_OK : fail_size(context, path, "", done, room);
}

static int unpack_zstd(cvol_context *context, uint8_t *out, size_t room, const uint8_t *data,
                       size_t size, const char *path)
{
    const unsigned long long stated = ZSTD_getFrameContentSize(data, size);
    if (stated != ZSTD_CONTENTSIZE_ERROR && stated != ZSTD_CONTENTSIZE_UNKNOWN && stated > room)
        return fail_size(context, path, "", (size_t)stated, room);
    const size_t done = ZSTD_decompress(out, room, data, size);
    if (ZSTD_isError(done))
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: its compressed samples (zstd): %s", path,
                         ZSTD_getErrorName(done));
    return done == room ? CVOL_OK : fail_size(context, path, "", done, room);
}

static int check_sum(cvol_context *context, const uint8_t *data, size_t *size, const char *path)
{
    if (*size >= 4) {
        *size -= 4;
        cvol_cursor cursor = cvol_cursor_make(data + *size, 4);
        if (cvol_cursor_u32(&cursor) == cvol_crc32c(data, *size))
            return CVOL_OK;
    }
    return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: the check sum of a chunk is wrong", path);
}

static int unpack(cvol_context *context, uint8_t *out, const cvol_zarr_array *array,
                  const uint8_t *data, size_t size, const char *path)
{
    const size_t room = array->chunk_bytes;
    int code = array->has_checksum ? check_sum(context, data, &size, path) : CVOL_OK;
    if (code)
        return code;
    switch (array->packing) {
    case CVOL_ZARR_DEFLATE:
        return inflate_all(context, out, room, data, size, path);
    case CVOL_ZARR_ZSTD:
        return unpack_zstd(context, out, room, data, size, path);
    case CVOL_ZARR_BLOSC:
        return cvol_unpack_blosc(context, out, room, data, size, path);
    case CVOL_ZARR_CVOL:
        return cvol_zarr_decode_cvol(context, out, array, data, size, path);
    case CVOL_ZARR_PLAIN:
    default:
        break;
    }
    if (size != room)
        return fail_size(context, path, "", size, room);
    memcpy(out, data, room);
    return CVOL_OK;
}

int cvol_zarr_chunk_read(cvol_context *context, void *out, int *is_missing,
                         const cvol_zarr_array *array, const uint64_t place[CVOL_ZARR_AXES])
{
    uint8_t *data = NULL;
    size_t size = 0;
    char *path = name_file(array, place);
    if (!path)
        return cvol_fail_memory(context, strlen(array->path), array->path);
    int code = read_bytes(context, &data, &size, path, array, place);
    *is_missing = !code && !data;
    if (!code && data)
        code = unpack(context, out, array, data, size, path);
    if (!code && data && array->big_endian != cvol_machine_is_big_endian() && array->element > 1)
        cvol_swap_bytes(out, array->chunk_bytes / array->element, array->element);
    free(data);
    free(path);
    return code;
}
