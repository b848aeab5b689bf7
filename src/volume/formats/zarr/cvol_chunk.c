/* Chunks of codec cvol (doc/zarr.md): a .cvol file, or several behind a header. */
#include <string.h>
#include <zlib.h>

#include "base/bytes.h"
#include "base/context.h"
#include "cvol/codec.h"
#include "volume/formats/zarr/chunk.h"

static const uint8_t file_signature[8] = {0x8b, 'C', 'V', 'L', '\r', '\n', 0x1a, '\n'};
static const uint8_t chunk_signature[8] = {0x8b, 'C', 'V', 'K', '\r', '\n', 0x1a, '\n'};

enum { HEAD_BYTES = 16, VERSION = 1 };

/* The chunk's length along the stored axis k. */
static uint64_t length_along(const cvol_zarr_array *array, int k)
{
    return array->chunk[array->order[k]];
}

/* The last three axes, x first. */
static void volume_dims(size_t dims[3], const cvol_zarr_array *array)
{
    for (int i = 0; i < 3; i++)
        dims[i] = i < array->rank ? (size_t)length_along(array, array->rank - 1 - i) : 1;
}

/* Decodes one .cvol file, which must have the chunk's last three axes. */
static int decode_file(cvol_context *context, void *out, const cvol_zarr_array *array,
                       const uint8_t *data, size_t size, const char *name)
{
    static const size_t begin[3] = {0, 0, 0};
    size_t dims[3];
    cvol_array *file;
    volume_dims(dims, array);
    int code = cvol_array_read_memory(context, &file, data, size, name);
    if (code)
        return code;
    const cvol_grid *grid = cvol_array_grid(file);
    if (memcmp(grid->dims, dims, sizeof dims) || grid->type != array->type)
        code = cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: a chunk has %zu x %zu x %zu samples of %s, must have %zu x %zu x %zu "
                         "of %s",
                         name, grid->dims[0], grid->dims[1], grid->dims[2],
                         cvol_type_name(grid->type), dims[0], dims[1], dims[2],
                         cvol_type_name(array->type));
    else
        code = cvol_array_evaluate_box(context, out, file, begin, dims);
    cvol_array_free(file);
    return code;
}

static int fail_head(cvol_context *context, const char *name)
{
    return cvol_fail(context, CVOL_ERROR_FORMAT,
                     "%s: the header of a chunk of codec cvol is damaged, or not that of the array",
                     name);
}

int cvol_zarr_decode_cvol(cvol_context *context, void *out, const cvol_zarr_array *array,
                          const uint8_t *data, size_t size, const char *name)
{
    size_t dims[3];
    if (size >= 8 && !memcmp(data, file_signature, 8) && array->rank == 3)
        return decode_file(context, out, array, data, size, name);
    if (size < HEAD_BYTES || memcmp(data, chunk_signature, 8))
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: is not a chunk of codec cvol", name);
    if (data[8] != VERSION)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: a chunk of codec cvol has version %d, must be %d: a newer cvol "
                         "made it",
                         name, data[8], VERSION);
    cvol_cursor head = cvol_cursor_make(data, size);
    cvol_cursor_take(&head, HEAD_BYTES);
    int right = data[9] == array->rank;
    uint64_t count = 1;
    for (int a = 0; right && a < array->rank; a++) {
        right = cvol_cursor_u64(&head) == length_along(array, a);
        count *= a < array->rank - 3 ? length_along(array, a) : 1;
    }
    if (!right || count > cvol_cursor_left(&head) / 8)
        return fail_head(context, name);
    cvol_cursor lengths = head;
    cvol_cursor_take(&head, 8 * (size_t)count);
    const uLong sum = crc32(0, data, (uInt)head.at);
    if (head.at > UINT32_MAX || cvol_cursor_u32(&head) != sum || head.failed)
        return fail_head(context, name);
    volume_dims(dims, array);
    const size_t bytes = dims[0] * dims[1] * dims[2] * array->element;
    int code = CVOL_OK;
    for (uint64_t i = 0; !code && i < count; i++) {
        const uint64_t length = cvol_cursor_u64(&lengths);
        if (length > cvol_cursor_left(&head))
            return fail_head(context, name);
        const uint8_t *file = cvol_cursor_take(&head, (size_t)length);
        code = decode_file(context, (uint8_t *)out + i * bytes, array, file, (size_t)length, name);
    }
    return code;
}
