/* Portable float maps: "PF" (colour) or "Pf" (grey), width and height, -1 (low byte first), each on
 * a line of its own; then rows of 32-bit floats, the lowest first (P. Debevec's format). */
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

/* Over the background, but neither rounded nor cut off. */
static void put_row(cvol_bytes *bytes, const cvol_image *image, int y, const double background[3],
                    int channels)
{
    const float *values = image->values + 4 * (size_t)image->width * (size_t)y;
    bytes->size = 0;
    for (int x = 0; x < image->width; x++, values += 4) {
        const float through = values[3] < 0 ? 1 : values[3] < 1 ? 1 - values[3] : 0;
        for (int c = 0; c < channels; c++)
            put_float(bytes, values[c] + through * (float)background[c]);
    }
}

static int write_rows(cvol_context *context, cvol_output *output, cvol_bytes *bytes,
                      const cvol_image *image, const double background[3], int grey)
{
    char head[64];
    snprintf(head, sizeof head, "P%c\n%d %d\n-1.0\n", grey ? 'f' : 'F', image->width,
             image->height);
    int code = cvol_output_write(context, output, head, strlen(head));
    for (int y = image->height - 1; y >= 0 && !code; y--) {
        put_row(bytes, image, y, background, grey ? 1 : 3);
        if (bytes->failed)
            return cvol_fail_memory(context, 12 * (size_t)image->width, "a row of pixels");
        code = cvol_output_write(context, output, bytes->data, bytes->size);
    }
    return code;
}

int cvol_image_write_pfm(cvol_context *context, const cvol_image *image, const double background[3],
                         int grey, const char *path)
{
    cvol_output *output;
    cvol_bytes bytes = {0};
    int code = cvol_image_need_floats(context, image, path);
    if (!code)
        code = cvol_output_open(context, &output, path);
    if (code)
        return code;
    code = write_rows(context, output, &bytes, image, background, grey);
    cvol_bytes_free(&bytes);
    if (!code)
        return cvol_output_commit(context, output);
    cvol_output_abandon(output);
    return code;
}
