/* PNG files: in memory, and on disk when they are complete.
 *
 * Fast files store the difference to the row above in Huffman codes and runs: for pictures of
 * volumes they have at most a fifth more bytes, in an eighth of the time. Other files leave the
 * choice of filters to the encoder, row by row. */
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/context.h"
#include "base/file.h"
#include "image/pixels.h"
#include "image/png_encode.h"

/* zlib's levels, which cvol_image_write_png lists. */
#define LEVEL_OF_FILES 6

int cvol_png_write(cvol_context *context, const cvol_png_rows *rows, const char *path)
{
    cvol_bytes bytes;
    int code = cvol_png_encode(context, &bytes, rows, LEVEL_OF_FILES, path);
    if (!code)
        code = cvol_file_write(context, bytes.data, bytes.size, path);
    cvol_bytes_free(&bytes);
    return code;
}

/* ---- 8 bits ----------------------------------------------------------------------------- */

static int is_opaque(const cvol_image *image)
{
    size_t pixels = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < pixels; i++)
        if (image->rgba[4 * i + 3] != 255)
            return 0;
    return 1;
}

static void fetch_bytes(const cvol_png_rows *rows, uint8_t *out, int y)
{
    const size_t width = (size_t)rows->width, channels = (size_t)rows->channels;
    const uint8_t *rgba = rows->image->rgba + 4 * width * (size_t)y;
    for (size_t x = 0; x < width; x++)
        memcpy(out + channels * x, rgba + 4 * x, channels);
}

static cvol_png_rows rows_of(const cvol_image *image)
{
    return (cvol_png_rows){.width = image->width,
                           .height = image->height,
                           .channels = is_opaque(image) ? 3 : 4,
                           .bits = 8,
                           .fetch = fetch_bytes,
                           .image = image};
}

int cvol_image_write_png(cvol_context *context, const cvol_image *image, const char *path)
{
    const int code = cvol_image_need_bytes(context, image, path);
    if (code)
        return code;
    const cvol_png_rows rows = rows_of(image);
    return cvol_png_write(context, &rows, path);
}

int cvol_image_encode_png(cvol_context *context, const cvol_image *image, int level, void **out,
                          size_t *size)
{
    cvol_bytes bytes = {0};
    *out = NULL;
    *size = 0;
    int code = cvol_image_need_bytes(context, image, "PNG");
    if (!code && (level < CVOL_PNG_QUICK || level > 9))
        code = cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "PNG level %d: must be 0 to 9, or %d (quick)", level, CVOL_PNG_QUICK);
    if (code)
        return code;
    const cvol_png_rows rows = rows_of(image);
    code = cvol_png_encode(context, &bytes, &rows, level, "PNG in memory");
    if (code) {
        cvol_bytes_free(&bytes);
        return code;
    }
    *out = bytes.data;
    *size = bytes.size;
    return CVOL_OK;
}
