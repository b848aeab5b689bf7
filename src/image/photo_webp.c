/* WebP files, by libwebp. */
#include <webp/encode.h>

#include "base/context.h"
#include "image/photo.h"

#define WEBP_SIDE_MAX 16383

int cvol_photo_write_webp(cvol_context *context, const cvol_image *image, int quality,
                          const char *path)
{
    uint8_t *bytes = NULL;
    if (image->width > WEBP_SIDE_MAX || image->height > WEBP_SIDE_MAX)
        return cvol_fail(context, CVOL_ERROR_LIMIT,
                         "%s: WebP has at most %d pixels a side, the picture has %d x %d", path,
                         WEBP_SIDE_MAX, image->width, image->height);
    const size_t size = quality == 100
                            ? WebPEncodeLosslessRGBA(image->rgba, image->width, image->height,
                                                     4 * image->width, &bytes)
                            : WebPEncodeRGBA(image->rgba, image->width, image->height,
                                             4 * image->width, (float)quality, &bytes);
    const int code = size ? cvol_photo_write_bytes(context, bytes, size, path)
                          : cvol_fail_memory(context, 0, "a WebP encoder");
    WebPFree(bytes);
    return code;
}
