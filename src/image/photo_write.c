/* Pictures as JPEG and WebP. */
#include "base/context.h"
#include "base/file.h"
#include "image/photo.h"
#include "image/pixels.h"

static int check(cvol_context *context, const cvol_image *image, int quality, int least,
                 const char *path)
{
    const int code = cvol_image_need_bytes(context, image, path);
    if (!code && (quality < least || quality > 100))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "quality is %d, must be %d to 100", quality,
                         least);
    return code;
}

int cvol_photo_write_bytes(cvol_context *context, const void *bytes, size_t size, const char *path)
{
    cvol_output *output;
    int code = cvol_output_open(context, &output, path);
    if (code)
        return code;
    code = cvol_output_write(context, output, bytes, size);
    if (!code)
        return cvol_output_commit(context, output);
    cvol_output_abandon(output);
    return code;
}

int cvol_image_write_jpeg(cvol_context *context, const cvol_image *image, int quality,
                          const char *path)
{
    const int code = check(context, image, quality, 1, path);
    return code ? code : cvol_photo_write_jpeg(context, image, quality, path);
}

int cvol_image_write_webp(cvol_context *context, const cvol_image *image, int quality,
                          const char *path)
{
    const int code = check(context, image, quality, 0, path);
    return code ? code : cvol_photo_write_webp(context, image, quality, path);
}
