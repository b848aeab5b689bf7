/* One channel of colours. */
#include "volume/io/interleaved.h"

#include <stdlib.h>

#include "base/context.h"
#include "base/grid.h"
#include "base/memory.h"
#include "volume/io/inflate.h"

/* The bytes [skip, skip + size) of a stream that begins at byte `at` of a file, unpacked. */
static int inflate_part(cvol_context *context, uint8_t **out, const char *path, uint64_t at,
                        uint64_t skip, size_t size)
{
    cvol_input input;
    cvol_inflater *inflater = NULL;
    uint64_t got = 0;
    *out = NULL;
    int code = cvol_input_open(context, &input, path);
    if (!code && size / CVOL_INFLATE_FACTOR > input.size + CVOL_INFLATE_SLACK)
        code = cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: %llu bytes cannot unpack to %zu of samples", path,
                         (unsigned long long)input.size, size);
    if (!code)
        code = cvol_inflater_open(context, &inflater, &input, at,
                                  input.size > at ? input.size - at : 0);
    if (!code)
        code = cvol_inflater_read(context, inflater, NULL, skip, &got);
    if (!code && !(*out = malloc(size)))
        code = cvol_fail_memory(context, size, path);
    if (!code)
        code = cvol_inflater_read(context, inflater, *out, size, &got);
    if (!code && got < size)
        code = cvol_fail(context, CVOL_ERROR_FORMAT, "%s: holds %llu of the %zu bytes of samples",
                         path, (unsigned long long)got, size);
    cvol_inflater_close(inflater);
    cvol_input_close(&input);
    if (code) {
        free(*out);
        *out = NULL;
    }
    return code;
}

int cvol_strided_inflate(cvol_context *context, cvol_stored *stored, cvol_strided *strided,
                         const cvol_grid *grid, const char *path, uint64_t at, uint64_t skip,
                         size_t count)
{
    size_t bytes;
    if (!cvol_size_multiply(&bytes, count, strided->is_half ? 2 : cvol_type_size(grid->type)))
        bytes = SIZE_MAX;
    const int code = inflate_part(context, &strided->data, path, at, skip, bytes);
    strided->size = bytes;
    return code ? code : cvol_strided_take(context, stored, strided, grid, path);
}

int cvol_interleaved_read(cvol_context *context, cvol_stored *stored, const cvol_grid *grid,
                          const char *path, const char *name, int is_gzip, uint64_t skip,
                          size_t channels, size_t channel)
{
    cvol_strided strided = {.first = channel};
    size_t count;
    int code = cvol_grid_check_file(context, grid, name);
    if (code)
        return code;
    if (!cvol_size_multiply(&count, cvol_grid_samples(grid), channels) ||
        count > context->limit_bytes)
        return cvol_fail(context, CVOL_ERROR_LIMIT,
                         "%s: %zu x %zu x %zu places of %zu bytes are more than the limit of %llu "
                         "bytes",
                         name, grid->dims[0], grid->dims[1], grid->dims[2], channels,
                         (unsigned long long)context->limit_bytes);
    strided.stride[0] = channels;
    strided.stride[1] = channels * grid->dims[0];
    strided.stride[2] = strided.stride[1] * grid->dims[1];
    if (!is_gzip)
        return cvol_strided_read(context, stored, &strided, grid, path, skip, count);
    code = inflate_part(context, &strided.data, path, 0, skip, count);
    strided.size = count;
    return code ? code : cvol_strided_take(context, stored, &strided, grid, path);
}
