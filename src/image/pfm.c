/* Portable float maps: "PF" (colour) or "Pf" (grey), width and height, -1 (low byte first), each on
 * a separate line; then rows of 32-bit floats, the lowest first (P. Debevec's format). */
#include <stdio.h>
#include <string.h>

#include "base/bytes.h"
#include "base/context.h"
#include "base/file.h"
#include "image/pixels.h"

static void put_float(cvol_bytes *bytes, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    cvol_bytes_put_u32(bytes, bits);
}

/* The planes of a picture that are written. */
typedef struct map_rows {
    const cvol_image *image;
    const double *background;
    int channels;
    enum { ROWS_OF_COLOUR, ROWS_OF_OPACITY, ROWS_OF_DEPTH } what;
} map_rows;

/* Composites over the background, without rounding or clamping. */
static void put_colours(cvol_bytes *bytes, const map_rows *rows, size_t first)
{
    const float *values = rows->image->values + 4 * first;
    for (int x = 0; x < rows->image->width; x++, values += 4) {
        const float through = values[3] < 0 ? 1 : values[3] < 1 ? 1 - values[3] : 0;
        for (int c = 0; c < rows->channels; c++)
            put_float(bytes, values[c] + through * (float)rows->background[c]);
    }
}

static void put_row(cvol_bytes *bytes, const map_rows *rows, int y)
{
    const size_t width = (size_t)rows->image->width, first = width * (size_t)y;
    bytes->size = 0;
    if (rows->what == ROWS_OF_COLOUR)
        put_colours(bytes, rows, first);
    for (size_t x = 0; x < width && rows->what == ROWS_OF_OPACITY; x++) {
        const float opacity = rows->image->values[4 * (first + x) + 3];
        put_float(bytes, opacity > 0 ? opacity < 1 ? opacity : 1 : 0);
    }
    for (size_t x = 0; x < width && rows->what == ROWS_OF_DEPTH; x++)
        put_float(bytes, rows->image->depth[first + x]);
}

static int write_rows(cvol_context *context, cvol_output *output, cvol_bytes *bytes,
                      const map_rows *rows)
{
    char head[64];
    const cvol_image *image = rows->image;
    snprintf(head, sizeof head, "P%c\n%d %d\n-1.0\n", rows->channels == 1 ? 'f' : 'F', image->width,
             image->height);
    int code = cvol_output_write(context, output, head, strlen(head));
    for (int y = image->height - 1; y >= 0 && !code; y--) {
        put_row(bytes, rows, y);
        if (bytes->failed)
            return cvol_fail_memory(context, 12 * (size_t)image->width, "a row of pixels");
        code = cvol_output_write(context, output, bytes->data, bytes->size);
    }
    return code;
}

static int write_map(cvol_context *context, const map_rows *rows, const char *path)
{
    cvol_output *output;
    cvol_bytes bytes = {0};
    int code = cvol_output_open(context, &output, path);
    if (code)
        return code;
    code = write_rows(context, output, &bytes, rows);
    cvol_bytes_free(&bytes);
    return cvol_output_end(context, output, code);
}

int cvol_image_write_pfm(cvol_context *context, const cvol_image *image, const double background[3],
                         int grey, const char *path)
{
    const map_rows rows = {image, background, grey ? 1 : 3, ROWS_OF_COLOUR};
    const int code = cvol_image_need_floats(context, image, path);
    return code ? code : write_map(context, &rows, path);
}

int cvol_image_write_opacity(cvol_context *context, const cvol_image *image, const char *path)
{
    const map_rows rows = {image, NULL, 1, ROWS_OF_OPACITY};
    const int code = cvol_image_need_floats(context, image, path);
    return code ? code : write_map(context, &rows, path);
}

int cvol_image_write_depth(cvol_context *context, const cvol_image *image, const char *path)
{
    const map_rows rows = {image, NULL, 1, ROWS_OF_DEPTH};
    if (!image->depth)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s: this picture has no depths", path);
    return write_map(context, &rows, path);
}
