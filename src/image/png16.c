/* Pictures of floats as PNG files of 16 bits per channel. */
#include "image/pixels.h"

static void put_level(uint8_t *out, float level)
{
    const unsigned value = (unsigned)(level * 65535 + 0.5f);
    out[0] = (uint8_t)(value >> 8);
    out[1] = (uint8_t)value;
}

static void fetch_levels(const cvol_png_rows *rows, uint8_t *out, int y)
{
    const size_t width = (size_t)rows->width;
    const float *values = rows->image->values + 4 * width * (size_t)y;
    for (size_t x = 0; x < width; x++, values += 4) {
        float finished[4];
        cvol_pixel_finish(finished, values, rows->background);
        for (int c = 0; c < rows->channels; c++, out += 2)
            put_level(out, finished[c]);
    }
}

int cvol_image_write_png16(cvol_context *context, const cvol_image *image,
                           const double background[3], int grey, const char *path)
{
    const int code = cvol_image_need_floats(context, image, path);
    if (code)
        return code;
    const cvol_png_rows rows = {.width = image->width,
                                .height = image->height,
                                .channels = !background ? 4
                                            : grey      ? 1
                                                        : 3,
                                .bits = 16,
                                .fetch = fetch_levels,
                                .image = image,
                                .background = background};
    return cvol_png_write(context, &rows, path);
}
