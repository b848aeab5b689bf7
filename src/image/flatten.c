/* From pictures of floats to bytes for display.
 *
 * A pixel is colour times opacity, P, and opacity A. Over a background B it is P + (1 - A) B. Its
 * straight colour is P / A. If a filter overshoots, so that a channel of P exceeds A, that channel
 * replaces A, and the pixel over black is right.
 *
 * Alpha is rounded first, and the colour is divided by the rounded value: over black the pixel is
 * then exact to half a level, over white to one. */
#include <math.h>
#include <string.h>

#include "base/context.h"
#include "image/pixels.h"

static int need_size(cvol_context *context, const cvol_image *image, const char *name)
{
    if (image->width >= 1 && image->height >= 1 && image->width <= CVOL_IMAGE_SIZE_MAX &&
        image->height <= CVOL_IMAGE_SIZE_MAX)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                     "%s: a picture of %d x %d pixels: width and height are 1 to %d", name,
                     image->width, image->height, CVOL_IMAGE_SIZE_MAX);
}

int cvol_image_need_bytes(cvol_context *context, const cvol_image *image, const char *name)
{
    if (!image->rgba)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s: a picture of bytes is needed", name);
    return need_size(context, image, name);
}

int cvol_image_need_floats(cvol_context *context, const cvol_image *image, const char *name)
{
    if (!image->values)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "%s: a picture of floats is needed", name);
    return need_size(context, image, name);
}

static float clamp(float x)
{
    return !(x > 0) ? 0 : x < 1 ? x : 1;
}

void cvol_pixel_finish(float out[4], const float in[4], const double background[3])
{
    float opacity = clamp(in[3]);
    if (background) {
        for (int c = 0; c < 3; c++)
            out[c] = clamp(in[c] + (1 - opacity) * (float)background[c]);
        out[3] = 1;
        return;
    }
    for (int c = 0; c < 3; c++)
        opacity = fmaxf(opacity, clamp(in[c]));
    for (int c = 0; c < 3; c++)
        out[c] = opacity > 0 ? clamp(in[c] / opacity) : 0;
    out[3] = opacity;
}

static uint8_t to_byte(float level)
{
    return (uint8_t)(clamp(level) * 255 + 0.5f);
}

static void flatten_pixel(uint8_t out[4], const float in[4], const double background[3])
{
    float finished[4];
    cvol_pixel_finish(finished, in, background);
    out[3] = to_byte(finished[3]);
    const float scale = !background && out[3] ? finished[3] * 255 / out[3] : 1;
    for (int c = 0; c < 3; c++)
        out[c] = out[3] ? to_byte(finished[c] * scale) : 0;
}

int cvol_image_flatten(cvol_context *context, cvol_image *out, const cvol_image *image,
                       const double background[3])
{
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    int code = cvol_image_need_floats(context, image, "flattening");
    if (!code)
        code = cvol_image_need_bytes(context, out, "flattening");
    if (!code && (out->width != image->width || out->height != image->height))
        code = cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "flattening: a picture of %d x %d pixels into one of %d x %d",
                         image->width, image->height, out->width, out->height);
    for (size_t i = 0; i < pixels && !code; i++)
        flatten_pixel(out->rgba + 4 * i, image->values + 4 * i, background);
    return code;
}
